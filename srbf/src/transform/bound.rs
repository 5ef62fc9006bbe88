//! The transform on one basis.

use super::lobes::Lobes;
use super::lower::Lower;
use super::moments::Moments;
use super::params::{Centers, Coordinates, Ridge, SrbfParams};
use super::ridge::Regularised;
use crate::kernel::Kernel;
use crate::light::ScatteredLight;
use ndarray::{Array2, ArrayView2, ArrayViewMut2, Axis};
use prt_transfer::basis::Direction;
use prt_transfer::params::Value;
use prt_transfer::sections::broken;
use prt_transfer::transform::wrong_basis;
use prt_transfer::{Count, Error, Flops, LightBasis, LightTransform, NoCount, Result, Sink, Source, Tally, linalg};

/// [`crate::Srbf`] on a grid of texels. With b moments (those that are not negligible) the transform of a light takes b multiplications
/// and as many additions; orthonormal coordinates of n lobes take n (n+1)/2 multiplications and n (n-1)/2 additions more.
pub struct BoundSrbf {
    params: SrbfParams,
    lobes: Lobes,
    moments: Moments,
    /// 1/dω of each texel in 1/sr.
    inverse_angles: Vec<f64>,
    lower: Lower,
    ridge: f64,
}

/// Texels whose values are brought together at a time: a cache line of each row.
const TILE: usize = 16;

impl BoundSrbf {
    /// With this ridge, whatever the parameters say.
    pub(super) fn new(params: &SrbfParams, lobes: Lobes, ridge: Ridge, basis: &LightBasis) -> Result<BoundSrbf> {
        let moments = Moments::new(&lobes, basis)?;
        let angles = basis.solid_angles().unwrap_or_default();
        let inverse_angles: Vec<f64> = angles.into_iter().map(|a| 1.0 / a).collect();
        let regularised = Regularised::new(&moments.gram(&inverse_angles, lobes.len()), ridge);
        let needed = || format!("texels that tell {} lobes apart, or a larger ridge", lobes.len());
        let regularised = regularised.ok_or_else(|| wrong_basis("srbf", &needed(), basis))?;
        let (lower, ridge) = (Lower::new(&regularised.factor), regularised.share);
        Ok(BoundSrbf { params: params.clone(), lobes, moments, inverse_angles, lower, ridge })
    }

    /// Unit directions of the lobes.
    pub fn centers(&self) -> &[Direction] {
        &self.lobes.centers
    }

    /// One for each centre.
    pub fn bandwidths(&self) -> &[f64] {
        &self.lobes.bandwidths
    }

    /// The kernel of all lobes.
    pub fn kernel(&self) -> Kernel {
        self.lobes.kernel
    }

    /// G = B D⁻¹ Bᵀ: inner products over the sphere of the lobes as they are averaged over texels, without the ridge. Computed at each
    /// call.
    pub fn gram(&self) -> Array2<f64> {
        self.moments.gram(&self.inverse_angles, self.lobes.len())
    }

    /// The ridge as a share of G's mean diagonal: what was added to the diagonal before G was factored, 0 where nothing was.
    pub fn ridge(&self) -> f64 {
        self.ridge
    }

    /// The condition number of G without the ridge, by its eigenvalues: in the cube of the number of lobes, at each call. Infinite where
    /// G is singular.
    ///
    /// # Errors
    /// As [`linalg::eigenvalues`].
    pub fn condition(&self) -> Result<f64> {
        let [largest, least] = self.extremes()?;
        Ok(if least > 0.0 { largest / least } else { f64::INFINITY })
    }

    /// The largest and the least eigenvalue of G without the ridge, the latter below 0 by rounding where G is singular.
    ///
    /// # Errors
    /// As [`linalg::eigenvalues`].
    pub fn extremes(&self) -> Result<[f64; 2]> {
        let values = linalg::eigenvalues(self.gram().view())?;
        Ok([values[0], values[values.len() - 1]])
    }

