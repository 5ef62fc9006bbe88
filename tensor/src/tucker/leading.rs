//! Leading left singular vectors of an unfolding X, by its smaller Gram matrix; by iterating where both are large.

use super::params::TuckerParams;
use super::unfold::{Element, Unfolding, standard};
use ndarray::{Array2, ArrayView2, s};
use prt_transfer::{Result, linalg};

/// The smaller side of an unfolding up to which all eigenpairs of its Gram matrix are computed: 2 s at 2048, growing by the cube.
const DIRECT: usize = 2048;
/// Columns of the first sketch where the rank is not known; each further one has twice as many.
const FIRST: usize = 16;
/// Steps of the iteration at most.
const STEPS: usize = 200;
/// Steps after which what a block leaves out is believed: later ones hardly lower it.
const SETTLED: usize = 3;
/// Excess energy, of what is left over, at which the iteration ends.
const EXCESS: f64 = 1e-6;
/// The same, of all energy: rounding.
const ROUNDING: f64 = 1e-14;

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
    fn sketches(self, beyond: impl Fn(usize) -> usize) -> impl Iterator<Item = usize> {
        let (first, tries) = if self.is_open() { (FIRST, 40) } else { (self.rank, 1) };
        (0..tries).map(move |i| first << i).map(move |rank| rank + beyond(rank))
    }
}

/// Leading vectors.
pub(super) struct Leading {
    /// rows x rank, orthonormal; in descending order of what they hold.
    pub(super) vectors: Array2<f64>,
    /// Whether an iteration ended, or none was needed.
    pub(super) converged: bool,
}

/// The vectors wanted, by the direct method where that is feasible.
pub(super) fn leading<T: Element>(x: &Unfolding<T>, want: Want, params: &TuckerParams, mode: usize) -> Result<Leading> {
    let smaller = x.rows().min(x.columns());
    if smaller > DIRECT {
        for size in want.sketches(|rank| params.oversampling.max(rank / 4)) {
            if 4 * size > smaller {
                break;
            }
            if let Some(leading) = iterated(x, want, size, seed(params, mode))? {
                return Ok(leading);
            }
        }
    }
    direct(x, want)
}

/// X Xᵀ = U S² Uᵀ, or Xᵀ X = V S² Vᵀ and U = X V S⁻¹ where that is smaller. Small vectors of X V are orthogonal to rounding of the
/// largest only: each is freed of those before it.
pub(super) fn direct<T: Element>(x: &Unfolding<T>, want: Want) -> Result<Leading> {
    let by_rows = x.rows() <= x.columns();
    let gram = if by_rows { x.gram() } else { x.gram_of_columns() };
    let spectrum = linalg::eigen(gram.view())?;
    let vectors = standard(spectrum.vectors.slice(s![..want.keep(&spectrum.values), ..]).t());
    let vectors = if by_rows { vectors } else { linalg::orthonormal_columns(x.times(vectors.view()).view()) };
    Ok(Leading { vectors, converged: true })
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
    let sizes = want.sketches(|_| params.oversampling).take_while(move |size| 2 * size <= smaller);
    sizes.map(move |size| {
        let sketch = linalg::orthonormal_columns(x.sketch(size, seed(params, mode)).view());
        (0..params.power_iterations).fold(sketch, |q, _| linalg::orthonormal_columns(x.gram_times(q.view()).view()))
    })
}

/// Block subspace iteration with Rayleigh-Ritz: Z = X Xᵀ Q, the best vectors Q W of the span by the eigenpairs (θ, w) of Qᵀ Z, and
/// the next Q from Z. `None` where the tail wanted needs a larger block.
fn iterated<T: Element>(x: &Unfolding<T>, want: Want, size: usize, seed: u64) -> Result<Option<Leading>> {
    let energy = x.energy();
    let mut q = linalg::orthonormal_columns(x.sketch(size, seed).view());
    for step in 1.. {
        let z = x.gram_times(q.view());
        let spectrum = linalg::eigen(times(q.t(), z.view()).view())?;
        let w = standard(spectrum.vectors.t());
        let (vectors, images) = (times(q.view(), w.view()), times(z.view(), w.view()));
        let left = (energy - spectrum.values.iter().sum::<f64>()).max(0.0);
        if left > want.tail && want.is_open() && step == SETTLED {
            return Ok(None);
        }
        let keep = Want { tail: want.tail - left, ..want }.keep(&spectrum.values);
        let excess = excess(&vectors, &images, &spectrum.values, keep);
        let rest = energy - spectrum.values[..keep].iter().sum::<f64>();
        let converged = excess <= EXCESS * rest || excess <= ROUNDING * energy;
        if converged || step == STEPS {
            let leading = Leading { vectors: standard(vectors.slice(s![.., ..keep])), converged };
            return Ok((left <= want.tail || !want.is_open()).then_some(leading));
        }
        q = linalg::orthonormal_columns(z.view());
    }
    unreachable!("the loop ends at its last step")
}

/// By how much the energy of the first vectors can be short of the best: θ is short of an eigenvalue by ρ = ‖X Xᵀ v - θ v‖ at
/// most, and by ρ²/(θ - t) where the next value t is further below (Parlett 1980, §11.7).
fn excess(vectors: &Array2<f64>, images: &Array2<f64>, values: &[f64], keep: usize) -> f64 {
    let next = values.get(keep).copied().unwrap_or(0.0);
    let short = |i: usize| {
        let difference = &images.column(i) - &(&vectors.column(i) * values[i]);
        let (residual, gap) = (difference.dot(&difference).sqrt(), values[i] - next);
        if gap > residual { residual * residual / gap } else { residual }
    };
    (0..keep).map(short).sum()
}

pub(super) fn times(a: ArrayView2<f64>, b: ArrayView2<f64>) -> Array2<f64> {
    let mut out = Array2::zeros((a.nrows(), b.ncols()));
    linalg::times(standard(a).view(), b, out.view_mut());
    out
}

/// Modes differ in their sketches.
fn seed(params: &TuckerParams, mode: usize) -> u64 {
    params.seed.wrapping_add((mode as u64) << 32)
}
