//! What holds of everything that a reader has accepted.

use super::REGISTRY;
use crate::{decoded, light};
use ndarray::Array2;
use prt_cpca::{Model, d3dx};
use prt_harness::results::{from_csv, to_csv};
use prt_harness::row::Row;
use prt_srbf::ScatteredLight;
use prt_transfer::chart::Charted;
use prt_transfer::image::Image;
use prt_transfer::io::image::{Precision, exr_bytes, read_exr};
use prt_transfer::io::matrix::Description;
use prt_transfer::io::{npz, prt};
use prt_transfer::mesh::Mesh;
use prt_transfer::{Compressed, Quiet, TransferMatrix};
use std::io::Cursor;

/// Panics where something that was read breaks an invariant.
pub type Check = Box<dyn FnOnce()>;

/// A few bytes can be a large matrix or image, legally: of larger ones not everything is looked at.
const MOST: usize = 1 << 16;

/// Elements are finite, columns ascend below the lights, rows are whole samples and the basis has the lights; what is written reads back.
pub(super) fn matrix(matrix: TransferMatrix) -> Check {
    Box::new(move || {
        let shape = matrix.shape();
        assert_eq!(matrix.basis().lights(), shape.lights);
        assert_eq!(matrix.responses().responses(), shape.responses);
        if let Some(values) = matrix.as_dense() {
            assert_eq!(values.len(), shape.rows() * shape.lights);
            assert!(values.iter().all(|v| v.is_finite()));
        }
        if let Some((offsets, columns, values)) = matrix.as_csr() {
            assert_eq!((offsets.len(), offsets[0], offsets[shape.rows()]), (shape.rows() + 1, 0, columns.len()));
            assert_eq!(columns.len(), values.len());
            assert!(values.iter().all(|v| v.is_finite() && *v != 0.0));
            for row in offsets.windows(2) {
                let columns = &columns[row[0]..row[1]];
                assert!(columns.is_sorted_by(|a, b| a < b));
                assert!(columns.last().is_none_or(|&last| (last as usize) < shape.lights));
            }
        }
        if shape.rows() * shape.lights.max(1) <= MOST {
            let bytes = npz::to_bytes(&matrix, "").expect("a matrix can be written");
            let again = npz::read_from(Cursor::new(&bytes), &Description::default()).expect("what was written");
            assert_eq!((again.matrix.shape(), again.matrix.basis()), (shape, matrix.basis()));
            assert_eq!(again.matrix.responses(), matrix.responses());
            for row in 0..shape.rows() {
                assert!(again.matrix.row(row).non_zeros().eq(matrix.row(row).non_zeros()), "row {row}");
            }
        }
    })
}

/// A light of one or more channels is finite.
pub(super) fn lights(lights: Array2<f32>) -> Check {
    Box::new(move || assert!(lights.iter().all(|v| v.is_finite())))
}

fn check_mesh(mesh: &Mesh) {
    assert!(mesh.positions.iter().all(|p| p.is_finite()));
    assert!(mesh.faces.iter().flatten().all(|&v| (v as usize) < mesh.positions.len()));
    assert!(mesh.normals.is_empty() || mesh.normals.len() == mesh.positions.len());
    assert!(mesh.normals.iter().all(|n| (n.length() - 1.0).abs() < 1e-4));
    assert!(mesh.extent() >= 0.0 && mesh.area() >= 0.0);
}

/// Faces have vertices, positions are finite, normals unit vectors, none or one for each vertex.
pub(super) fn mesh(mesh: Mesh) -> Check {
    Box::new(move || check_mesh(&mesh))
}

/// As [`mesh`]; each vertex has its place in the unit square.
pub(super) fn charted(charted: Charted) -> Check {
    Box::new(move || {
        check_mesh(&charted.mesh);
        assert_eq!(charted.uv.len(), charted.mesh.positions.len());
        assert!(charted.uv.iter().all(|uv| (0.0..=1.0).contains(&uv.x) && (0.0..=1.0).contains(&uv.y)));
        charted.distortion();
    })
}

/// As many pixels as width times height, one at least; finite ones become a light, and read back as they were written.
pub(super) fn image(mut image: Image) -> Check {
    Box::new(move || {
        assert_eq!(image.pixels.len(), image.width * image.height);
        if image.pixels.len() > MOST || image.clamp_negatives().is_err() {
            return;
        }
        assert!(image.pixels.iter().flatten().all(|v| v.is_finite() && *v >= 0.0));
        let bytes = exr_bytes(&image, Precision::Single).expect("an image can be written");
        assert_eq!(read_exr(&bytes).expect("what was written"), image);
    })
}

/// A model that its own check accepts, and that reads back as it was written.
pub(super) fn model(model: Model) -> Check {
    Box::new(move || {
        model.check().expect("a model that was read");
        assert_eq!(model.members.len(), model.shape.samples);
        if model.shape.samples <= MOST {
            let bytes = d3dx::to_d3dx(&model).expect("what was read can be written");
            assert!(d3dx::from_d3dx(&bytes).expect("what was written") == model);
        }
    })
}