    /// How lobes of a light (of the same kernel) become the coefficients that C's columns multiply: lobes x others, in sr.
    ///
    /// A_jl = ∫ G_j H_l dω by closed forms (Eq. 13), so that C·A·w relights with the light Σ_l w_l H_l; in orthonormal coordinates L⁻¹ A.
    /// It differs from [`LightTransform::light_into`] of the same light on texels by what the texels blur.
    ///
    /// # Errors
    /// Lobes that [`crate::Srbf::with_centers`] would refuse.
    pub fn interpolation(&self, centers: &[Direction], bandwidths: &[f64]) -> Result<Array2<f64>> {
        let others = Lobes::new(self.kernel(), centers.to_vec(), bandwidths.to_vec())?;
        let mut products = self.lobes.inner_products(&others);
        if self.params.coordinates == Coordinates::Orthonormal {
            self.lower.forward_columns(products.view_mut());
        }
        Ok(products)
    }

    /// The coefficients that C's columns multiply for a light of lobes, A·L (Eq. 12): lobes x channels.
    ///
    /// # Errors
    /// A light of another kernel.
    pub fn light_of(&self, light: &ScatteredLight) -> Result<Array2<f32>> {
        if light.kernel() != self.kernel() {
            return Err(Error::Unsupported {
                what: "light of lobes for srbf".into(),
                expected: format!("lobes of kernel {}", self.kernel().show()),
                found: light.kernel().show(),
            });
        }
        if light.lobes().is_empty() {
            return Ok(Array2::zeros((self.lobes.len(), light.coefficients().ncols())));
        }
        let (centers, bandwidths): (Vec<Direction>, Vec<f64>) =
            light.lobes().iter().map(|lobe| (lobe.centre, lobe.bandwidth)).unzip();
        let products = self.interpolation(&centers, &bandwidths)?;
        Ok(products.dot(&light.coefficients()).mapv(|v| v as f32))
    }

    /// What C multiplies, of one channel: B·x, in orthonormal coordinates L⁻¹ B x.
    fn light<C: Count>(&self, light: impl Iterator<Item = f32>, count: &mut C) -> Vec<f64> {
        let mut sums = vec![0f64; self.lobes.len()];
        for (k, x) in light.enumerate() {
            self.add(k, x.into(), &mut sums);
            count.multiply_add(self.moments.of(k).0.len());
        }
        if self.params.coordinates == Coordinates::Orthonormal {
            self.lower.forward(&mut sums, count);
        }
        sums
    }

    /// `sums` += `factor` · column k of B.
    fn add(&self, k: usize, factor: f64, sums: &mut [f64]) {
        let (lobes, values) = self.moments.of(k);
        lobes.iter().zip(values).for_each(|(&j, &b)| sums[j as usize] += factor * f64::from(b));
    }

    /// B D⁻¹ Tᵀ of several rows of T: lobes x rows.
    fn project(&self, rows: ArrayView2<f32>) -> Array2<f64> {
        let mut sums = Array2::zeros((self.lobes.len(), rows.nrows()));
        let mut tile = Array2::<f64>::zeros((TILE, rows.nrows()));
        for first in (0..rows.ncols()).step_by(TILE) {
            let columns = first..rows.ncols().min(first + TILE);
            for (r, row) in rows.outer_iter().enumerate() {
                columns.clone().for_each(|k| tile[[k - first, r]] = f64::from(row[k]) * self.inverse_angles[k]);
            }
            for k in columns {
                let values = tile.row(k - first);
                if values.iter().any(|v| *v != 0.0) {
                    let (lobes, moments) = self.moments.of(k);
                    lobes
                        .iter()
                        .zip(moments)
                        .for_each(|(&j, &b)| sums.row_mut(j as usize).scaled_add(b.into(), &values));
                }
            }
        }
        sums
    }
}

/// Where a file says what [`Ridge::Auto`] chose, if anything: another machine might choose another in the last digit.
const RIDGE: &str = "header/srbf-ridge";

/// The ridge of a transform that was written.
pub(super) fn read_ridge(params: &SrbfParams, source: &mut Source) -> Result<Ridge> {
    if params.ridge != Ridge::Auto || !source.has(RIDGE) {
        return Ok(if params.ridge == Ridge::Auto { Ridge::Share(0.0) } else { params.ridge });
    }
    let share: f64 = source.take_exact(RIDGE, 1)?[0];
    if share > 0.0 && share <= 1.0 {
        Ok(Ridge::Share(share))
    } else {
        Err(broken(RIDGE, "a share above 0, at most 1", share.to_string()))
    }
}

impl LightTransform for BoundSrbf {
    fn output(&self) -> LightBasis {
        LightBasis::Lobes { lights: self.lobes.len(), orthonormal: self.params.coordinates == Coordinates::Orthonormal }
    }

