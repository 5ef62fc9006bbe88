use super::*;
use crate::lights::{Light, turned_light};
use crate::operator::Operator;
use crate::registry::{method, registry};
use crate::scenes::Up;
use crate::signal::{Signal, Spec};
use crate::suite::Origin;
use crate::{compute, files};
use prt_transfer::scene::light_field::FieldParams;
use prt_transfer::{Compressed, LightBasis, Metric, Quiet, TransferMatrix};

const SMALL: [usize; 2] = [48, 36];

fn origin(signal: Signal) -> Origin {
    let resolution = LightBasis::Cubemap { resolution: 8 };
    let basis = if signal == Signal::Glossy { signal.usual_basis() } else { resolution };
    let spec = Spec { supersampling: 0, ..Spec::new(signal, basis) };
    Origin::Scene { scene: "blob".into(), vertices: Some(150), up: Up::Z, spec }
}

fn matrix(origin: &Origin) -> TransferMatrix {
    let Origin::Scene { scene, vertices, spec, .. } = origin else { panic!("a scene") };
    compute::precompute(scene, *vertices, spec, &Quiet).unwrap().matrix
}

fn encoded(matrix: &TransferMatrix, label: &str) -> Compressed {
    method(&registry(), label).unwrap().encode(matrix, &Quiet).unwrap()
}

#[test]
fn an_exact_method_has_the_exact_picture_of_every_signal_and_does_not_flicker() {
    for signal in Signal::ALL {
        let origin = origin(signal);
        let (matrix, light) = (matrix(&origin), Light::named("sky").unwrap());
        let metric = Metric::of(&matrix).unwrap();
        let viewpoint = Viewpoint::of(&origin, matrix.responses(), SMALL, &Quiet).unwrap().unwrap();
        let portrait = Portrait::taken(&viewpoint, &matrix, light.on(matrix.basis(), 0.0).unwrap()).unwrap();
        let turning = Turning::new(&matrix, &light, &metric).unwrap();
        let [exact, coarse] = ["csr", "pca:components=2"].map(|label| {
            let compressed = encoded(&matrix, label);
            let errors = portrait.compare(&viewpoint, &compressed).unwrap().errors;
            (errors, turning.flicker(&compressed, &metric).unwrap())
        });
        // The matrix itself sums in double precision, what is compressed does not.
        assert!(exact.0.relative_squared_error < 1e-9 && exact.0.psnr_db > 70.0 && exact.0.flip < 1e-3, "{exact:?}");
        assert!(exact.1 < 1e-6, "{signal}: {exact:?}");
        assert!(
            coarse.0.relative_squared_error > 1e-4 && coarse.0.flip > 0.01 && coarse.1 > 1e-3,
            "{signal}: {coarse:?}"
        );
        assert_eq!(portrait.compare(&viewpoint, &matrix).unwrap().errors.flip, 0.0);
        let covered = viewpoint.coverage().iter().filter(|c| **c == 1.0).count();
        assert!(covered > SMALL[0] * SMALL[1] / 5, "the scene fills the picture: {covered} pixels");
    }
}

#[test]
fn flicker_is_that_of_its_definition_however_many_steps_are_relit_at_once() {
    let origin = origin(Signal::Glossy);
    let matrix = matrix(&origin);
    let (metric, compressed) = (Metric::of(&matrix).unwrap(), encoded(&matrix, "vq:clusters=12"));
    let turning = Turning::new(&matrix, &Light::named("room").unwrap(), &metric).unwrap();
    // Step after step, channels together as one output in the metric of exit radiance.
    let outputs = |of: &dyn Operator| -> Vec<Vec<f64>> {
        let at = |step: usize| of.relit(turned_light("room", of.basis(), 2.0 * step as f64).unwrap().view()).unwrap();
        (0..=16).map(|step| at(step).iter().map(|&y| f64::from(y)).collect()).collect()
    };
    let (exact, ours) = (outputs(&matrix), outputs(&compressed));
    let (mut errors, mut size) = (0.0, 0.0);
    for step in 1..=16 {
        let change = |y: &[Vec<f64>], i: usize| y[step][i] - y[step - 1][i];
        let places = 0..exact[0].len();
        errors += metric.square_of_output(places.clone().map(|i| change(&exact, i) - change(&ours, i)), 3);
        size += metric.square_of_output(places.map(|i| change(&exact, i)), 3);
    }
    for at_once in [1, 5, 16] {
        let found = turning.flicker_of(&compressed, &metric, at_once).unwrap();
        assert!((found / (errors / size) - 1.0).abs() < 1e-3, "{at_once}: {found} {}", errors / size);
    }
}

