//! Operations that relighting counts.

mod common;

use common::*;
use prt_slf::{Clusters, Colour, EncodedSlf, SlfParams, Width};
use prt_transfer::numbers::UNIT;
use prt_transfer::{Encoded, Flops, Restore, Sink, Source};

const WIDTHS: [Width; 3] = [Width::F32, Width::F16, Width::I16];

/// 1, -1 and 0 over and over, as a kernel meets them that multiplies what is stored by `unit`.
fn ones(width: Width, unit: f32, count: usize) -> Vec<u8> {
    let one = 1.0 / unit;
    let stored = [one, -one, 0.0].map(|number| match width {
        Width::F32 => number.to_le_bytes().to_vec(),
        Width::F16 => half::f16::from_f32(number).to_le_bytes().to_vec(),
        Width::I16 => (number as i16).to_le_bytes().to_vec(),
    });
    stored.into_iter().cycle().take(count).flatten().collect()
}

#[test]
fn operations_are_those_of_the_formula_and_factors_of_one_are_known() {
    let matrix = smooth();
    let (shape, k) = (matrix.shape(), 2u64);
    for colour in [Colour::Shared, Colour::Separate, Colour::Joint] {
        for (surface, views) in WIDTHS.into_iter().flat_map(|surface| WIDTHS.map(|views| (surface, views))) {
            let params = SlfParams {
                surface,
                views,
                colour,
                clusters: Clusters::Number(5),
                components: 2,
                ..Default::default()
            };
            let mut sink = Sink::new();
            encoded(params, &matrix).write(&mut sink);
            let mut sections = sink.into_sections();
            let mut fill = |name: &str, width: Width, unit: f32| -> u64 {
                let bytes = &mut sections.iter_mut().find(|s| s.name == name).unwrap().bytes;
                let count = bytes.len() / width.bytes();
                *bytes = ones(width, unit, count);
                (0..count).filter(|i| i % 3 < 2).count() as u64
            };
            // View maps meet the light first, times a power of two where they are 16 bits wide.
            let of_views = fill("basis/views", views, if views == Width::F32 { 1.0 } else { UNIT });
            let [of_surface, of_means] = ["weights/surface", "weights/mean"].map(|name| fill(name, surface, 1.0));
            // Scales of which the product is 1 where weights and view maps have both, and only then.
            for (name, unit) in
                [("basis/views-scales", 0.5 * UNIT), ("weights/surface-scales", 2.0), ("weights/mean-scales", 1.0)]
            {
                if let Some(section) = sections.iter_mut().find(|s| s.name == name) {
                    let count = section.bytes.len() / 4;
                    section.bytes = unit.to_le_bytes().repeat(count);
                }
            }
            let slf = EncodedSlf::read(shape, &mut Source::new(sections).unwrap()).unwrap();
            let Flops { multiplications, additions, by_one } = slf.flops(&vec![0.5; shape.lights]);
            let tiles = slf.tiles() as u64;
            let products = tiles * k * shape.lights as u64 + shape.rows() as u64 * (1 + k);
            let [of_weights, of_components] = [surface, views].map(|width| u64::from(width != Width::F32));
            let scales = tiles * (k * (of_weights + of_components) + of_weights);
            let what = format!("{colour:?} {surface:?} {views:?}");
            assert_eq!([multiplications, additions], [products + scales, products + shape.lights as u64], "{what}");
            // A weight that channels share is a factor in each.
            let uses = if colour == Colour::Joint { 3 } else { 1 };
            assert!(of_views > 0 && of_surface > 0 && of_means > 0);
            let of_scales = tiles * (k * of_weights * of_components + of_weights);
            assert_eq!(by_one, of_views + uses * of_surface + of_means + of_scales, "{what}");
        }
    }
}