    fn row_into(&self, row: &[f32], out: &mut [f32]) {
        let mut c = vec![0f64; self.lobes.len()];
        for (k, &t) in row.iter().enumerate().filter(|(_, t)| **t != 0.0) {
            self.add(k, f64::from(t) * self.inverse_angles[k], &mut c);
        }
        self.lower.forward(&mut c, &mut NoCount);
        if self.params.coordinates == Coordinates::Lobes {
            self.lower.backward(&mut c);
        }
        out.iter_mut().zip(c).for_each(|(out, c)| *out = c as f32);
    }

    fn rows_into(&self, rows: ArrayView2<f32>, mut out: ArrayViewMut2<f32>) {
        let mut c = self.project(rows);
        match self.params.coordinates {
            Coordinates::Orthonormal => self.lower.forward_columns(c.view_mut()),
            Coordinates::Lobes => self.lower.solve_columns(c.view_mut()),
        }
        out.zip_mut_with(&c.t(), |out, c| *out = *c as f32);
    }

    fn restore_row_into(&self, coefficients: &[f32], out: &mut [f32]) {
        let mut c: Vec<f64> = coefficients.iter().map(|c| f64::from(*c)).collect();
        if self.params.coordinates == Coordinates::Orthonormal {
            self.lower.backward(&mut c);
        }
        for (k, out) in out.iter_mut().enumerate() {
            let (lobes, values) = self.moments.of(k);
            let sum: f64 = lobes.iter().zip(values).map(|(&j, &b)| c[j as usize] * f64::from(b)).sum();
            *out = sum as f32;
        }
    }

    fn restore_rows_into(&self, coefficients: ArrayView2<f32>, mut out: ArrayViewMut2<f32>) {
        // Lobes x rows, so that a moment meets all rows at once.
        let mut c = Array2::zeros((self.lobes.len(), coefficients.nrows()));
        c.zip_mut_with(&coefficients.t(), |to, &c| *to = f64::from(c));
        if self.params.coordinates == Coordinates::Orthonormal {
            self.lower.backward_columns(c.view_mut());
        }
        let mut tile = Array2::<f64>::zeros((TILE, coefficients.nrows()));
        for first in (0..out.ncols()).step_by(TILE) {
            let columns = first..out.ncols().min(first + TILE);
            tile.fill(0.0);
            for (k, mut sums) in columns.clone().zip(tile.outer_iter_mut()) {
                let (lobes, values) = self.moments.of(k);
                lobes.iter().zip(values).for_each(|(&j, &b)| sums.scaled_add(b.into(), &c.row(j as usize)));
            }
            let sums = tile.slice_axis(Axis(0), (..columns.len()).into());
            let mut out = out.slice_axis_mut(Axis(1), columns.into());
            out.zip_mut_with(&sums.t(), |out, &sum| *out = sum as f32);
        }
    }

    fn light_into(&self, lights: ArrayView2<f32>, mut out: ArrayViewMut2<f32>) {
        for (light, mut out) in lights.columns().into_iter().zip(out.columns_mut()) {
            let coefficients = self.light(light.iter().copied(), &mut NoCount);
            out.iter_mut().zip(coefficients).for_each(|(out, c)| *out = c as f32);
        }
    }

    fn derived_bytes(&self) -> usize {
        // Where lobes are given their sections hold centres and bandwidths.
        let lobes = match self.params.centers {
            Centers::Given => 0,
            Centers::Count(_) => size_of_val(&self.lobes.centers[..]) + size_of_val(&self.lobes.bandwidths[..]),
        };
        lobes + self.moments.bytes() + size_of_val(&self.inverse_angles[..]) + self.lower.bytes()
    }

    fn note(&self) -> Option<String> {
        let lobes = self.lobes.len();
        (self.ridge > 0.0)
            .then(|| format!("{lobes} lobes are told apart with a ridge of {:.1e} of their mean square", self.ridge))
    }

    fn flops(&self, light: &[f32]) -> Flops {
        let mut tally = Tally::default();
        self.light(light.iter().copied(), &mut tally);
        tally.0
    }

    fn write(&self, sink: &mut Sink) {
        if self.params.centers == Centers::Given {
            self.lobes.write(sink);
        }
        if self.params.ridge == Ridge::Auto && self.ridge > 0.0 {
            sink.put(RIDGE, &[self.ridge]);
        }
    }
}
