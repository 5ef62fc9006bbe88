//! Fits a sample's frame to the rows that its columns lie in.

use super::cells::Cells;
use super::frame::{self, Frame, Quaternion, Vector, cross, dot};

/// Most steps of the refinement; a handful is usual.
const STEPS: usize = 30;

/// By how much a direction should be nearer than the next at first, so that constraints are met, not only approached, and hold
/// for the frame as it is stored.
const MARGIN: f64 = 5e-4;

/// By what a margin shrinks from step to step, since not every sample has room for it.
const SHRINK: f64 = 0.85;

/// A column's direction in the world and the response that it belongs to.
pub(super) type Observed = (Vector, usize);

/// The rotation R that makes direction d_j of the observed response j nearest to R c for as many columns c as can be found: first
/// the R with the least Σ |d_j − R c|² (Wahba's problem), then least squares on the violated constraints
/// (d_j − d_i) · R c ≥ margin, i being the nearest of the others. Constraints are those of the frame as it is stored.
pub(super) fn fit(cells: &Cells, observed: &[Observed]) -> Frame {
    let (mut q, mut margin) = (wahba(cells, observed), MARGIN);
    let mut best = (usize::MAX, Frame::of(q));
    for _ in 0..STEPS {
        let frame = Frame::of(q);
        let violated = Violated::of(cells, observed, &frame.axes(), margin);
        if violated.wrong < best.0 {
            best = (violated.wrong, frame);
        }
        if violated.wrong == 0 {
            break;
        }
        q = turned(violated.turn(), q);
        margin *= SHRINK;
    }
    best.1
}

/// Normal equations of the violated constraints in a small turn ω.
#[derive(Default)]
struct Violated {
    wrong: usize,
    matrix: [Vector; 3],
    right: Vector,
}

impl Violated {
    fn of(cells: &Cells, observed: &[Observed], axes: &[Vector; 3], margin: f64) -> Violated {
        let mut sums = Violated::default();
        for &(world, j) in observed {
            let local = frame::to_local(axes, world);
            let x = frame::above_horizon(local);
            let Some(i) = cells.rival(j, x) else { continue };
            let lead = cells.cosine(j, x) - cells.cosine(i, x);
            sums.wrong += usize::from(lead < 0.0 || (lead == 0.0 && i < j));
            if lead < margin {
                let (a, b) = (cells.direction(j), cells.direction(i));
                // Below the horizon only the azimuth counts.
                let up = if local[2] < 0.0 { 0.0 } else { a[2] - b[2] };
                // d · (ω × x) = ω · (x × d)
                sums.add(cross(local, [a[0] - b[0], a[1] - b[1], up]), margin - lead);
            }
        }
        sums
    }

    fn add(&mut self, gradient: Vector, missing: f64) {
        for (u, &g) in gradient.iter().enumerate() {
            self.right[u] += g * missing;
            self.matrix[u].iter_mut().zip(gradient).for_each(|(m, h)| *m += g * h);
        }
    }

    /// The turn of least squares, by Cramer's rule; a ridge keeps a turn that nothing determines at 0.
    fn turn(&self) -> Vector {
        let (mut a, b) = (self.matrix, self.right);
        let ridge = 1e-9 * (a[0][0] + a[1][1] + a[2][2]) + 1e-30;
        (0..3).for_each(|i| a[i][i] += ridge);
        // The matrix is symmetric: its rows are its columns.
        let volume = dot(a[0], cross(a[1], a[2]));
        let turn =
            [dot(b, cross(a[1], a[2])), dot(a[0], cross(b, a[2])), dot(a[0], cross(a[1], b))].map(|d| d / volume);
        if turn.iter().all(|w| w.is_finite()) { turn } else { [0.0; 3] }
    }
}

/// `q`, then a turn by the small rotation vector ω.
fn turned([x, y, z]: Vector, q: Quaternion) -> Quaternion {
    unit(product([1.0, x / 2.0, y / 2.0, z / 2.0], q))
}

fn product([a, b, c, d]: Quaternion, [w, x, y, z]: Quaternion) -> Quaternion {
    [
        a * w - b * x - c * y - d * z,
        a * x + b * w + c * z - d * y,
        a * y - b * z + c * w + d * x,
        a * z + b * y - c * x + d * w,
    ]
}

fn unit(q: Quaternion) -> Quaternion {
    let length = q.iter().map(|c| c * c).sum::<f64>().sqrt();
    q.map(|c| c / length)
}

/// Davenport's solution of Wahba's problem: the leading eigenvector of a symmetric 4 x 4 matrix, by squaring it again and again.
fn wahba(cells: &Cells, observed: &[Observed]) -> Quaternion {
    // B = mean of d cᵀ over unit vectors, whose singular values are at most 1.
    let mut b = [[0f64; 3]; 3];
    for &(world, j) in observed {
        let (d, weight) = (cells.direction(j), 1.0 / (dot(world, world).sqrt() * observed.len() as f64));
        for (row, d) in b.iter_mut().zip(d) {
            row.iter_mut().zip(world).for_each(|(b, c)| *b += weight * d * c);
        }
    }
    let trace = b[0][0] + b[1][1] + b[2][2];
    let odd = [b[2][1] - b[1][2], b[0][2] - b[2][0], b[1][0] - b[0][1]];
    // Shifted by 4, above every eigenvalue's size, so that the largest is the leading one.
    let mut k = [[0f64; 4]; 4];
    k[0][0] = trace + 4.0;
    for i in 0..3 {
        (k[0][i + 1], k[i + 1][0]) = (odd[i], odd[i]);
        (0..3).for_each(|j| k[i + 1][j + 1] = b[i][j] + b[j][i]);
        k[i + 1][i + 1] += 4.0 - trace;
    }
    for _ in 0..32 {
        let square = |i: usize, j: usize| (0..4).map(|l| k[i][l] * k[l][j]).sum::<f64>();
        let squared: [[f64; 4]; 4] = std::array::from_fn(|i| std::array::from_fn(|j| square(i, j)));
        let trace: f64 = (0..4).map(|i| squared[i][i]).sum();
        k = squared.map(|row| row.map(|v| v / trace));
    }
    // What is left is q qᵀ, if one eigenvalue leads: its largest column is q.
    let column = (1..4).fold(0, |best, i| if k[i][i] > k[best][best] { i } else { best });
    unit(k[column])
}
