//! `haar`: the orthonormal Haar transform of the six faces of a cubemap.

use crate::pyramid;
use crate::select::{LightSelect, keep_light};
use ndarray::{ArrayView2, ArrayViewMut2};
use prt_transfer::transform::wrong_basis;
use prt_transfer::{Configure, Count, Flops, LightBasis, LightTransform, NoCount, Params, Result, Tally, Transform};

prt_transfer::choices! {
    /// The metric in which the transform is orthonormal.
    pub enum Scale {
        /// Texels count alike: energy dropped from a row is Σ ΔT².
        None = "none",
        /// Rows are divided by √dω and lights multiplied by it, so that energy dropped from a row is Σ ΔT²/dω, the
        /// squared error of the transfer function over the sphere; dω is the solid angle of a texel in sr.
        Sphere = "sphere",
    }
}

prt_transfer::params! {
    /// Orthonormal Haar wavelets on each face of a cubemap whose resolution is a power of two.
    pub struct HaarParams: "haar" {
        /// The metric: none (texels count alike) or sphere (texels count by solid angle).
        scale: Scale = Scale::None,
        /// Coefficients kept of each channel of a light when it relights; 0 = all. Rows keep theirs.
        light_terms: usize = 0,
        /// Which they are: plain (largest magnitude) or area (magnitude times the root of the wavelet's area); needs light_terms.
        light_select: LightSelect = LightSelect::Plain,
    }
}

/// The light transform. `B` is an orthonormal matrix (after √dω where `scale=sphere`), so dropped energy is squared error.
///
/// Coefficients come face by face, +x, -x, +y, -y, +z, -z, and within a face from coarse to fine: coefficient 0 is the
/// face's mean times its resolution; for n = 1, 2, 4, …, resolution/2 the n x n grid of horizontal differences is at
/// `n²..2n²`, that of vertical ones at `2n²..3n²`, that of diagonal ones at `3n²..4n²`, in rows from the face's top.
///
/// With `light_terms` relighting approximates the light too: it is then not linear in the light, and differs from decoded
/// rows times light by what the dropped coefficients would have added.
pub struct Haar(HaarParams);

/// [`Haar`] on a cubemap. With R its resolution, the transform of a light takes 8 (R²-1) multiplications and 16 (R²-1)
/// additions; `scale=sphere` adds 6 R² multiplications, `light_select=area` another 6 R².
pub struct BoundHaar {
    resolution: usize,
    /// √dω of one face's texels, and 1/√dω.
    roots: Option<[Vec<f32>; 2]>,
    light_terms: usize,
    light_select: LightSelect,
}

impl Configure for Haar {
    type Params = HaarParams;
    fn new(params: HaarParams) -> Result<Haar> {
        if params.light_terms == 0 && params.light_select != LightSelect::Plain {
            return Err(HaarParams::refuse("light_terms", 0, "at least 1 where light_select=area is given"));
        }
        Ok(Haar(params))
    }
    fn params(&self) -> &HaarParams {
        &self.0
    }
}

impl Transform for Haar {
    type Bound = BoundHaar;
    fn bind(&self, basis: &LightBasis) -> Result<BoundHaar> {
        let LightBasis::Cubemap { resolution } = *basis else {
            return Err(wrong_basis("haar", "a cubemap", basis));
        };
        if !resolution.is_power_of_two() {
            return Err(wrong_basis("haar", "a cubemap whose resolution is a power of two", basis));
        }
        let roots = (self.0.scale == Scale::Sphere).then(|| {
            let roots: Vec<f64> =
                basis.solid_angles().into_iter().flatten().take(resolution * resolution).map(f64::sqrt).collect();
            [roots.iter().map(|&r| r as f32).collect(), roots.iter().map(|&r| (1.0 / r) as f32).collect()]
        });
        Ok(BoundHaar { resolution, roots, light_terms: self.0.light_terms, light_select: self.0.light_select })
    }
}

/// `out` = `numbers` · `factors`, element by element.
fn product<C: Count>(numbers: &[f32], factors: &[f32], out: &mut [f32], count: &mut C) {
    out.iter_mut().zip(numbers.iter().zip(factors)).for_each(|(out, (n, f))| *out = n * f);
    count.multiply(factors.len());
}

impl BoundHaar {
    fn texels(&self) -> usize {
        self.resolution * self.resolution
    }

    /// Coefficients of six faces, each multiplied by `factors` first.
    fn forward<C: Count>(&self, faces: &[f32], factors: Option<&[f32]>, out: &mut [f32], count: &mut C) {
        let (n, texels) = (self.resolution, self.texels());
        let mut scratch = vec![0f32; pyramid::scratch(n)];
        let mut scaled = vec![0f32; factors.map_or(0, <[f32]>::len)];
        for (face, out) in faces.chunks_exact(texels).zip(out.chunks_exact_mut(texels)) {
            match factors {
                None => pyramid::forward(face, out, n, &mut scratch, count),
                Some(factors) => {
                    product(face, factors, &mut scaled, count);
                    pyramid::forward(&scaled, out, n, &mut scratch, count);
                }
            }
        }
    }

    /// What the codec multiplies, from one channel of a light.
    fn light<C: Count>(&self, light: &[f32], out: &mut [f32], count: &mut C) {
        self.forward(light, self.roots.as_ref().map(|[root, _]| &root[..]), out, count);
        if self.light_terms > 0 {
            keep_light(out, self.resolution, self.light_terms, self.light_select, count);
        }
    }
}

impl LightTransform for BoundHaar {
    fn output(&self) -> LightBasis {
        LightBasis::Plain { lights: 6 * self.texels() }
    }

    fn row_into(&self, row: &[f32], out: &mut [f32]) {
        self.forward(row, self.roots.as_ref().map(|[_, inverse]| &inverse[..]), out, &mut NoCount);
    }

    fn restore_row_into(&self, coefficients: &[f32], out: &mut [f32]) {
        let (n, texels) = (self.resolution, self.texels());
        let mut scratch = vec![0f32; pyramid::scratch(n)];
        for (from, face) in coefficients.chunks_exact(texels).zip(out.chunks_exact_mut(texels)) {
            pyramid::inverse(from, face, n, &mut scratch);
            if let Some([root, _]) = &self.roots {
                face.iter_mut().zip(root).for_each(|(t, r)| *t *= r);
            }
        }
    }

    fn light_into(&self, lights: ArrayView2<f32>, mut out: ArrayViewMut2<f32>) {
        let mut coefficients = vec![0f32; lights.nrows()];
        for (light, mut out) in lights.columns().into_iter().zip(out.columns_mut()) {
            self.light(&light.to_vec(), &mut coefficients, &mut NoCount);
            out.iter_mut().zip(&coefficients).for_each(|(out, c)| *out = *c);
        }
    }

    fn derived_bytes(&self) -> usize {
        self.roots.iter().flatten().map(|roots| size_of_val(&roots[..])).sum()
    }

    fn flops(&self, light: &[f32]) -> Flops {
        let mut tally = Tally::default();
        self.light(light, &mut vec![0f32; light.len()], &mut tally);
        tally.0
    }
}
