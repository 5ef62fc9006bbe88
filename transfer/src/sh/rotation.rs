//! Rotation of real spherical harmonics.

use super::triangular::dot;
use crate::basis::Direction;
use crate::error::{Error, Result};

/// How a rotation or a mirror acts on coefficients of spherical harmonics of bands 0 to order-1.
///
/// With R the matrix, whose rows are the new axes in old coordinates (say tangent, bitangent and normal in those of the
/// world), a direction v has the new coordinates R v. The block diagonal orthogonal matrix D held here satisfies
///
/// ```text
/// y(R v) = D y(v)
/// ```
///
/// so that, where f(v) = Σ c_i y_i(v), the function g with g(R v) = f(v) has the coefficients D c: the same function,
/// seen from the new axes. Each band is mixed by a (2l+1) x (2l+1) block made from that of the band before it by the
/// recurrence of Ivanic and Ruedenberg (J. Phys. Chem. 100, 1996, with the corrections of 102, 1998). Its factors do
/// not depend on R: they are made once, and [`set`](Rotation::set) changes R without allocation; give each thread a
/// clone. D is orthogonal to 3e-14 up to order 16, and turns harmonics to 1e-12 up to order 24, to 1e-10 up to order
/// 64.
#[derive(Clone, Debug)]
pub struct Rotation {
    order: usize,
    /// From band 2 upward.
    recurrence: Vec<Band>,
    /// All blocks, band by band, each row by row.
    blocks: Vec<f64>,
}

/// What makes the block of band l from that of band l-1.
#[derive(Clone, Debug)]
struct Band {
    terms: Vec<Term>,
    /// The factor of each column m': 1/√d.
    columns: Vec<f64>,
}

/// `factor` · P(i; μ, ·) is a part of row m, in the paper's names.
#[derive(Clone, Debug)]
struct Term {
    /// m + l
    row: usize,
    /// i + 1
    axis: usize,
    /// μ + l - 1
    before: usize,
    factor: f64,
}

/// The first element of band l's block: Σ (2k+1)² over the bands k before it.
fn start(l: usize) -> usize {
    l * (4 * l * l).saturating_sub(1) / 3
}

impl Rotation {
    /// Bands 0 to `order`-1 with `order` from 1 to [`MAX_ORDER`](super::MAX_ORDER), and the `matrix` that
    /// [`set`](Rotation::set) takes.
    pub fn new(order: usize, matrix: [Direction; 3]) -> Result<Rotation> {
        super::check_order(order)?;
        let recurrence = (2..order).map(Band::new).collect();
        let mut rotation = Rotation { order, recurrence, blocks: vec![1.0; start(order)] };
        rotation.set(matrix)?;
        Ok(rotation)
    }

    /// Replaces the matrix. Its rows are unit vectors at right angles, of either handedness: where R Rᵀ differs from
    /// the identity by more than 1e-4 in an element it is refused, and the rotation stays what it was. Below that the
    /// orthogonal matrix nearest to it is meant, so that D is orthogonal to rounding even for frames kept in single
    /// precision.
    pub fn set(&mut self, matrix: [Direction; 3]) -> Result<()> {
        let matrix = nearest_orthogonal(matrix)?;
        // Band 1 is y, z, x.
        const AXES: [usize; 3] = [1, 2, 0];
        let one = AXES.map(|i| AXES.map(|j| matrix[i][j]));
        if self.order > 1 {
            self.blocks[1..10].copy_from_slice(one.as_flattened());
        }
        for (l, band) in (2..self.order).zip(&self.recurrence) {
            let (before, block) = self.blocks.split_at_mut(start(l));
            band.step(&one, &before[start(l - 1)..], &mut block[..start(l + 1) - start(l)]);
        }
        Ok(())
    }

    /// Bands.
    pub fn order(&self) -> usize {
        self.order
    }

    /// The block of band `l` below the order, (2l+1) x (2l+1), row by row: element (m+l, m'+l) multiplies coefficient
    /// m' to make m.
    pub fn band(&self, l: usize) -> &[f64] {
        &self.blocks[start(l)..start(l + 1)]
    }

    /// `out` = D · `coefficients`, both order² long.
    pub fn apply(&self, coefficients: &[f64], out: &mut [f64]) -> Result<()> {
        self.expect_rows(1, [coefficients.len(), out.len()])?;
        for l in 0..self.order {
            let from = &coefficients[l * l..(l + 1) * (l + 1)];
            let rows = self.band(l).chunks(from.len());
            out[l * l..].iter_mut().zip(rows).for_each(|(out, factors)| *out = dot(factors, from));
        }
        Ok(())
    }

