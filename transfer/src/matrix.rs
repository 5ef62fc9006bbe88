//! Transfer matrices: sparse or dense inside, one interface outside.

use crate::basis::LightBasis;
use crate::error::{Error, Result};
use crate::responses::ResponseBasis;
use ndarray::{ArrayView2, ArrayViewMut2};
use rayon::prelude::*;

/// Most rows of a matrix without columns.
const MAX_EMPTY_ROWS: usize = 1 << 20;

/// Most light coefficients (columns) a matrix may have: a cubemap of 6 x 2048 x 2048 texels fits.
pub const MAX_LIGHTS: usize = 1 << 25;

/// Rows = samples x responses, columns = lights.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shape {
    /// Surface points.
    pub samples: usize,
    /// Outputs of each sample: local directions, exit coefficients, BRDF terms, or 1.
    pub responses: usize,
    /// Light coefficients.
    pub lights: usize,
}

impl Shape {
    /// A shape whose sizes multiply without overflow and whose lights do not exceed [`MAX_LIGHTS`].
    pub fn new(samples: usize, responses: usize, lights: usize) -> Result<Shape> {
        if responses == 0 {
            return Err(Error::Unsupported {
                what: "responses per sample".into(),
                expected: "at least 1".into(),
                found: "0".into(),
            });
        }
        if lights > MAX_LIGHTS {
            return Err(Error::TooLarge {
                what: "light coefficients".into(),
                limit: MAX_LIGHTS as u64,
                found: lights as u64,
            });
        }
        // Rows without lights have no elements that a file would have to hold: nothing else would bound their number.
        if let (0, Some(rows)) = (lights, samples.checked_mul(responses).filter(|rows| *rows > MAX_EMPTY_ROWS)) {
            return Err(Error::TooLarge {
                what: "rows without lights".into(),
                limit: MAX_EMPTY_ROWS as u64,
                found: rows as u64,
            });
        }
        let cells = samples.checked_mul(responses).and_then(|rows| rows.checked_mul(lights.max(1)));
        match cells {
            Some(cells) if cells <= isize::MAX as usize / 8 => Ok(Shape { samples, responses, lights }),
            _ => Err(Error::TooLarge {
                what: format!("{samples} samples x {responses} responses x {lights} lights"),
                limit: isize::MAX as u64 / 8,
                found: u64::MAX,
            }),
        }
    }
    /// Rows of the matrix: samples x responses.
    pub fn rows(&self) -> usize {
        self.samples * self.responses
    }
}

/// One row as it is stored.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Row<'a> {
    /// Ascending columns and their values.
    Sparse {
        /// Columns.
        columns: &'a [u32],
        /// Values, none of them 0.
        values: &'a [f32],
    },
    /// Every column.
    Dense(&'a [f32]),
}

impl Row<'_> {
    /// Writes the row into `out`, zeros included; `out.len()` = lights.
    pub fn gather(&self, out: &mut [f32]) {
        match *self {
            Row::Dense(values) => out.copy_from_slice(values),
            Row::Sparse { columns, values } => {
                out.fill(0.0);
                columns.iter().zip(values).for_each(|(&col, &value)| out[col as usize] = value);
            }
        }
    }
    /// Non-zero elements, columns ascending.
    pub fn non_zeros(&self) -> impl Iterator<Item = (usize, f32)> + '_ {
        let (columns, values): (&[u32], &[f32]) = match *self {
            Row::Sparse { columns, values } => (columns, values),
            Row::Dense(values) => (&[], values),
        };
        let dense = columns.is_empty();
        let column = move |i: usize| if dense { i } else { columns[i] as usize };
        values.iter().enumerate().filter(|(_, v)| **v != 0.0).map(move |(i, &v)| (column(i), v))
    }
}

/// The non-zero elements in compressed rows. Built through [`TransferMatrix::from_csr`], which checks it.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct SparseRows {
    /// `rows + 1` offsets into the other two.
    pub(crate) offsets: Vec<usize>,
    pub(crate) columns: Vec<u32>,
    pub(crate) values: Vec<f32>,
}

/// How a matrix came, so that decoding gives back the same kind of file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Layout {
    /// Compressed rows (`.npz`, `.mtx`).
    Sparse,
    /// rows x lights (2-D `.npy`).
    Rows,
    /// samples x responses x lights (3-D `.npy`).
    Samples,
}

#[derive(Clone, Debug, PartialEq)]
enum Storage {
    Sparse(SparseRows),
    /// Row-major, rows x lights.
    Dense(Vec<f32>),
}

