//! Legendre series of the Gaussian kernel.

/// (2l+1) e^(-λ) i_l(λ) for l below `count`, i_l being the modified spherical Bessel functions of the first kind.
///
/// The recurrence i_(l-1) = i_(l+1) + (2l+1)/λ i_l is stable downward only (Miller): it starts well above the last one from an
/// arbitrary value and is scaled by e^(-λ) i_0 = (1 - e^(-2λ))/2λ.
pub(crate) fn gaussian(bandwidth: f64, count: usize) -> Vec<f64> {
    // Coefficients fall as e^(-l²/2λ), and faster from l = λ on: at the start they are below 1e-16 of those that are wanted.
    let above = 40 + (9.0 * bandwidth.sqrt()) as usize;
    let mut coefficients = vec![0.0; count];
    let (mut next, mut this) = (0f64, 1e-280f64);
    for l in (0..count + above).rev() {
        // `this` is i_l, up to a factor.
        if l < count {
            coefficients[l] = this;
        }
        if l > 0 {
            (this, next) = (next + (2 * l + 1) as f64 / bandwidth * this, this);
        }
        if this > 1e250 {
            (this, next) = (this * 1e-250, next * 1e-250);
            coefficients.iter_mut().for_each(|c| *c *= 1e-250);
        }
    }
    let scale = -(-2.0 * bandwidth).exp_m1() / (2.0 * bandwidth) / this;
    coefficients.iter_mut().enumerate().for_each(|(l, c)| *c *= (2 * l + 1) as f64 * scale);
    coefficients
}
