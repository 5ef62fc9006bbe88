use super::chart::{VARIABLES, charts, lobes_at};
use super::objective::{fixed, solve};
use super::*;
use crate::kernel::Kernel;
use crate::lobe::normalised;
use ndarray::Array2;
use prt_transfer::Quiet;
use prt_transfer::random::Random;

const BASIS: LightBasis = LightBasis::Cubemap { resolution: 8 };

/// Some lobes over a slope, three channels.
fn scene(seed: u64) -> Array2<f32> {
    let mut random = Random(seed);
    let lobes: Vec<(Lobe, [f64; 3])> = (0..6)
        .map(|_| {
            let centre = normalised([0; 3].map(|_| random.normal()));
            let bandwidth = (1.0 + 4.0 * random.uniform()).exp();
            (Lobe { centre, bandwidth }, [0; 3].map(|_| 0.2 + random.uniform()))
        })
        .collect();
    let directions = BASIS.directions().unwrap();
    Array2::from_shape_fn((BASIS.lights(), 3), |(k, c)| {
        let value = |(lobe, colour): &(Lobe, [f64; 3])| {
            colour[c] * Kernel::Gaussian.value(lobe.cosine(directions[k]), lobe.bandwidth)
        };
        (0.1 * (1.0 + directions[k][2]) + lobes.iter().map(value).sum::<f64>()) as f32
    })
}

fn target(light: &Array2<f32>) -> Target {
    Target::new(&BASIS.directions().unwrap(), &BASIS.solid_angles().unwrap(), light.as_slice().unwrap(), 3).unwrap()
}

fn lobes(count: usize, kernel: Kernel) -> Vec<Lobe> {
    let mut random = Random(3);
    starts::random(kernel, FitParams { kernel, ..FitParams::default() }.bandwidths(384), count, &mut random)
}

fn small(lobes: usize) -> FitParams {
    FitParams { lobes, exchanges: 3, steps: 30, ..FitParams::default() }
}

#[test]
fn gradients_are_those_of_differences() {
    let light = scene(1);
    let target = target(&light);
    for kernel in [Kernel::Gaussian, Kernel::AbelPoisson] {
        let lobes = lobes(9, kernel);
        let charts = charts(&lobes, kernel);
        let coefficients = solve(&target, kernel, &lobes).coefficients;
        // Away from the charts' origin, where their own curvature shows.
        let mut random = Random(4);
        let at: Vec<f64> = (0..lobes.len() * VARIABLES).map(|_| 0.3 * random.normal()).collect();
        for free_coefficients in [true, false] {
            let objective = |variables: &[f64]| {
                let lobes = lobes_at(&charts, variables);
                let residual = if free_coefficients {
                    solve(&target, kernel, &lobes)
                } else {
                    fixed(&target, kernel, &lobes, &coefficients)
                };
                let gradient: Vec<f64> = charts
                    .iter()
                    .zip(variables.chunks(VARIABLES))
                    .zip(residual.gradient())
                    .flat_map(|((chart, v), g)| chart.gradient(v, g))
                    .collect();
                (residual.objective, gradient)
            };
            let (_, gradient) = objective(&at);
            for i in 0..at.len() {
                let moved = |by: f64| {
                    let mut variables = at.clone();
                    variables[i] += by;
                    objective(&variables).0
                };
                let difference = (moved(1e-5) - moved(-1e-5)) / 2e-5;
                assert!(
                    (gradient[i] - difference).abs() < 1e-7 + 1e-4 * difference.abs(),
                    "{kernel:?} {i}: {} {difference}",
                    gradient[i]
                );
            }
        }
    }
}

#[test]
fn coefficients_are_those_of_dense_normal_equations() {
    let light = scene(2);
    let found = fit(&small(10), &BASIS, light.view(), &Quiet).unwrap();
    // Moving any coefficient does not lower the error: its slope is 0 up to the ridge.
    let (directions, angles) = (BASIS.directions().unwrap(), BASIS.solid_angles().unwrap());
    let energy: f64 = light
        .outer_iter()
        .zip(&angles)
        .map(|(row, a)| a * row.iter().map(|v| f64::from(*v).powi(2)).sum::<f64>())
        .sum();
    let mut error = 0.0;
    let mut slopes = Array2::<f64>::zeros((10, 3));
    for ((d, angle), row) in directions.iter().zip(&angles).zip(light.outer_iter()) {
        let radiance = found.light.radiance(*d);
        for c in 0..3 {
            let left = f64::from(row[c]) - radiance[c];
            error += angle * left * left;
            for (j, lobe) in found.light.lobes().iter().enumerate() {
                slopes[[j, c]] += angle * left * Kernel::Gaussian.value(lobe.cosine(*d), lobe.bandwidth);
            }
        }
    }
    assert!((error / energy - found.relative_squared_error).abs() < 1e-12);
    assert_eq!(found.history.last().unwrap().lobes, 10);
    assert!((found.history.last().unwrap().relative_squared_error / found.relative_squared_error - 1.0).abs() < 1e-6);
    assert!(slopes.iter().all(|s| s.abs() < 1e-5 * energy.sqrt()), "{slopes}");
}

