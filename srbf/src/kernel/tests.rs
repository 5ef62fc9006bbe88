use super::*;
use crate::legendre::gaussian;
use crate::lobe::dot;
use proptest::prelude::*;
use prt_transfer::quadrature::gauss_legendre;

const POLE: Direction = [0.0, 0.0, 1.0];
const KERNELS: [Kernel; 2] = [Kernel::Gaussian, Kernel::AbelPoisson];

fn at_angle(angle: f64) -> Direction {
    [angle.sin(), 0.0, angle.cos()]
}

/// ∫ f dω by Gauss-Legendre panels in the polar angle, graded towards the pole, and the trapezoidal rule around it. Graded as well
/// towards `other`, an angle at which f may have a second peak.
fn quadrature(other: f64, widths: [f64; 2], f: impl Fn(Direction) -> f64) -> f64 {
    let mut borders = vec![0.0, PI, other.clamp(0.0, PI)];
    for (place, width) in [(0.0, widths[0]), (other, widths[1])] {
        let mut step = 0.5 * width;
        while step < PI {
            borders.extend([place - step, place + step].into_iter().filter(|b| (0.0..PI).contains(b)));
            step *= 1.6;
        }
    }
    borders.sort_by(f64::total_cmp);
    let (least, rule) = (widths[0].min(widths[1]), gauss_legendre(12));
    let mut sum = 0.0;
    for ends in borders.windows(2).filter(|ends| ends[1] - ends[0] > 1e-15) {
        for &(x, weight) in &rule {
            let theta = 0.5 * (ends[0] + ends[1]) + 0.5 * x * (ends[1] - ends[0]);
            // The rule around the axis converges faster than any power once its steps are a fraction of the peak's width.
            let steps = (64.0 + 24.0 * theta.sin() / least) as usize;
            let ring: f64 = (0..steps)
                .map(|i| {
                    let phi = 2.0 * PI * i as f64 / steps as f64;
                    f([theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos()])
                })
                .sum();
            sum += 0.5 * (ends[1] - ends[0]) * weight * theta.sin() * 2.0 * PI * ring / steps as f64;
        }
    }
    sum
}

