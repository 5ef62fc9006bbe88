//! Maps in a file as rounded images (the paper's future work: "wavelet analysis", and what it calls further compression of maps).
//!
//! All numbers are rounded so that each adds as much to the squared error (reverse water-filling): off by ε, a weight adds ε² times the
//! square of its component, Σ_d V²; a number of a view map ε² Σ_t U_t² over the texels of the cluster; a mean n ε². The Haar transform is
//! orthonormal, so that what rounding adds is known before anything is decoded, and the step is the largest that stays within the allowance.
//! The surface map of a channel goes across clusters, at whose borders weights jump: whether the Haar basis or the plain image is shorter is
//! decided for each kind of map by the entropy of its codes. View maps and means mostly gain from it, surface maps only where clusters
//! are few.

use crate::images::{Images, coded, scale};
use crate::layout::Layout;
use crate::model::Model;
use prt_transfer::numbers::{Numbers, code};
use prt_transfer::{LightBasis, ResponseBasis, TransferMatrix};
use rayon::prelude::*;

/// Surface map, view maps and mean map.
pub(crate) const KINDS: usize = 3;
/// Steps by which the step is looked for, and the factor over the first guess that it is looked for in.
const HALVINGS: usize = 10;
const RANGE: f64 = 32.0;

/// What is kept to write a file: images, which of them are waves, and their steps.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Maps {
    /// X x Y and Z x W.
    pub(crate) sizes: [[usize; 2]; 2],
    pub(crate) waves: [bool; KINDS],
    pub(crate) scales: [Vec<f32>; KINDS],
}

/// X x Y and Z x W where the matrix says; else lines.
pub(crate) fn sizes(matrix: &TransferMatrix) -> [[usize; 2]; 2] {
    let texels = match matrix.responses() {
        ResponseBasis::Radiance { texels, .. } => [texels.width, texels.height],
        _ => [matrix.shape().samples, 1],
    };
    let directions = match *matrix.basis() {
        LightBasis::LatLong { width, height } => [width, height],
        LightBasis::Cubemap { resolution } => [resolution, 6 * resolution],
        _ => [matrix.lights(), 1],
    };
    [texels, directions]
}

/// Images of each kind of map.
pub(crate) fn images(layout: &Layout, sizes: [[usize; 2]; 2]) -> [Images; KINDS] {
    let of_texels = layout.fields() * layout.vectors() * layout.components;
    [
        Images { groups: 1, images: of_texels, size: sizes[0] },
        Images { groups: layout.clusters(), images: layout.run(), size: sizes[1] },
        Images { groups: 1, images: layout.shape.responses, size: sizes[0] },
    ]
}

/// One kind of map, taken apart, and what the square of an error in each of its images counts.
struct Kind {
    images: Images,
    /// As it is, and in the Haar basis.
    taken: [Vec<f64>; 2],
    weights: Vec<f64>,
}

impl Kind {
    /// The step of each image where `step` is that of weight 1.
    fn scales(&self, waves: bool, step: f64) -> Vec<f32> {
        let pixels = self.images.pixels();
        let taken = &self.taken[usize::from(waves)];
        let of_image = |(image, weight): (usize, &f64)| {
            let step = if *weight > 0.0 { step / weight.sqrt() } else { 0.0 };
            scale(&taken[image * pixels..(image + 1) * pixels], step)
        };
        self.weights.par_iter().enumerate().map(of_image).collect()
    }

    /// What rounding adds.
    fn added(&self, waves: bool, step: f64) -> f64 {
        let (pixels, scales) = (self.images.pixels().max(1), self.scales(waves, step));
        let of_image = |((image, scale), weight): ((&[f64], &f32), &f64)| {
            let scale = f64::from(*scale);
            let error = image.iter().map(|v| (v - f64::from(code(*v, scale)) * scale).powi(2)).sum::<f64>();
            error * weight
        };
        let each = self.taken[usize::from(waves)].par_chunks(pixels).zip(&scales).zip(&self.weights).map(of_image);
        each.collect::<Vec<f64>>().iter().sum()
    }

    /// Whether waves can be stored: common parts of an image may be larger than any number of it.
    fn fits(&self) -> bool {
        self.taken[1].par_iter().all(|v| v.abs() < f64::from(f32::MAX) / 2.0)
    }

    /// Bits of all codes by their entropy.
    fn bits(&self, waves: bool, step: f64) -> f64 {
        let taken = &self.taken[usize::from(waves)];
        let codes = coded(taken, self.images.pixels(), &self.scales(waves, step));
        let mut counts = vec![0u32; 1 << 16];
        (0..codes.len()).for_each(|at| counts[(codes.stored(at) as i32 + (1 << 15)) as usize] += 1);
        let whole = taken.len() as f64;
        counts.iter().filter(|c| **c > 0).map(|c| f64::from(*c) * (whole / f64::from(*c)).log2()).sum()
    }
}