#[test]
fn lobes_are_found_again() {
    // Three lobes that overlap little, on texels that see them well.
    let lobe = |centre: [f64; 3], bandwidth| Lobe { centre: normalised(centre), bandwidth };
    let truth = [lobe([1.0, 0.2, 0.1], 9.0), lobe([-0.4, 1.0, -0.3], 20.0), lobe([0.1, -0.5, -1.0], 5.0)];
    let colours = ndarray::array![[1.0, 0.5, 0.2], [2.0, 2.0, 0.1], [0.3, 0.4, 0.9]];
    for kernel in [Kernel::Gaussian, Kernel::AbelPoisson] {
        let bandwidth = |b: f64| if kernel == Kernel::Gaussian { b } else { 1.0 - 1.5 / b.sqrt() };
        let truth = truth.map(|l| Lobe { bandwidth: bandwidth(l.bandwidth), ..l });
        let light = ScatteredLight::new(kernel, truth.to_vec(), colours.clone()).unwrap();
        let texels = light.texels(&BASIS).unwrap();
        for solver in [Solver::GaussNewton, Solver::Lbfgs] {
            let params = FitParams {
                lobes: 3,
                kernel,
                solver,
                steps: 300,
                exchanges: 0,
                min_bandwidth: Some(0.2),
                ..FitParams::default()
            };
            let found = fit(&params, &BASIS, texels.view(), &Quiet).unwrap();
            assert!(found.relative_squared_error < 1e-9, "{kernel:?} {solver:?}: {:e}", found.relative_squared_error);
            for lobe in &truth {
                let near = found.light.lobes().iter().any(|l| l.cosine(lobe.centre) > 1.0 - 1e-5);
                assert!(near, "{kernel:?} {solver:?}: {:?}", found.light.lobes());
            }
        }
    }
}

#[test]
fn every_start_and_solver_lowers_the_error_and_more_lobes_lower_it_further() {
    let light = scene(5);
    for starts in [Starts::Greedy, Starts::Coverage, Starts::Random] {
        for (solver, joint) in [
            (Solver::GaussNewton, false),
            (Solver::Lbfgs, false),
            (Solver::Alternate, false),
            (Solver::Alternate, true),
        ] {
            let params = |lobes| FitParams { starts, solver, joint, steps: 15, ..small(lobes) };
            let [few, many] = [4, 24].map(|n| fit(&params(n), &BASIS, light.view(), &Quiet).unwrap());
            let first = &few.history[0];
            assert!(few.relative_squared_error < first.relative_squared_error.max(0.2), "{starts:?} {solver:?}");
            assert!(many.relative_squared_error < few.relative_squared_error, "{starts:?} {solver:?}");
            assert!(
                many.history
                    .windows(2)
                    .all(|w| w[1].name != "exchange"
                        || w[1].relative_squared_error < 1.001 * w[0].relative_squared_error)
            );
        }
    }
}

#[test]
fn a_coarser_light_comes_first_where_that_is_asked_for() {
    let basis = LightBasis::Cubemap { resolution: 64 };
    let truth =
        ScatteredLight::new(Kernel::Gaussian, lobes(5, Kernel::Gaussian), Array2::from_elem((5, 1), 1.0)).unwrap();
    let texels = truth.texels(&basis).unwrap();
    for (coarse, expected) in [(true, vec![6144, 24576]), (false, vec![24576])] {
        let params = FitParams { coarse, lobes: 5, exchanges: 0, steps: 20, ..FitParams::default() };
        let found = fit(&params, &basis, texels.view(), &Quiet).unwrap();
        let mut texels: Vec<usize> = found.history.iter().map(|s| s.texels).collect();
        texels.dedup();
        assert_eq!(texels, expected);
        assert!(found.relative_squared_error < 0.05, "{}", found.relative_squared_error);
        assert!(found.flux_error[0].abs() < 0.05);
    }
}

#[test]
fn results_do_not_depend_on_threads_and_seeds_matter_where_chance_does() {
    let light = scene(6);
    let run = |threads: usize, params: &FitParams| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| fit(params, &BASIS, light.view(), &Quiet).unwrap())
    };
    let params = small(12);
    assert_eq!(run(1, &params).light, run(3, &params).light);
    let random = |seed| FitParams { starts: Starts::Random, seed, ..small(12) };
    assert_ne!(run(2, &random(1)).light, run(2, &random(2)).light);
}