/// A bandwidth at a share of the range in its coordinate, up to where quadrature in a test is affordable.
fn bandwidth(kernel: Kernel, share: f64) -> f64 {
    let high = match kernel {
        Kernel::Gaussian => 3e3,
        Kernel::AbelPoisson => 0.98,
    };
    let [low, high] = [kernel.bandwidths()[0], high].map(|b| kernel.coordinate(b));
    kernel.bandwidth_at(low + share * (high - low))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]
    #[test]
    fn inner_products_are_those_of_quadrature(shares in prop::array::uniform2(0f64..1.0), angle in 0f64..PI, abel in any::<bool>()) {
        let kernel = KERNELS[usize::from(abel)];
        let [g, h] = shares.map(|share| bandwidth(kernel, share));
        let centres = [POLE, at_angle(angle)];
        let widths = [g, h].map(|b| kernel.spread(b).min(1.0));
        let found = kernel.inner_product(centres, [g, h]);
        let expected = quadrature(angle, widths, |d| kernel.value(d[2], g) * kernel.value(dot(d, centres[1]), h));
        // The product's own size where lobes are far apart, else that of the lobes.
        let scale = found.max(1e-12 * kernel.norm(g) * kernel.norm(h));
        prop_assert!((found - expected).abs() <= 1e-9 * scale, "{kernel:?} {g} {h} {angle}: {found:e} {expected:e}");
        // What the paper prints: Eq. 5 without 4π, Eq. 27 without e^-(λg + λh).
        let mu = angle.cos();
        let printed = match kernel {
            Kernel::AbelPoisson => kernel.value(mu, g * h),
            Kernel::Gaussian => {
                let r = (g * g + h * h + 2.0 * g * h * mu).sqrt();
                4.0 * PI * r.sinh() / r
            }
        };
        prop_assert!((printed - expected).abs() > 1e-3 * expected, "printed {printed:e}, quadrature {expected:e}");
    }

    #[test]
    fn inner_products_are_those_of_the_legendre_series_at_every_bandwidth(
        shares in prop::array::uniform2(0f64..1.0), closeness in 0f64..1.0, abel in any::<bool>(),
    ) {
        let kernel = KERNELS[usize::from(abel)];
        let [low, high] = match kernel {
            Kernel::Gaussian => kernel.bandwidths(),
            Kernel::AbelPoisson => [0.01, 0.999],
        }.map(|b| kernel.coordinate(b));
        let [g, h] = shares.map(|share| kernel.bandwidth_at(low + share * (high - low)));
        // Angles at which the lobes overlap.
        let angle = (closeness * 2.0 * (kernel.spread(g) + kernel.spread(h))).min(PI);
        let count = match kernel {
            Kernel::Gaussian => 60 + (9.0 * g.min(h).sqrt()) as usize,
            Kernel::AbelPoisson => 60 + (40.0 / -(g * h).ln()) as usize,
        };
        let [a, b] = [g, h].map(|b| kernel.legendre(b, count));
        // Eq. 2 with ω = 4π and d_l = 2l + 1; P_l by its recurrence.
        let (mut before, mut this, mut sum, mu) = (0.0, 1.0, 0.0, angle.cos());
        for l in 0..count {
            sum += a[l] * b[l] * 4.0 * PI / (2 * l + 1) as f64 * this;
            (before, this) = (this, ((2 * l + 1) as f64 * mu * this - l as f64 * before) / (l + 1) as f64);
        }
        let found = kernel.inner_product([POLE, at_angle(angle)], [g, h]);
        let scale = kernel.norm(g) * kernel.norm(h);
        prop_assert!((found - sum).abs() <= 1e-9 * scale, "{kernel:?} {g} {h} {angle}: {found:e} {sum:e}");
    }

    #[test]
    fn slopes_are_those_of_differences(share in 0.02f64..1.0, mu in -0.99f64..0.99, abel in any::<bool>()) {
        let kernel = KERNELS[usize::from(abel)];
        let b = bandwidth(kernel, share);
        let step = 1e-6;
        let difference = |f: &dyn Fn(f64) -> f64, at: f64, step: f64| (f(at + step) - f(at - step)) / (2.0 * step);
        let scale = kernel.value(1.0, b);
        let by_mu = difference(&|mu| kernel.value(mu, b), mu, step / b.max(1.0));
        prop_assert!((kernel.slope(mu, b) - by_mu).abs() <= 1e-5 * (by_mu.abs() + scale), "{by_mu}");
        let relative = step * (1.0 - b).abs().min(b);
        let by_bandwidth = difference(&|b| kernel.value(mu, b), b, relative);
        prop_assert!((kernel.bandwidth_slope(mu, b) - by_bandwidth).abs() <= 1e-4 * by_bandwidth.abs() + 1e-8 * scale / b.min(1.0));
        let by_norm = difference(&|b| kernel.norm(b).ln(), b, relative);
        prop_assert!((kernel.norm_slope(b) - by_norm).abs() <= 1e-5 * by_norm.abs() + 1e-7, "{} {by_norm}", kernel.norm_slope(b));
        let by_coordinate = difference(&|c| kernel.bandwidth_at(c), kernel.coordinate(b), step);
        prop_assert!((kernel.coordinate_slope(b) - by_coordinate).abs() <= 1e-6 * by_coordinate.abs());
    }

    #[test]
    fn a_spread_has_its_bandwidth_and_is_that_of_the_squared_lobe(share in 0.1f64..1.0, abel in any::<bool>()) {
        let kernel = KERNELS[usize::from(abel)];
        let b = bandwidth(kernel, share);
        prop_assert!((kernel.bandwidth_of_spread(kernel.spread(b)) / b - 1.0).abs() < 1e-9);
        let width = [kernel.spread(b).min(1.0); 2];
        let moment = |power: i32| quadrature(0.0, width, |d| d[2].powi(power) * kernel.value(d[2], b).powi(2));
        let mean = moment(1) / moment(0);
        prop_assert!((kernel.spread(b) / (mean.powi(-2) - 1.0).sqrt() - 1.0).abs() < 1e-6);
        prop_assert!((kernel.norm(b).powi(2) / moment(0) - 1.0).abs() < 1e-9);
        let integral = quadrature(0.0, width, |d| kernel.value(d[2], b));
        prop_assert!((kernel.integral(b) / integral - 1.0).abs() < 1e-9);
    }
}

