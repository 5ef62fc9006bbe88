//! The largest matrix that each method takes in so much memory: `prt methods --limits`.

use crate::registry::families::{Kind, families};
use crate::{number, room, table};
use prt_transfer::{Extent, LightBasis, Registry, Shape};
use serde::Serialize;

/// Texels of light along an edge of the cubemap.
const RESOLUTION: usize = 32;
/// Local directions of a sample of biscale.
const DIRECTIONS: usize = 64;
/// More samples than anyone has.
const MOST: usize = 1 << 40;

/// What a method takes. The names are a promise to programs that read them.
#[derive(Debug, Serialize)]
pub struct Limit {
    /// The family's label, at its defaults.
    pub method: String,
    /// Vertices of a diffuse signal: dense rows of 6 x 32 x 32.
    pub diffuse_vertices: Option<usize>,
    /// Bytes of that matrix.
    pub diffuse_bytes: Option<u64>,
    /// Vertices of a biscale signal: sparse, 64 rows of 6 x 32 x 32 each.
    pub biscale_vertices: Option<usize>,
    /// Bytes of that matrix.
    pub biscale_bytes: Option<u64>,
}

/// The limit of every family on either signal, with the matrix in `memory` and on rayon's current pool.
pub fn of(registry: &Registry, memory: u64) -> anyhow::Result<Vec<Limit>> {
    let on = |kind| families(registry, kind).into_iter().map(|family| family.base).collect::<Vec<&str>>();
    let (diffuse, biscale) = (on(Kind::Diffuse), on(Kind::Biscale));
    let more = biscale.iter().filter(|base| !diffuse.contains(base));
    let limit = |base: &str| -> anyhow::Result<Limit> {
        let most = |bases: &[&str], extent| {
            if bases.contains(&base) { largest(registry, base, memory, extent) } else { Ok(None) }
        };
        let (of_diffuse, of_biscale) = (most(&diffuse, self::diffuse)?, most(&biscale, self::biscale)?);
        Ok(Limit {
            method: base.into(),
            diffuse_vertices: of_diffuse,
            diffuse_bytes: of_diffuse.map(|samples| self::diffuse(samples).bytes()),
            biscale_vertices: of_biscale,
            biscale_bytes: of_biscale.map(|samples| self::biscale(samples).bytes()),
        })
    };
    diffuse.iter().chain(more).map(|base| limit(base)).collect()
}

/// A line for each method.
pub fn text(limits: &[Limit], memory: u64) -> String {
    let size = |vertices: Option<usize>, bytes: Option<u64>| match (vertices, bytes) {
        (Some(vertices), Some(bytes)) => [number::count(vertices as u64), number::bytes(bytes)],
        _ => ["-".into(), "-".into()],
    };
    let line = |limit: &Limit| -> Vec<String> {
        let Limit { diffuse_vertices, diffuse_bytes, biscale_vertices, biscale_bytes, .. } = *limit;
        let sizes = [size(diffuse_vertices, diffuse_bytes), size(biscale_vertices, biscale_bytes)];
        std::iter::once(limit.method.clone()).chain(sizes.into_iter().flatten()).collect()
    };
    let titles = ["method", "diffuse vertices", "matrix", "biscale vertices", "matrix"];
    let legend = format!(
        "In {} with the matrix and the file's making: cubemap:{RESOLUTION}, {DIRECTIONS} local directions, half of the texels seen. Measured models, from above.",
        number::bytes(memory)
    );
    format!("{}\n{legend}", table::aligned(&titles, limits.iter().map(line)))
}

/// The most samples of a signal that fit; `None` where nobody knows what the method takes.
fn largest(
    registry: &Registry,
    label: &str,
    memory: u64,
    extent: fn(usize) -> Extent,
) -> anyhow::Result<Option<usize>> {
    let (method, basis) = (registry.method(&label.parse()?)?, LightBasis::Cubemap { resolution: RESOLUTION });
    let fits = |samples: usize| -> anyhow::Result<Option<bool>> {
        let extent = extent(samples);
        let footprint = method.footprint(&extent, &basis)?;
        Ok(footprint.map(|footprint| extent.bytes().saturating_add(room::of_encoding(footprint)) <= memory))
    };
    // Doubled until it does not fit, then bisected.
    let (mut least, mut most) = (0, 1);
    while most < MOST {
        match fits(most)? {
            None => return Ok(None),
            Some(true) => (least, most) = (most, 2 * most),
            Some(false) => break,
        }
    }
    while most - least > 1 {
        let middle = least + (most - least) / 2;
        if fits(middle)? == Some(true) { least = middle } else { most = middle }
    }
    Ok(Some(least))
}

fn diffuse(samples: usize) -> Extent {
    let lights = 6 * RESOLUTION * RESOLUTION;
    let shape = Shape { samples, responses: 1, lights };
    Extent { shape, non_zeros: (samples * lights / 2) as u64, sparse: false }
}

fn biscale(samples: usize) -> Extent {
    Extent { shape: Shape { responses: DIRECTIONS, ..diffuse(samples).shape }, sparse: true, ..diffuse(samples) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::registry::registry;

    #[test]
    fn sizes_that_only_a_header_can_claim_are_told_of_too() {
        let registry = registry();
        let claims = [
            [1 << 39, 1, 1 << 11],
            [1 << 26, 1, 1 << 24],
            [1, 1 << 26, 1 << 24],
            [1 << 25, 1 << 25, 1],
            [1 << 40, 1 << 20, 1 << 16],
        ];
        for codec in registry.codecs() {
            let method = registry.method(&codec.name.parse().unwrap()).unwrap();
            for ([samples, responses, lights], sparse) in
                claims.into_iter().flat_map(|claim| [(claim, false), (claim, true)])
            {
                let shape = Shape { samples, responses, lights };
                let extent = Extent { shape, non_zeros: 1 << 50, sparse };
                let told = method.footprint(&extent, &LightBasis::Plain { lights }).unwrap().unwrap();
                assert!(
                    told.peak >= 1 << 20 && room::of_encoding(told) < 1 << 62,
                    "{} {shape:?}: {told:?}",
                    codec.name
                );
            }
        }
    }

    #[test]
    fn every_method_has_a_limit_that_grows_with_memory_and_none_needs_less_than_its_matrix() {
        let registry = registry();
        let [small, large] = [1_000_000_000, 16_000_000_000].map(|memory| of(&registry, memory).unwrap());
        for (a, b) in small.iter().zip(&large) {
            assert!(b.diffuse_vertices.or(b.biscale_vertices).is_some(), "{}: no footprint", b.method);
            assert!(
                a.diffuse_vertices <= b.diffuse_vertices && a.biscale_vertices <= b.biscale_vertices,
                "{a:?} {b:?}"
            );
            assert!([b.diffuse_bytes, b.biscale_bytes].iter().flatten().all(|bytes| *bytes < 16_000_000_000), "{b:?}");
        }
        assert!(text(&large, 16_000_000_000).lines().count() > large.len());
    }
}