#[test]
fn hard_lights_are_fitted_as_well_as_they_can_be() {
    let black = Array2::<f32>::zeros((BASIS.lights(), 3));
    let found = fit(&small(5), &BASIS, black.view(), &Quiet).unwrap();
    assert_eq!((found.relative_squared_error, found.light.lobes().len()), (0.0, 0));
    // A sun in one texel: a lobe at its place takes nearly all of it.
    let mut sun = black.clone();
    sun.row_mut(77).fill(1e6);
    for kernel in [Kernel::Gaussian, Kernel::AbelPoisson] {
        let found = fit(&FitParams { kernel, ..small(4) }, &BASIS, sun.view(), &Quiet).unwrap();
        assert!(found.relative_squared_error < 0.2, "{kernel:?} {}", found.relative_squared_error);
    }
    // Negative radiance, tiny radiance, one channel, one lobe, more lobes than texels.
    let negative = scene(7).mapv(|v| -v);
    assert!(fit(&small(10), &BASIS, negative.view(), &Quiet).unwrap().relative_squared_error < 0.2);
    let tiny = scene(7).mapv(|v| v * 1e-30);
    assert!(fit(&small(10), &BASIS, tiny.view(), &Quiet).unwrap().relative_squared_error < 0.2);
    let one = scene(7).column(1).to_owned().insert_axis(ndarray::Axis(1));
    assert!(fit(&small(1), &BASIS, one.view(), &Quiet).unwrap().relative_squared_error < 1.0);
    let few = LightBasis::Cubemap { resolution: 2 };
    let texels = Array2::from_shape_fn((24, 3), |(k, c)| ((k * 7 + c) % 5) as f32);
    for starts in [Starts::Greedy, Starts::Coverage, Starts::Random] {
        let found = fit(&FitParams { starts, ..small(60) }, &few, texels.view(), &Quiet).unwrap();
        assert!(
            found.relative_squared_error < 1e-3 && found.light.lobes().len() == 60,
            "{starts:?} {}",
            found.relative_squared_error
        );
    }
    // Coincident lobes.
    let twice = [lobes(3, Kernel::Gaussian), lobes(3, Kernel::Gaussian)].concat();
    let light = scene(8);
    let residual = solve(&target(&light), Kernel::Gaussian, &twice).error;
    let once = solve(&target(&light), Kernel::Gaussian, &twice[..3]).error;
    assert!((residual / once - 1.0).abs() < 1e-6, "{residual} {once}");
}

#[test]
fn bandwidths_at_their_limits_stay_there_and_give_finite_lights() {
    let light = scene(9);
    for (kernel, limits) in
        [(Kernel::Gaussian, [0.01, 0.01]), (Kernel::Gaussian, [1e5, 1e5]), (Kernel::AbelPoisson, [0.9999, 0.9999])]
    {
        let params = FitParams { kernel, min_bandwidth: Some(limits[0]), max_bandwidth: Some(limits[1]), ..small(6) };
        let found = fit(&params, &BASIS, light.view(), &Quiet).unwrap();
        assert!(found.relative_squared_error.is_finite());
        assert!(found.light.lobes().iter().all(|l| (l.bandwidth / limits[0] - 1.0).abs() < 1e-9));
    }
}

#[test]
fn what_cannot_be_fitted_is_refused() {
    let refused = |params: FitParams, basis: LightBasis, light: Array2<f32>| {
        fit(&params, &basis, light.view(), &Quiet).unwrap_err().to_string()
    };
    let ones = || Array2::<f32>::ones((BASIS.lights(), 3));
    for (params, name) in [
        (FitParams { lobes: 0, ..small(1) }, "lobes"),
        (FitParams { max_bandwidth: Some(f64::NAN), ..small(1) }, "max_bandwidth"),
        (FitParams { min_bandwidth: Some(0.0), ..small(1) }, "min_bandwidth"),
        (FitParams { min_bandwidth: Some(9.0), max_bandwidth: Some(3.0), ..small(1) }, "min_bandwidth"),
        (FitParams { joint: true, ..small(1) }, "joint"),
    ] {
        let message = refused(params, BASIS, ones());
        assert!(message.contains(name), "{message}");
    }
    assert!(refused(small(1), LightBasis::Plain { lights: 4 }, Array2::ones((4, 3))).contains("light basis"));
    assert!(refused(small(1), BASIS, Array2::ones((4, 3))).contains("expected 384, found 4"));
    assert!(refused(small(1), BASIS, Array2::ones((BASIS.lights(), 0))).contains("channel"));
    let mut broken = ones();
    broken[[5, 1]] = f32::NAN;
    assert!(refused(small(1), BASIS, broken).contains("NaN"));
}