/// Finite radiance from everywhere that single precision holds.
pub(super) fn lobes(lobes: ScatteredLight) -> Check {
    Box::new(move || {
        assert!(lobes.coefficients().iter().all(|c| c.is_finite()));
        for lobe in lobes.lobes() {
            let length = lobe.centre.iter().map(|c| c * c).sum::<f64>();
            assert!((length - 1.0).abs() < 1e-9 && lobe.bandwidth > 0.0);
        }
        assert!(lobes.radiance([0.0, 0.0, 1.0]).iter().chain(&lobes.flux()).all(|v| !v.is_nan()));
    })
}

/// Rows read back as they were written.
pub(super) fn results(rows: Vec<Row>) -> Check {
    Box::new(move || {
        // A file is written with its first row.
        if rows.is_empty() {
            return;
        }
        let bytes = to_csv(&rows).expect("rows can be written");
        let again = to_csv(&from_csv(&bytes).expect("what was written")).expect("rows can be written");
        // As text: a number that is none is not equal to itself.
        assert!(again == bytes);
    })
}

/// As [`compressed`], and the file of what was read reads back to the same file.
pub(super) fn container(compressed: Compressed) -> Check {
    Box::new(move || {
        let bytes = prt::to_bytes(&compressed, &Quiet).expect("what was read can be written");
        let again = prt::from_bytes(&bytes, &REGISTRY).expect("what was written");
        assert!(prt::to_bytes(&again, &Quiet).expect("what was read can be written") == bytes);
        check_compressed(&compressed);
    })
}

/// Basis and responses fit the shape; the sections of what was read are read again to the same sections; every row decodes to finite numbers;
/// relighting is rows times light.
pub(super) fn compressed(compressed: Compressed) -> Check {
    Box::new(move || check_compressed(&compressed))
}

fn check_compressed(compressed: &Compressed) {
    let (shape, header) = (compressed.shape(), compressed.header());
    assert_eq!(compressed.basis().lights(), shape.lights);
    assert_eq!(compressed.responses().responses(), shape.responses);
    let sections = compressed.sections().into_sections();
    let again = REGISTRY.restore(&header, sections.clone()).expect("what was written");
    assert!(again.sections().into_sections() == sections, "other sections");
    if shape.rows().max(1) * shape.lights.max(1) > MOST {
        return check_some_rows(compressed);
    }
    let rows = decoded(compressed);
    let mut at_once = Array2::from_elem(rows.dim(), f32::NAN);
    compressed.rows_into(0, at_once.view_mut());
    assert!(rows.iter().all(|v| v.is_finite()), "a decoded element is not finite");
    let largest = rows.iter().fold(0f32, |most, v| most.max(v.abs()));
    let far = |a: f32, b: f32| (a - b).abs() > 1e-4 * largest;
    assert!(!at_once.iter().zip(&rows).any(|(a, b)| far(*a, *b)), "rows at once are other rows");
    // Elements are finite in double precision, of which sums are made here; of numbers that single precision just holds sums may not be, where
    // relighting adds in another order. A weak light shows what the others hide.
    let agree = [1.0, FAINT].map(|strength| relit(compressed, &rows, largest, strength));
    assert!(agree.iter().any(Result::is_ok), "{}", agree.into_iter().filter_map(Result::err).collect::<String>());
}

/// A factor of lights with which numbers up to 1e38 have finite products.
const FAINT: f32 = 1.0 / (1u64 << 63) as f32;

/// Whether relighting with a light of this strength is rows times light.
fn relit(compressed: &Compressed, rows: &Array2<f32>, largest: f32, strength: f32) -> Result<(), String> {
    let shape = compressed.shape();
    let x = light(shape.lights, 3) * strength;
    let mut y = Array2::from_elem((shape.rows(), 3), f32::NAN);
    compressed.apply_into(x.view(), y.view_mut()).expect("sizes agree");
    compressed.flops(&x.column(0).to_vec()).expect("sizes agree");
    let cut = compressed.label().transform.params.iter().any(|(name, _)| name == "light_terms");
    let bound = 1e-4 * f64::from(largest * strength) * shape.lights as f64;
    // Sums that single precision does not hold are infinite, and the difference of two is no number.
    if cut || 1e5 * bound > f32::MAX.into() {
        return Ok(());
    }
    let sums = rows.mapv(f64::from).dot(&x.mapv(f64::from));
    let wrong = |(y, sum): &(&f32, &f64)| (f64::from(**y) - **sum).abs() > bound + 1e-37 || !y.is_finite();
    match y.iter().zip(&sums).find(wrong) {
        None => Ok(()),
        Some((y, sum)) => Err(format!("relit {y:e}, rows times light {sum:e}, largest element {largest:e}; ")),
    }
}

/// The first row, the last one and one between them.
fn check_some_rows(compressed: &Compressed) {
    let shape = compressed.shape();
    if shape.lights <= MOST && shape.rows() > 0 {
        let mut row = vec![f32::NAN; shape.lights];
        for at in [0, shape.rows() / 2, shape.rows() - 1] {
            compressed.row_into(at, &mut row);
            assert!(row.iter().all(|v| v.is_finite()), "row {at} is not finite");
        }
    }
}
