//! Leading left singular vectors of an unfolding X, by its smaller Gram matrix.

use super::krylov::{self, Operator};
use super::params::TuckerParams;
use super::unfold::{Element, Unfolding, standard};
use ndarray::{Array2, ArrayView2, s};
use prt_transfer::{Progress, Result, linalg};

/// Up to which smaller side of an unfolding what is computed.
#[derive(Clone, Copy)]
struct Sides {
    /// All eigenpairs of its Gram matrix.
    direct: usize,
    /// That matrix.
    gram: usize,
}

/// All eigenpairs take 0.3 s at 1024, growing by the cube; the Gram matrix takes 0.1 GB at 4096, and as much for each of two partial sums.
const SIDES: Sides = Sides { direct: 1024, gram: 4096 };
/// The smaller side, in blocks, from which iterating is tried: it is twice as fast as all eigenpairs or more where spectra
/// decay, and in vain where they are flat.
const BLOCKS: usize = 16;
/// Vectors of a block where the rank is not known.
const FIRST: usize = 32;
/// Columns of the first sketch where the rank is not known; each further one has about twice as many.
const SKETCH: usize = 16;

/// How many vectors are wanted.
#[derive(Clone, Copy, Debug)]
pub(super) struct Want {
    /// At most.
    pub(super) rank: usize,
    /// As few as leave no more than this energy out.
    pub(super) tail: f64,
}

impl Want {
    /// The number of squares (descending, of which negative ones are rounding) to keep: at least one.
    pub(super) fn keep(self, squares: &[f64]) -> usize {
        let (mut keep, mut left) = (squares.len(), 0.0);
        while keep > 1 {
            left += squares[keep - 1].max(0.0);
            if left > self.tail {
                break;
            }
            keep -= 1;
        }
        keep.min(self.rank)
    }

    /// Whether only the tail says how many.
    pub(super) fn is_open(self) -> bool {
        self.rank == usize::MAX
    }

    /// Sizes of sketches to try: one where the rank is known.
    fn sketches(self, beyond: usize) -> impl Iterator<Item = usize> {
        let (first, tries) = if self.is_open() { (SKETCH, 40) } else { (self.rank, 1) };
        (0..tries).map(move |i| (first << i) + beyond)
    }
}

/// Leading vectors.
pub(super) struct Leading {
    /// rows x rank, orthonormal; in descending order of what they hold.
    pub(super) vectors: Array2<f64>,
    /// Whether an iteration ended, or none was needed.
    pub(super) converged: bool,
}

/// The vectors wanted, whatever they cost: by [`few`], else by all eigenpairs.
pub(super) fn leading<T: Element>(
    x: &Unfolding<T>,
    want: Want,
    params: &TuckerParams,
    mode: usize,
    progress: &dyn Progress,
) -> Result<Leading> {
    few(x, want, params, mode, SIDES, progress)?.map_or_else(|| direct(x, want), Ok)
}

/// The vectors wanted, by all eigenpairs of the smaller Gram matrix or, where it is large, by iterating, which asks before each product
/// whether to stop; `None` where more than half of those of a Gram matrix too large to compute would be needed.
fn few<T: Element>(
    x: &Unfolding<T>,
    want: Want,
    params: &TuckerParams,
    mode: usize,
    sides: Sides,
    progress: &dyn Progress,
) -> Result<Option<Leading>> {
    let smaller = x.rows().min(x.columns());
    let block = if want.is_open() { FIRST } else { want.rank + params.oversampling };
    if smaller <= sides.direct || BLOCKS * block > smaller {
        return direct(x, want).map(Some);
    }
    let seed = seed(params, mode);
    if smaller > sides.gram {
        let apply = |q: ArrayView2<f64>| progress.advance(0).map(|()| x.gram_times(q));
        let g = Operator { size: x.rows(), energy: x.energy(), apply: &apply };
        let leading = krylov::leading(&g, want, block, smaller / 2, seed)?;
        // Of a number of vectors those found are reported as they are.
        return Ok((leading.converged || !want.is_open()).then_some(leading));
    }
    let gram = Gram::of(x);
    let view = gram.matrix.view().into_dyn();
    let matrix = Unfolding::new(&view, 0);
    let apply = |q: ArrayView2<f64>| progress.advance(0).map(|()| matrix.times(q));
    let g = Operator { size: smaller, energy: gram.matrix.diag().sum(), apply: &apply };
    let leading = krylov::leading(&g, want, block, smaller / 4, seed)?;
    if leading.converged { Ok(Some(gram.of_rows(x, leading.vectors))) } else { gram.direct(x, want).map(Some) }
}

/// As few right singular vectors of a matrix (orthonormal rows, one at least) as leave out no more than a part of its energy; `None` where they
/// would be more than half of many.
pub(crate) fn leading_rows(matrix: ArrayView2<f32>, part: f64, progress: &dyn Progress) -> Result<Option<Array2<f64>>> {
    leading_rows_within(matrix, part, SIDES, progress)
}

fn leading_rows_within(
    matrix: ArrayView2<f32>,
    part: f64,
    sides: Sides,
    progress: &dyn Progress,
) -> Result<Option<Array2<f64>>> {
    let x = matrix.into_dyn();
    let x = Unfolding::new(&x, 1);
    let want = Want { rank: usize::MAX, tail: part * x.energy() };
    let leading = few(&x, want, &TuckerParams::default(), 1, sides, progress)?;
    Ok(leading.map(|leading| standard(leading.vectors.t())))
}

/// The vectors wanted, by all eigenpairs.
pub(super) fn direct<T: Element>(x: &Unfolding<T>, want: Want) -> Result<Leading> {
    Gram::of(x).direct(x, want)
}

