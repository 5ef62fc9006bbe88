//! Transfer matrices in files, the format chosen by the extension.

use super::{extension, mtx, npy, npz, unknown_extension};
use crate::basis::LightBasis;
use crate::error::{Error, Result};
use crate::footprint::Extent;
use crate::matrix::{Layout, TransferMatrix};
use crate::responses::ResponseBasis;
use std::path::Path;

const KNOWN: &str = ".npz (scipy.sparse), .npy (NumPy), .mtx (MatrixMarket)";

/// What a bare matrix file leaves out. Whatever the file itself says must agree.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Description {
    /// What the rows of one sample stand for; one plain number where neither the file nor the caller says otherwise.
    pub responses: Option<ResponseBasis>,
    /// What the columns stand for; plain coefficients where neither the file nor the caller says otherwise.
    pub basis: Option<LightBasis>,
}

impl Description {
    /// The caller's description and the file's together; `lights` columns have been found. Contradictions are refused.
    pub(super) fn and(&self, file: Description, lights: usize) -> Result<(ResponseBasis, LightBasis)> {
        let responses = agree_on_responses(self.responses.clone(), file.responses)?;
        let basis = agree("light basis", self.basis.clone(), file.basis)?.unwrap_or(LightBasis::Plain { lights });
        Error::expect_size(format!("columns of the matrix for light basis {basis}"), basis.lights(), lights)?;
        Ok((responses, basis))
    }
}

/// As [`agree`]; a plain number and a meaning agree where the numbers do, and the meaning holds.
fn agree_on_responses(given: Option<ResponseBasis>, carried: Option<ResponseBasis>) -> Result<ResponseBasis> {
    let same = given.as_ref().zip(carried.as_ref()).is_some_and(|(a, b)| a.responses() == b.responses());
    let (given, carried) = match (given, carried) {
        (Some(given), carried) if same && given.is_plain() => (None, carried),
        (given, Some(carried)) if same && carried.is_plain() => (given, None),
        other => other,
    };
    let plain = ResponseBasis::Plain { responses: 1 };
    Ok(agree("responses of a sample", given, carried)?.unwrap_or(plain))
}

fn agree<T: PartialEq + ToString>(what: &str, given: Option<T>, carried: Option<T>) -> Result<Option<T>> {
    match (given, carried) {
        (Some(given), Some(carried)) if given != carried => Err(Error::Unsupported {
            what: format!("{what} given for a file that carries its own"),
            expected: carried.to_string(),
            found: given.to_string(),
        }),
        (given, carried) => Ok(given.or(carried)),
    }
}

/// Reads `.npz`, `.npy` or `.mtx`.
pub fn read(path: impl AsRef<Path>, description: &Description) -> Result<TransferMatrix> {
    let path = path.as_ref();
    match extension(path).as_str() {
        "npz" => Ok(npz::read(path, description)?.matrix),
        "npy" => npy::read(path, description),
        "mtx" => mtx::read(path, description),
        _ => Err(unknown_extension(path, "matrix file extension", KNOWN)),
    }
}

/// What [`read`] would read, told without reading its elements; `None` of a text, which tells nothing before.
pub fn outline(path: impl AsRef<Path>, description: &Description) -> Result<Option<(Extent, LightBasis)>> {
    let path = path.as_ref();
    match extension(path).as_str() {
        "npz" => npz::outline(path, description).map(Some),
        "npy" => npy::outline(path, description).map(Some),
        "mtx" => Ok(None),
        _ => Err(unknown_extension(path, "matrix file extension", KNOWN)),
    }
}

/// Writes `.npz`, `.npy` or `.mtx`. Only `.npz` carries the meaning of rows and columns; `.npy` keeps samples x
/// responses x lights where the matrix came so.
pub fn write(path: impl AsRef<Path>, matrix: &TransferMatrix) -> Result<()> {
    let path = path.as_ref();
    match extension(path).as_str() {
        "npz" => npz::write(path, matrix, ""),
        "npy" => npy::write(path, matrix),
        "mtx" => mtx::write(path, matrix),
        _ => Err(unknown_extension(path, "matrix file extension", KNOWN)),
    }
}

/// The extension of the kind of file that a matrix of this layout came in: `npz` for sparse, `npy` for dense.
pub fn natural_extension(layout: Layout) -> &'static str {
    match layout {
        Layout::Sparse => "npz",
        Layout::Rows | Layout::Samples => "npy",
    }
}
