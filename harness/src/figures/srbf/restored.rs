//! A light from so many of its numbers.

use ndarray::Array2;
use prt_transfer::sh::{Sh, ShParams};
use prt_transfer::{Configure, LightBasis, LightTransform, Result, Transform};
use prt_wavelet::{Haar, HaarParams, LightSelect, Scale};

/// The paper's texels.
pub(super) const BASIS: LightBasis = LightBasis::Cubemap { resolution: 32 };

/// From the `count` largest Haar coefficients, kept for all channels at once: of texels, or of texels times √dω, whichever is nearer. The
/// former hold a constant face in one number, the latter are orthonormal over the sphere.
pub(super) fn haar(light: &Array2<f32>, count: usize) -> Result<Array2<f32>> {
    let both = [Scale::None, Scale::Sphere].map(|scale| {
        let haar = Haar::new(HaarParams { scale, ..HaarParams::default() })?.bind(&BASIS)?;
        let mut coefficients = Array2::zeros((haar.output().lights(), light.ncols()));
        haar.light_into(light.view(), coefficients.view_mut());
        let square = |k: usize| coefficients.row(k).iter().map(|c| f64::from(*c).powi(2)).sum::<f64>();
        let mut order: Vec<(f64, usize)> = (0..coefficients.nrows()).map(|k| (square(k), k)).collect();
        order.sort_unstable_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        order.iter().skip(count).for_each(|&(_, k)| coefficients.row_mut(k).fill(0.0));
        // A row is restored with 1/√dω less than a light, where texels are scaled.
        let angles = BASIS.solid_angles().unwrap_or_default();
        let mut restored = Array2::zeros(light.raw_dim());
        for (column, mut out) in coefficients.columns().into_iter().zip(restored.columns_mut()) {
            let mut row = vec![0f32; BASIS.lights()];
            haar.restore_row_into(&column.to_vec(), &mut row);
            let scale = |angle: f64| if scale == Scale::Sphere { angle } else { 1.0 };
            out.iter_mut().zip(row).zip(&angles).for_each(|((out, v), a)| *out = (f64::from(v) / scale(*a)) as f32);
        }
        Ok(restored)
    });
    let [texels, sphere]: [Result<Array2<f32>>; 2] = both;
    let (texels, sphere) = (texels?, sphere?);
    Ok(if relative_error(light, &texels) < relative_error(light, &sphere) { texels } else { sphere })
}

/// From the `count` Haar coefficients of each channel whose magnitude times area is the largest (Ng et al. 2003).
pub(super) fn area_weighted(light: &Array2<f32>, count: usize) -> Result<Array2<f32>> {
    let params = HaarParams { light_terms: count, light_select: LightSelect::Area, ..HaarParams::default() };
    let haar = Haar::new(params)?.bind(&BASIS)?;
    let mut coefficients = Array2::zeros((haar.output().lights(), light.ncols()));
    haar.light_into(light.view(), coefficients.view_mut());
    let mut restored = Array2::zeros(light.raw_dim());
    for (column, mut out) in coefficients.columns().into_iter().zip(restored.columns_mut()) {
        let mut row = vec![0f32; BASIS.lights()];
        haar.restore_row_into(&column.to_vec(), &mut row);
        out.assign(&ndarray::ArrayView1::from(&row));
    }
    Ok(restored)
}

/// Σ (a - b)² dω / Σ a² dω, all channels together.
pub(super) fn relative_error(reference: &Array2<f32>, found: &Array2<f32>) -> f64 {
    let (mut error, mut whole) = (0.0, 0.0);
    let angles = BASIS.solid_angles().unwrap_or_default();
    for ((a, b), angle) in reference.outer_iter().zip(found.outer_iter()).zip(angles) {
        error += angle * a.iter().zip(&b).map(|(a, b)| (f64::from(*a) - f64::from(*b)).powi(2)).sum::<f64>();
        whole += angle * a.iter().map(|a| f64::from(*a).powi(2)).sum::<f64>();
    }
    if error == 0.0 { 0.0 } else { error / whole }
}

/// The nearest sum of harmonics.
pub(super) fn harmonics(light: &Array2<f32>, order: usize) -> Result<Array2<f32>> {
    let sh = Sh::new(ShParams { order })?.bind(&BASIS)?;
    let angles = BASIS.solid_angles().unwrap_or_default();
    let mut found = Array2::zeros(light.raw_dim());
    for (channel, mut out) in light.columns().into_iter().zip(found.columns_mut()) {
        // A row of moments: radiance times solid angle.
        let moments: Vec<f32> = channel.iter().zip(&angles).map(|(l, a)| (f64::from(*l) * a) as f32).collect();
        let (mut coefficients, mut restored) = (vec![0f32; order * order], vec![0f32; moments.len()]);
        sh.row_into(&moments, &mut coefficients);
        sh.restore_row_into(&coefficients, &mut restored);
        out.iter_mut().zip(restored).zip(&angles).for_each(|((out, m), a)| *out = (f64::from(m) / a) as f32);
    }
    Ok(found)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lights;

    #[test]
    fn haar_and_harmonics_leave_what_their_coefficients_do_not_hold() {
        let light = lights::light("room", &BASIS).unwrap();
        let left = [0, 10, 100, 1000, BASIS.lights()].map(|n| relative_error(&light, &haar(&light, n).unwrap()));
        assert!(left[0] == 1.0 && left[4] < 1e-12 && left.is_sorted_by(|a, b| a > b), "{left:?}");
        let error = |order| relative_error(&light, &harmonics(&light, order).unwrap());
        let errors = [1, 3, 6].map(error);
        assert!(errors.is_sorted_by(|a, b| a > b) && errors[2] > 0.0, "{errors:?}");
        let even = Array2::ones((BASIS.lights(), 3));
        for restored in [harmonics(&even, 1), haar(&even, 6), area_weighted(&even, 6)] {
            assert!(relative_error(&even, &restored.unwrap()) < 1e-10);
        }
    }

    #[test]
    fn weighting_by_area_has_more_error_than_the_largest_coefficients() {
        let light = lights::light("room", &BASIS).unwrap();
        let [largest, weighted] = [haar(&light, 100), area_weighted(&light, 100)].map(|found| found.unwrap());
        let [largest, weighted] = [largest, weighted].map(|found| relative_error(&light, &found));
        assert!(largest < weighted && weighted < 1.0, "{largest} {weighted}");
    }
}