/// X Xᵀ = U S² Uᵀ, or Xᵀ X = V S² Vᵀ where that is smaller.
struct Gram {
    matrix: Array2<f64>,
    by_rows: bool,
}

impl Gram {
    fn of<T: Element>(x: &Unfolding<T>) -> Gram {
        let by_rows = x.rows() <= x.columns();
        Gram { matrix: if by_rows { x.gram() } else { x.gram_of_columns() }, by_rows }
    }

    fn direct<T: Element>(&self, x: &Unfolding<T>, want: Want) -> Result<Leading> {
        let spectrum = linalg::eigen(self.matrix.view())?;
        let vectors = spectrum.vectors.slice(s![..want.keep(&spectrum.values), ..]);
        Ok(self.of_rows(x, standard(vectors.t())))
    }

    /// U = X V S⁻¹ where the vectors are V. Small vectors of X V are orthogonal to rounding of the largest only: each is freed of those
    /// before it.
    fn of_rows<T: Element>(&self, x: &Unfolding<T>, vectors: Array2<f64>) -> Leading {
        let vectors = if self.by_rows { vectors } else { linalg::orthonormal_columns(x.times(vectors.view()).view()) };
        Leading { vectors, converged: true }
    }
}

/// An orthonormal Q (rows x size) that about spans the leading vectors: of (X Xᵀ)^q X Ω, orthonormal again after each product
/// (Halko, Martinsson and Tropp 2011, Algorithm 4.4). One where the rank is known, else larger and larger; none where all
/// vectors cost about the same.
pub(super) fn range<T: Element>(
    x: &Unfolding<T>,
    want: Want,
    params: &TuckerParams,
    mode: usize,
) -> impl Iterator<Item = Array2<f64>> {
    let smaller = x.rows().min(x.columns());
    let sizes = want.sketches(params.oversampling).take_while(move |size| 2 * size <= smaller);
    sizes.map(move |size| {
        let sketch = linalg::orthonormal_columns(x.sketch(size, seed(params, mode)).view());
        (0..params.power_iterations).fold(sketch, |q, _| linalg::orthonormal_columns(x.gram_times(q.view()).view()))
    })
}

/// Modes differ in their sketches.
fn seed(params: &TuckerParams, mode: usize) -> u64 {
    params.seed.wrapping_add((mode as u64) << 32)
}

#[cfg(test)]
mod tests {
    use super::*;
    use prt_transfer::progress::Quiet;
    use prt_transfer::random::Random;

    /// A matrix with these singular values.
    fn matrix([m, n]: [usize; 2], values: &[f64], random: &mut Random) -> Array2<f32> {
        let [u, v] = [m, n].map(|size| Array2::from_shape_simple_fn((size, values.len()), || random.normal()));
        let [u, v] = [linalg::orthonormal_columns(u.view()), linalg::orthonormal_columns(v.view())];
        let scaled = Array2::from_shape_fn((m, values.len()), |(i, j)| u[[i, j]] * values[j]);
        scaled.dot(&v.t()).mapv(|x| x as f32)
    }

    #[test]
    fn leading_rows_leave_out_no_more_than_their_part_and_one_fewer_would() {
        let mut random = Random(5);
        // All eigenpairs of either Gram matrix, iterating with either, and with none.
        let [gram, none] = [Sides { direct: 0, gram: 4096 }, Sides { direct: 0, gram: 0 }];
        for (size, rank, sides) in [
            ([60, 40], 30, SIDES),
            ([30, 200], 30, SIDES),
            ([1100, 1050], 60, SIDES),
            ([600, 520], 60, gram),
            ([520, 600], 60, gram),
            ([600, 520], 60, none),
            ([520, 600], 60, none),
        ] {
            let values: Vec<f64> = (0..rank).map(|i| 0.9f64.powi(i)).collect();
            let matrix = matrix(size, &values, &mut random);
            let all: f64 = matrix.iter().map(|x| f64::from(*x).powi(2)).sum();
            for part in [0.3, 0.01] {
                let rows = leading_rows_within(matrix.view(), part, sides, &Quiet).unwrap().unwrap();
                let eye = Array2::<f64>::eye(rows.nrows());
                assert!((rows.dot(&rows.t()) - eye).iter().all(|d| d.abs() <= 1e-12), "{size:?}");
                let wide = matrix.mapv(f64::from);
                let left = (&wide - wide.dot(&rows.t()).dot(&rows)).iter().map(|d| d * d).sum::<f64>();
                let best = |k: usize| values[k..].iter().map(|v| v * v).sum::<f64>();
                assert!(left <= part * all * (1.0 + 1e-6), "{size:?}: {left} of {all}");
                assert!(best(rows.nrows() - 1) > part * all * (1.0 - 1e-6), "{size:?}: {} rows", rows.nrows());
            }
        }
        assert_eq!(leading_rows(Array2::zeros((3, 4)).view(), 0.1, &Quiet).unwrap().unwrap().dim(), (1, 4));
    }

    #[test]
    fn flat_spectra_have_all_their_rows_where_a_gram_matrix_is_there_and_none_where_it_is_not() {
        let values = [1.0; 520];
        for size in [[600, 520], [520, 600]] {
            let matrix = matrix(size, &values, &mut Random(6));
            let rows = |sides| leading_rows_within(matrix.view(), 0.1, sides, &Quiet).unwrap().map(|rows| rows.nrows());
            assert_eq!(rows(Sides { direct: 0, gram: 4096 }), Some(468), "{size:?}");
            assert_eq!(rows(Sides { direct: 0, gram: 0 }), None, "{size:?}");
        }
    }
}