    /// `out` = D · `matrix`, both order² x `width`, row by row: each column is rotated.
    pub fn apply_rows(&self, matrix: &[f64], out: &mut [f64], width: usize) -> Result<()> {
        self.expect_rows(width, [matrix.len(), out.len()])?;
        if width == 0 {
            return Ok(());
        }
        for l in 0..self.order {
            let rows = l * l * width..(l + 1) * (l + 1) * width;
            let from = &matrix[rows.clone()];
            for (factors, out) in self.band(l).chunks(2 * l + 1).zip(out[rows].chunks_mut(width)) {
                out.fill(0.0);
                for (factor, from) in factors.iter().zip(from.chunks(width)) {
                    out.iter_mut().zip(from).for_each(|(out, from)| *out += factor * from);
                }
            }
        }
        Ok(())
    }

    fn expect_rows(&self, width: usize, found: [usize; 2]) -> Result<()> {
        let what = || format!("matrix of {} rows and width {width} to rotate", self.order * self.order);
        found.into_iter().try_for_each(|found| Error::expect_size(what(), self.order * self.order * width, found))
    }
}

impl Band {
    fn new(l: usize) -> Band {
        let l = l as i64;
        let rows = (-l..=l).flat_map(|m| {
            // Tables 1 and 2 of the paper; a part whose μ lies outside band l-1 has the factor 0.
            let root = |square: i64| (square as f64).sqrt();
            let (a, sign) = (m.abs(), m.signum());
            let u = root((l + m) * (l - m));
            let v = 0.5 * root((l + a - 1) * (l + a));
            let w = -0.5 * root((l - a - 1) * (l - a));
            let parts = match (sign, a) {
                (0, _) => [(0, 0, u), (1, 1, -v * root(2)), (-1, -1, -v * root(2)), (1, 0, 0.0), (1, 0, 0.0)],
                (1, 1) => [(0, m, u), (1, 0, v * root(2)), (-1, 0, 0.0), (1, 2, w), (-1, -2, w)],
                (1, _) => [(0, m, u), (1, m - 1, v), (-1, 1 - m, -v), (1, m + 1, w), (-1, -m - 1, w)],
                (_, 1) => [(0, m, u), (1, 0, 0.0), (-1, 0, v * root(2)), (1, -2, w), (-1, 2, -w)],
                (_, _) => [(0, m, u), (1, m + 1, v), (-1, -m - 1, v), (1, m - 1, w), (-1, 1 - m, -w)],
            };
            let kept = parts.into_iter().filter(|&(_, _, factor)| factor != 0.0);
            kept.map(move |(i, mu, factor)| Term {
                row: (m + l) as usize,
                axis: (i + 1) as usize,
                before: (mu + l - 1) as usize,
                factor,
            })
        });
        let d = |m: i64| if m.abs() == l { 2 * l * (2 * l - 1) } else { (l + m) * (l - m) };
        Band { terms: rows.collect(), columns: (-l..=l).map(|m| 1.0 / (d(m) as f64).sqrt()).collect() }
    }

    /// Makes the block of this band from that of band 1 and that `before` it.
    fn step(&self, one: &[[f64; 3]; 3], before: &[f64], block: &mut [f64]) {
        let size = self.columns.len();
        block.fill(0.0);
        for term in &self.terms {
            let from = &before[term.before * (size - 2)..][..size - 2];
            let to = &mut block[term.row * size..][..size];
            let [y, z, x] = one[term.axis].map(|r| term.factor * r);
            let (first, last) = (from[0], from[size - 3]);
            to[0] += x * first + y * last;
            to[size - 1] += x * last - y * first;
            to[1..].iter_mut().zip(from).for_each(|(to, from)| *to += z * from);
        }
        for row in block.chunks_mut(size) {
            row.iter_mut().zip(&self.columns).for_each(|(value, factor)| *value *= factor);
        }
    }
}

/// The orthogonal factor of the polar decomposition, of a matrix that is orthogonal to 1e-4.
fn nearest_orthogonal(mut r: [Direction; 3]) -> Result<[Direction; 3]> {
    let products = |r: &[Direction; 3]| -> [[f64; 3]; 3] {
        std::array::from_fn(|i| std::array::from_fn(|j| (0..3).map(|k| r[i][k] * r[j][k]).sum()))
    };
    let identity = |i, j| if i == j { 1.0 } else { 0.0 };
    // Newton and Schulz: R ← (3I - RRᵀ) R / 2 turns a deviation of 1e-4 into 1e-8, and that into rounding.
    for _ in 0..2 {
        let p = products(&r);
        for (k, p) in p.as_flattened().iter().enumerate() {
            let off = (p - identity(k / 3, k % 3)).abs();
            if off.is_nan() || off > 1e-4 {
                return Err(Error::Unsupported {
                    what: format!("rotation of spherical harmonics by {r:?}"),
                    expected: "rows that are unit vectors at right angles, to 1e-4".into(),
                    found: format!("a product of rows {} and {} that is off by {off:.1e}", k / 3, k % 3),
                });
            }
        }
        r = std::array::from_fn(|i| {
            std::array::from_fn(|j| (0..3).map(|k| 0.5 * (3.0 * identity(i, k) - p[i][k]) * r[k][j]).sum())
        });
    }
    Ok(r)
}

#[cfg(test)]
mod tests;