impl Maps {
    /// Steps with which rounding a model adds about `allowed` to Σ(T-T̃)².
    pub(crate) fn of(model: &Model, sizes: [[usize; 2]; 2], allowed: f64) -> Maps {
        let of_kind = images(&model.layout, sizes);
        let values = [&model.surface, &model.views, &model.means];
        let weights = weights(model);
        let mut weights = weights.into_iter();
        let kinds: [Kind; KINDS] = std::array::from_fn(|i| Kind {
            images: of_kind[i],
            taken: [false, true].map(|waves| of_kind[i].taken(values[i], waves)),
            weights: weights.next().unwrap_or_default(),
        });
        let numbers: usize = values.iter().map(|v| v.len()).sum();
        let first = (12.0 * allowed / numbers.max(1) as f64).sqrt();
        let step = largest(&kinds, [true; KINDS], first, allowed);
        let waves = std::array::from_fn(|i| kinds[i].fits() && kinds[i].bits(true, step) < kinds[i].bits(false, step));
        let step = largest(&kinds, waves, first, allowed);
        Maps { sizes, waves, scales: std::array::from_fn(|i| kinds[i].scales(waves[i], step)) }
    }

    /// Codes of one kind of map.
    pub(crate) fn coded(&self, layout: &Layout, kind: usize, values: &[f32]) -> Numbers {
        let images = images(layout, self.sizes)[kind];
        coded(&images.taken(values, self.waves[kind]), images.pixels(), &self.scales[kind])
    }

    /// What codes stand for.
    pub(crate) fn restored(&self, layout: &Layout, kind: usize, codes: &Numbers) -> Vec<f32> {
        images(layout, self.sizes)[kind].restored(codes, self.waves[kind])
    }
}

/// The largest step that adds no more than `allowed`: rounding to steps Δ adds Δ²/12 for each number while these are larger, and less where
/// most are 0.
fn largest(kinds: &[Kind; KINDS], waves: [bool; KINDS], first: f64, allowed: f64) -> f64 {
    let (mut least, mut ratio) = (first / RANGE.sqrt(), RANGE.sqrt());
    for _ in 0..HALVINGS {
        let step = least * ratio;
        let added: f64 = kinds.iter().zip(waves).map(|(kind, waves)| kind.added(waves, step)).sum();
        if added <= allowed {
            least = step;
        }
        ratio = ratio.sqrt();
    }
    least
}

/// What the square of an error in an image counts.
fn weights(model: &Model) -> [Vec<f64>; KINDS] {
    let layout = &model.layout;
    let (k, vectors) = (layout.components, layout.vectors());
    let mut of_views = vec![0f64; layout.view_vectors()];
    let run = vectors * k;
    for (at, own) in model.surface.chunks_exact(run.max(1)).enumerate() {
        let cluster = layout.cluster_of_id(at, model.members[at]);
        for (place, j) in (0..layout.channels()).flat_map(|place| (0..k).map(move |j| (place, j))) {
            let weight = f64::from(own[place.min(vectors - 1) * k + j]);
            of_views[cluster * layout.run() + place * k + j] += weight.powi(2);
        }
    }
    // Components are of one length, up to the square roots of weights of directions.
    let of_surface = vec![model.vector; layout.fields() * vectors * k];
    [of_surface, of_views, vec![layout.shape.lights as f64; layout.shape.responses]]
}

#[cfg(test)]
mod tests {
    use crate::{Clusters, Maps, Slf, SlfParams};
    use prt_transfer::responses::Directions;
    use prt_transfer::texels::{Border, Texels};
    use prt_transfer::{Codec, Configure, LightBasis, Quiet, ResponseBasis, TransferMatrix};

    fn waves(element: impl Fn(f64, f64, f64) -> f64, clusters: usize) -> [bool; 3] {
        let (texels, basis) =
            (Texels { width: 20, height: 15, border: Border::Clamp }, LightBasis::LatLong { width: 16, height: 9 });
        let values = (0..300 * 3 * 144).map(|i| {
            let [u, v] = texels.centre(i / 432);
            element(u, v, (i % 144) as f64 / 144.0) as f32
        });
        let matrix = TransferMatrix::from_dense(values.collect(), 900, 3, basis).unwrap();
        let matrix = matrix.with_responses(ResponseBasis::Radiance { texels, directions: Directions::World }).unwrap();
        let clusters = Clusters::Number(clusters);
        let params = SlfParams { clusters, components: 2, maps: Maps::Haar, noise: 0.3, ..Default::default() };
        Slf::new(params).unwrap().encode(&matrix, &Quiet).unwrap().maps.unwrap().waves
    }

    #[test]
    fn maps_of_smooth_fields_become_waves() {
        let smooth = |u: f64, v: f64, d: f64| 1.0 + u * v + (2.0 * u + 5.0 * d).sin() + 0.1 * (9.0 * d * v).cos();
        assert_eq!(waves(smooth, 1), [true; 3]);
    }

    #[test]
    fn clusters_interrupt_the_surface_map() {
        // A field that clusters cut into many pieces whose weights have nothing to do with one another.
        let glossy = |u: f64, v: f64, d: f64| 1.0 + u + (-40.0 * ((3.0 * u + 2.0 * v) % 1.0 - d).powi(2)).exp();
        let [surface, _, mean] = waves(glossy, 60);
        assert!(mean && !surface);
    }
}