/// The operator that turns light coefficients into responses: `y = T x`.
///
/// Row `s * responses + r` is response `r` of sample `s`. Column `k` multiplies light coefficient `x[k]` of the
/// [`LightBasis`]. Values are finite `f32`.
#[derive(Clone, Debug, PartialEq)]
pub struct TransferMatrix {
    layout: Layout,
    shape: Shape,
    basis: LightBasis,
    responses: ResponseBasis,
    storage: Storage,
}

impl TransferMatrix {
    /// A sparse matrix from compressed rows: `offsets.len()` = rows + 1, columns ascending strictly within a row,
    /// values finite. Stored zeros are removed. `rows` must be a multiple of `responses`.
    pub fn from_csr(
        offsets: Vec<usize>,
        columns: Vec<u32>,
        values: Vec<f32>,
        responses: usize,
        basis: LightBasis,
    ) -> Result<TransferMatrix> {
        let rows =
            offsets.len().checked_sub(1).ok_or(Error::Shape { what: "row offsets".into(), expected: 1, found: 0 })?;
        let shape = shape_of_rows(rows, responses, basis.lights())?;
        Error::expect_size("values beside columns", columns.len(), values.len())?;
        Error::expect_size("first row offset", 0, offsets[0])?;
        Error::expect_size("last row offset", columns.len(), offsets[rows])?;
        if let Some(row) = offsets.windows(2).position(|w| w[0] > w[1]) {
            return Err(Error::Shape {
                what: format!("offsets of row {row} descend"),
                expected: offsets[row],
                found: offsets[row + 1],
            });
        }
        (0..rows).into_par_iter().try_for_each(|row| {
            let mut previous = -1i64;
            for position in offsets[row]..offsets[row + 1] {
                let col = columns[position];
                if i64::from(col) <= previous || col as usize >= shape.lights {
                    return Err(Error::Columns { row, position, col: col.into(), previous, cols: shape.lights });
                }
                previous = col.into();
                let value = values[position];
                if !value.is_finite() {
                    return Err(Error::NotFinite { row, col: col as usize, value: value.into() });
                }
            }
            Ok(())
        })?;
        let mut sparse = SparseRows { offsets, columns, values };
        if sparse.values.contains(&0.0) {
            sparse.drop_zeros();
        }
        let responses = ResponseBasis::Plain { responses };
        Ok(TransferMatrix { layout: Layout::Sparse, shape, basis, responses, storage: Storage::Sparse(sparse) })
    }

    /// A dense matrix from row-major values, rows x lights, all finite.
    pub fn from_dense(values: Vec<f32>, rows: usize, responses: usize, basis: LightBasis) -> Result<TransferMatrix> {
        let shape = shape_of_rows(rows, responses, basis.lights())?;
        Error::expect_size("values of a dense matrix", rows * shape.lights, values.len())?;
        // Whole chunks without an early exit, which the compiler turns into vector code; the place only where there is
        // one.
        const CHUNK: usize = 1 << 14;
        let bad = values.par_chunks(CHUNK).enumerate().find_map_first(|(i, chunk)| {
            let finite = chunk.iter().fold(true, |finite, v| finite & v.is_finite());
            if finite { None } else { chunk.iter().position(|v| !v.is_finite()).map(|at| i * CHUNK + at) }
        });
        if let Some(at) = bad {
            return Err(Error::NotFinite { row: at / shape.lights, col: at % shape.lights, value: values[at].into() });
        }
        let responses = ResponseBasis::Plain { responses };
        Ok(TransferMatrix { layout: Layout::Rows, shape, basis, responses, storage: Storage::Dense(values) })
    }

