//! Which local direction is nearest to a direction.

use super::frame::{Vector, dot};

/// Others kept for each direction, nearest first.
const KEPT: usize = 48;

/// Directions, each with those around it.
pub(super) struct Cells {
    directions: Vec<Vector>,
    /// Cosine and index of the others, up to [`KEPT`] for each direction.
    around: Vec<Vec<(f64, usize)>>,
}

fn wide(direction: &[f32; 3]) -> Vector {
    direction.map(f64::from)
}

/// Whether the cosine `a` of direction `i` comes before `b` of `j`: it is larger, or as large and i the lower.
fn before((a, i): (f64, usize), (b, j): (f64, usize)) -> bool {
    a > b || (a == b && i < j)
}

/// A direction that is nearer to `x` than this one, or as near and of a lower index; `guess` is tried first, since neighbouring
/// directions are often beaten by one.
pub(super) fn nearer(directions: &[[f32; 3]], than: usize, guess: usize, x: Vector) -> Option<usize> {
    let cosine = |i: usize| dot(wide(&directions[i]), x);
    let own = (cosine(than), than);
    let beats = |i: &usize| before((cosine(*i), *i), own);
    Some(guess).filter(beats).or_else(|| (0..directions.len()).find(beats))
}

impl Cells {
    pub(super) fn new(directions: &[[f32; 3]]) -> Cells {
        let directions: Vec<Vector> = directions.iter().map(wide).collect();
        let around = |of: usize| {
            let others = (0..directions.len()).filter(|&i| i != of);
            let mut others: Vec<(f64, usize)> = others.map(|i| (dot(directions[of], directions[i]), i)).collect();
            others.sort_by(|a, b| b.0.total_cmp(&a.0));
            others.truncate(KEPT);
            others.shrink_to_fit();
            others
        };
        Cells { around: (0..directions.len()).map(around).collect(), directions }
    }

    pub(super) fn direction(&self, i: usize) -> Vector {
        self.directions[i]
    }

    /// The cosine (times the length of `x`) of a direction.
    pub(super) fn cosine(&self, i: usize, x: Vector) -> f64 {
        dot(self.directions[i], x)
    }

    /// The nearest to `x` of all directions but `of`, among those that can be nearer than it; `None` where none can.
    pub(super) fn rival(&self, of: usize, x: Vector) -> Option<usize> {
        let own = self.cosine(of, x);
        let mut best: Option<(f64, usize)> = None;
        let mut consider = |i: usize| {
            let candidate = (self.cosine(i, x), i);
            if best.is_none_or(|best| before(candidate, best)) {
                best = Some(candidate);
            }
        };
        // With α the angle from x to this direction, one that is nearer lies within 2α of it: its cosine is at least
        // cos 2α = 2 cos² α − 1, less what rounding may take.
        let least = if own > 0.0 { 2.0 * own * own / dot(x, x) - 1.0 - 1e-4 } else { -2.0 };
        let around = &self.around[of];
        let near = around.iter().take_while(|(cosine, _)| *cosine >= least).count();
        if near == around.len() && near + 1 < self.directions.len() {
            (0..self.directions.len()).filter(|&i| i != of).for_each(consider);
        } else {
            around[..near].iter().for_each(|&(_, i)| consider(i));
        }
        best.map(|best| best.1)
    }

    /// The nearest to `x` of all, the lowest of several; `guess` is where the search begins.
    pub(super) fn nearest(&self, guess: usize, x: Vector) -> usize {
        let mut nearest = guess;
        while let Some(rival) = self.rival(nearest, x) {
            if !before((self.cosine(rival, x), rival), (self.cosine(nearest, x), nearest)) {
                break;
            }
            nearest = rival;
        }
        nearest
    }
}
