//! The innermost sums of relighting.

use pulp::{Arch, Simd, WithSimd};

/// Directions that are added up in single precision.
const BLOCK: usize = 64;
/// Strands of a dot product.
const LANES: usize = 8;

/// `sums` (lights x run) += lightsᵀ · `tile` (directions x run); `planes` is lights x directions.
pub(crate) fn project(tile: &[f32], run: usize, planes: &[f32], sums: &mut [f64]) {
    if run == 0 {
        return;
    }
    let directions = tile.len() / run;
    let mut partial = vec![0f32; run];
    for (plane, sums) in planes.chunks_exact(directions.max(1)).zip(sums.chunks_exact_mut(run)) {
        for (tile, plane) in tile.chunks(BLOCK * run).zip(plane.chunks(BLOCK)) {
            partial.fill(0.0);
            Arch::new().dispatch(Add { tile, plane, sums: &mut partial });
            sums.iter_mut().zip(&partial).for_each(|(sum, part)| *sum += f64::from(*part));
        }
    }
}

/// `sums` += Σ_d plane_d · (run d of the tile).
struct Add<'a> {
    tile: &'a [f32],
    plane: &'a [f32],
    sums: &'a mut [f32],
}

impl WithSimd for Add<'_> {
    type Output = ();
    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let run = self.sums.len();
        for (own, x) in self.tile.chunks_exact(run).zip(self.plane) {
            for (sum, v) in self.sums.iter_mut().zip(own) {
                *sum += x * v;
            }
        }
    }
}

/// Σ a_j b_j.
#[inline(always)]
pub(crate) fn dot(a: &[f32], b: &[f32]) -> f32 {
    let mut sums = [0f32; LANES];
    let ((a, rest_of_a), (b, rest_of_b)) = (a.as_chunks::<LANES>(), b.as_chunks::<LANES>());
    for (a, b) in a.iter().zip(b) {
        for i in 0..LANES {
            sums[i] += a[i] * b[i];
        }
    }
    let rest: f32 = rest_of_a.iter().zip(rest_of_b).map(|(a, b)| a * b).sum();
    sums.iter().sum::<f32>() + rest
}

#[cfg(test)]
mod tests {
    use super::*;
    use prt_transfer::random::Random;

    fn close(found: f64, terms: impl Iterator<Item = f64>) -> bool {
        let (sum, size) = terms.fold((0.0, 0.0), |(sum, size), term| (sum + term, size + term.abs()));
        (found - sum).abs() <= 1e-5 * size
    }

    #[test]
    fn products_are_their_sums_for_every_number_of_components_and_directions() {
        let mut random = Random(4);
        let mut draw = |count: usize| (0..count).map(|_| random.normal() as f32).collect::<Vec<f32>>();
        for k in 0..40 {
            let (a, b) = (draw(k), draw(k));
            assert!(close(dot(&a, &b).into(), a.iter().zip(&b).map(|(a, b)| f64::from(*a) * f64::from(*b))), "{k}");
        }
        for (run, directions, lights) in [(0, 5, 1), (1, 1, 1), (3, 64, 2), (9, 65, 3), (17, 200, 1)] {
            let (tile, planes) = (draw(run * directions), draw(lights * directions));
            let mut sums = vec![1.0; lights * run];
            project(&tile, run, &planes, &mut sums);
            for (at, sum) in sums.iter().enumerate() {
                let (light, j) = (at / run, at % run);
                let term = |d: usize| f64::from(planes[light * directions + d]) * f64::from(tile[d * run + j]);
                assert!(close(sum - 1.0, (0..directions).map(term)), "{run} x {directions} x {lights}");
            }
        }
    }
}