#[test]
fn an_error_that_stays_does_not_flicker() {
    let origin = origin(Signal::Diffuse);
    let matrix = matrix(&origin);
    let metric = Metric::of(&matrix).unwrap();
    // Every row sees some of all light, which does not change as it turns.
    let (angles, lights) = (matrix.basis().solid_angles().unwrap(), matrix.lights());
    let raised = |scale: &dyn Fn(usize) -> f64| {
        let mut values = vec![0f32; matrix.rows() * lights];
        for (row, out) in values.chunks_mut(lights).enumerate() {
            matrix.gather(row, out);
            out.iter_mut().zip(&angles).enumerate().for_each(|(k, (value, angle))| *value += (scale(k) * angle) as f32);
        }
        encoded(&TransferMatrix::from_dense(values, matrix.rows(), 1, matrix.basis().clone()).unwrap(), "dense")
    };
    let turning = Turning::new(&matrix, &Light::named("sky").unwrap(), &metric).unwrap();
    let constant = turning.flicker(&raised(&|_| 0.3), &metric).unwrap();
    let uneven = turning.flicker(&raised(&|k| if k % 2 == 0 { 0.6 } else { 0.0 }), &metric).unwrap();
    assert!(constant < 1e-3 && uneven > 0.05, "{constant} {uneven}");
}

#[test]
fn a_turned_light_relights_as_its_pixels_do_when_they_are_moved_by_hand() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("light.exr");
    let pixels: Vec<[f32; 3]> = (0..24 * 12).map(|i| [(i * 37 % 101) as f32, (i % 24) as f32, 1.0]).collect();
    let image = prt_transfer::image::Image { width: 24, height: 12, pixels };
    files::write_radiance(&path, &image).unwrap();
    let basis = LightBasis::LatLong { width: 24, height: 12 };
    let values = (0..5 * 288).map(|i| ((i * 53) % 89) as f32 / 89.0).collect();
    let compressed = encoded(&TransferMatrix::from_dense(values, 5, 1, basis.clone()).unwrap(), "csr");
    for columns in [0, 1, 7] {
        // Counter-clockwise is to the left.
        let light = turned_light(&path.display().to_string(), &basis, 15.0 * columns as f64).unwrap();
        let moved =
            ndarray::Array2::from_shape_fn((288, 3), |(k, c)| image.pixels[k / 24 * 24 + (k + columns) % 24][c]);
        let [found, expected] = [light, moved].map(|light| compressed.relit(light.view()).unwrap());
        let close = found.iter().zip(&expected).all(|(a, b)| (a - b).abs() < 1e-4 * b.abs());
        assert!(close, "{columns}: {found} {expected}");
    }
}

#[test]
fn a_shape_is_seen_in_its_light_field_and_a_matrix_file_is_not_seen() {
    let params = FieldParams { width: 8, height: 8, around: 8, down: 4, diffuse: 4, ..FieldParams::default() };
    let origin = Origin::Field { world: "glossy-sphere".into(), shape: "sphere".into(), params };
    let folder = tempfile::tempdir().unwrap();
    let matrix = crate::cache::prepare(folder.path(), &origin, &Quiet).unwrap().into_matrix().unwrap();
    let viewpoint = Viewpoint::of(&origin, matrix.responses(), SMALL, &Quiet).unwrap().unwrap();
    assert!(!viewpoint.is_lit() && viewpoint.coverage().contains(&0.0) && viewpoint.coverage().contains(&1.0));
    let light = Light::named("sky").unwrap().on(matrix.basis(), 0.0).unwrap();
    let portrait = Portrait::taken(&viewpoint, &matrix, light).unwrap();
    let errors = |label: &str| portrait.compare(&viewpoint, &encoded(&matrix, label)).unwrap().errors;
    assert_eq!((errors("dense").relative_squared_error, errors("dense").flip), (0.0, 0.0));
    let [coarse, fine] = ["slf:clusters=1:components=1", "slf:clusters=1:components=16"].map(errors);
    assert!(fine.relative_squared_error < 0.5 * coarse.relative_squared_error && fine.flip < coarse.flip);
    let file = Origin::Matrix("T.npz".into());
    assert!(Viewpoint::of(&file, matrix.responses(), SMALL, &Quiet).unwrap().is_none());
}