#[test]
fn the_papers_spread_is_the_bandwidth_that_its_erratum_names() {
    let found = Kernel::Gaussian.bandwidth_of_spread(PI / 40.0);
    assert!((found - 162.9).abs() < 0.05, "{found}");
}

#[test]
fn inner_products_hold_where_formulas_are_singular() {
    let gaussian = Kernel::Gaussian;
    let down = [0.0, 0.0, -1.0];
    for b in [0.01f64, 1.0, 50.0] {
        // Opposite lobes of equal bandwidth: r = 0 and the product is constant, e^(-2λ).
        let expected = 4.0 * PI * (-2.0 * b).exp();
        assert!((gaussian.inner_product([POLE, down], [b, b]) / expected - 1.0).abs() < 1e-14);
        // And just beside.
        let beside = [1e-9, 0.0, -1.0];
        assert!((gaussian.inner_product([POLE, beside], [b, b]) / expected - 1.0).abs() < 1e-7);
    }
    for b in [0.01, 1.0, 1e3, 1e5] {
        let found = gaussian.inner_product([POLE, POLE], [b, b]);
        assert!((found / gaussian.integral(2.0 * b) - 1.0).abs() < 1e-14);
        assert!(gaussian.inner_product([POLE, down], [b, b]).is_finite());
    }
}

#[test]
fn legendre_coefficients_add_up_to_the_kernel() {
    for b in [0.01f64, 0.7, 12.0, 300.0, 1e5] {
        let count = 40 + (9.0 * b.sqrt()) as usize;
        let coefficients = gaussian(b, count);
        assert!(coefficients.iter().all(|c| *c >= 0.0));
        let sum: f64 = coefficients.iter().sum();
        assert!((sum - 1.0).abs() < 1e-12, "{b}: {sum}");
        // More of them leave the first ones as they were, also where their ratios leave the range of numbers.
        for count in [count + 31, count + 1000] {
            let more = gaussian(b, count);
            assert!(coefficients.iter().zip(&more).all(|(a, b)| (a - b).abs() <= 1e-14), "{b}");
            assert!((more.iter().sum::<f64>() - 1.0).abs() < 1e-12, "{b}: {count}");
        }
    }
}

#[test]
fn the_mean_of_a_lobe_is_its_continued_fraction_at_every_width() {
    // coth x - 1/x = x/(3 + x²/(5 + x²/(7 + …))).
    let fraction = |x: f64| {
        x / (1..60).rev().fold(0.0, |rest, k| f64::from(2 * k + 1) + if rest == 0.0 { 0.0 } else { x * x / rest })
    };
    for i in -90..=20 {
        let x = 1.25f64.powi(i);
        assert!((langevin(x) / fraction(x) - 1.0).abs() < 2e-12, "{x}: {} {}", langevin(x), fraction(x));
    }
}

#[test]
fn rows_of_cosines_become_the_kernel_there() {
    for kernel in [Kernel::Gaussian, Kernel::AbelPoisson] {
        let [low, high] = kernel.bandwidths();
        for bandwidth in [low, 0.5, 0.9, high] {
            let cosines: Vec<f64> = (0..=100).map(|i| f64::from(i) / 50.0 - 1.0).collect();
            let mut row = cosines.clone();
            kernel.values(&mut row, bandwidth);
            for (found, &mu) in row.iter().zip(&cosines) {
                let value = kernel.value(mu, bandwidth);
                assert!(
                    (found - value).abs() <= 1e-13 * value + f64::MIN_POSITIVE,
                    "{mu} {bandwidth}: {found} {value}"
                );
            }
        }
    }
}