    /// Samples, responses and lights.
    pub fn shape(&self) -> Shape {
        self.shape
    }
    /// samples x responses
    pub fn rows(&self) -> usize {
        self.shape.rows()
    }
    /// Light coefficients.
    pub fn lights(&self) -> usize {
        self.shape.lights
    }
    /// What the columns stand for.
    pub fn basis(&self) -> &LightBasis {
        &self.basis
    }
    /// What the responses of a sample stand for.
    pub fn responses(&self) -> &ResponseBasis {
        &self.responses
    }
    /// How the matrix came.
    pub fn layout(&self) -> Layout {
        self.layout
    }
    /// Whether the elements are stored as compressed rows.
    pub fn is_sparse(&self) -> bool {
        self.layout == Layout::Sparse
    }
    /// A dense matrix that came as samples x responses x lights. A sparse one has no such form and stays as it is.
    pub fn by_samples(mut self) -> TransferMatrix {
        if self.layout == Layout::Rows {
            self.layout = Layout::Samples;
        }
        self
    }
    /// Elements that are not 0.
    pub fn non_zeros(&self) -> usize {
        match &self.storage {
            Storage::Sparse(sparse) => sparse.values.len(),
            Storage::Dense(values) => values.par_iter().filter(|v| **v != 0.0).count(),
        }
    }
    /// The elements of one row as they are stored.
    pub fn row(&self, row: usize) -> Row<'_> {
        match &self.storage {
            Storage::Sparse(sparse) => {
                let range = sparse.offsets[row]..sparse.offsets[row + 1];
                Row::Sparse { columns: &sparse.columns[range.clone()], values: &sparse.values[range] }
            }
            Storage::Dense(values) => Row::Dense(&values[row * self.shape.lights..][..self.shape.lights]),
        }
    }
    /// Writes one row into `out`, zeros included; `out.len()` = lights.
    pub fn gather(&self, row: usize, out: &mut [f32]) {
        self.row(row).gather(out);
    }
    /// Offsets, columns and values where the matrix is sparse.
    pub fn as_csr(&self) -> Option<(&[usize], &[u32], &[f32])> {
        match &self.storage {
            Storage::Sparse(s) => Some((&s.offsets, &s.columns, &s.values)),
            Storage::Dense(_) => None,
        }
    }
    /// Row-major values where the matrix is dense.
    pub fn as_dense(&self) -> Option<&[f32]> {
        match &self.storage {
            Storage::Sparse(_) => None,
            Storage::Dense(values) => Some(values),
        }
    }
    /// The same matrix with other columns' meaning; the number of lights must agree.
    pub fn with_basis(self, basis: LightBasis) -> Result<TransferMatrix> {
        Error::expect_size(format!("lights of basis {basis}"), self.shape.lights, basis.lights())?;
        Ok(TransferMatrix { basis, ..self })
    }
    /// The same matrix with other responses' meaning; their number must agree.
    pub fn with_responses(self, responses: ResponseBasis) -> Result<TransferMatrix> {
        responses.check(self.shape)?;
        Ok(TransferMatrix { responses, ..self })
    }
    /// Reference relighting, accumulated in `f64`: `out` (rows x channels) = T · `lights` (lights x channels).
    pub fn apply_into(&self, lights: ArrayView2<f32>, mut out: ArrayViewMut2<f32>) -> Result<()> {
        check_apply(self.shape, &lights, &out)?;
        let channels = lights.ncols();
        out.outer_iter_mut().into_par_iter().enumerate().for_each_init(
            || vec![0f64; channels],
            |sums, (row, mut out)| {
                sums.fill(0.0);
                for (col, value) in self.row(row).non_zeros() {
                    sums.iter_mut().zip(lights.row(col)).for_each(|(sum, &x)| *sum += f64::from(value) * f64::from(x));
                }
                out.iter_mut().zip(sums).for_each(|(y, sum)| *y = *sum as f32);
            },
        );
        Ok(())
    }
}

fn shape_of_rows(rows: usize, responses: usize, lights: usize) -> Result<Shape> {
    if responses == 0 || !rows.is_multiple_of(responses) {
        return Err(Error::Unsupported {
            what: "responses per sample".into(),
            expected: format!("a divisor of {rows} rows"),
            found: responses.to_string(),
        });
    }
    Shape::new(rows / responses, responses, lights)
}

/// Refuses light and output arrays that do not fit `shape`: lights x channels and rows x channels.
pub fn check_apply(shape: Shape, lights: &ArrayView2<f32>, out: &ArrayViewMut2<f32>) -> Result<()> {
    Error::expect_size("light coefficients (rows of the light array)", shape.lights, lights.nrows())?;
    Error::expect_size("rows of the output array", shape.rows(), out.nrows())?;
    Error::expect_size("channels of the output array", lights.ncols(), out.ncols())
}

impl SparseRows {
    fn drop_zeros(&mut self) {
        let mut kept = 0;
        for row in 0..self.offsets.len() - 1 {
            let range = self.offsets[row]..self.offsets[row + 1];
            self.offsets[row] = kept;
            for from in range {
                if self.values[from] != 0.0 {
                    self.values[kept] = self.values[from];
                    self.columns[kept] = self.columns[from];
                    kept += 1;
                }
            }
        }
        if let Some(last) = self.offsets.last_mut() {
            *last = kept;
        }
        self.values.truncate(kept);
        self.columns.truncate(kept);
    }
}
