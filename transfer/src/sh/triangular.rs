//! Lower triangular square roots of Gram matrices.

/// L with G = L Lᵀ and a positive diagonal.
pub(super) struct Lower {
    n: usize,
    /// Row by row, n x n; what is above the diagonal is not used.
    values: Vec<f64>,
}

impl Lower {
    /// The Cholesky factor of the lower triangle of a Gram matrix whose diagonal is at most about 1; `None` where it is
    /// nearly singular.
    pub(super) fn cholesky(mut g: Vec<f64>, n: usize) -> Option<Lower> {
        // Below this share of its length a harmonic is not told from those before it.
        const LEAST_PIVOT: f64 = 1e-3;
        for i in 0..n {
            let (before, row) = g.split_at_mut(i * n);
            for j in 0..i {
                let known = &before[j * n..][..=j];
                row[j] = (row[j] - dot(&row[..j], known)) / known[j];
            }
            let pivot = row[i] - dot(&row[..i], &row[..i]);
            if pivot.is_nan() || pivot < LEAST_PIVOT {
                return None;
            }
            row[i] = pivot.sqrt();
        }
        Some(Lower { n, values: g })
    }

    /// The same factor of the Gram matrix of linearly independent `vectors`, which is not formed: its condition is the
    /// square of theirs. Row k of L is vector k in the coordinates of the orthonormal vectors made of it and those
    /// before it.
    pub(super) fn gram_schmidt(mut vectors: Vec<Vec<f64>>) -> Lower {
        let n = vectors.len();
        let mut values = vec![0f64; n * n];
        for (k, row) in values.chunks_mut(n.max(1)).enumerate() {
            let (before, rest) = vectors.split_at_mut(k);
            // The second pass takes out what the rounding of the first left in (Giraud et al. 2005: twice is enough).
            for _ in 0..2 {
                for (q, l) in before.iter().zip(&mut *row) {
                    let along = dot(q, &rest[0]);
                    *l += along;
                    rest[0].iter_mut().zip(q).for_each(|(v, q)| *v -= along * q);
                }
            }
            row[k] = dot(&rest[0], &rest[0]).sqrt();
            rest[0].iter_mut().for_each(|v| *v /= row[k]);
        }
        Lower { n, values }
    }

    /// Row `i` up to the diagonal.
    pub(super) fn row(&self, i: usize) -> &[f64] {
        &self.values[i * self.n..][..=i]
    }

    /// Memory of the values.
    pub(super) fn bytes(&self) -> usize {
        size_of_val(&self.values[..])
    }

    /// `x` becomes G⁻¹ x.
    pub(super) fn solve(&self, x: &mut [f64]) {
        for i in 0..self.n {
            x[i] = (x[i] - dot(&self.row(i)[..i], x)) / self.row(i)[i];
        }
        for i in (0..self.n).rev() {
            x[i] /= self.row(i)[i];
            let known = x[i];
            x[..i].iter_mut().zip(self.row(i)).for_each(|(x, l)| *x -= l * known);
        }
    }

    /// `rows` become Lᵀ · rows.
    pub(super) fn transposed_product(&self, rows: &mut Rows) {
        for j in 0..self.n {
            rows.scale(j, self.row(j)[j]);
            (j + 1..self.n).for_each(|i| rows.add(j, self.row(i)[j], i));
        }
    }

    /// `rows` become L⁻¹ · rows.
    pub(super) fn forward(&self, rows: &mut Rows) {
        for i in 0..self.n {
            self.row(i)[..i].iter().enumerate().for_each(|(j, l)| rows.add(i, -l, j));
            rows.scale(i, 1.0 / self.row(i)[i]);
        }
    }

    /// `rows` become L⁻ᵀ · rows.
    pub(super) fn backward(&self, rows: &mut Rows) {
        for i in (0..self.n).rev() {
            rows.scale(i, 1.0 / self.row(i)[i]);
            self.row(i)[..i].iter().enumerate().for_each(|(j, l)| rows.add(j, -l, i));
        }
    }
}

pub(super) fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Some rows of a row-major matrix: row i of these is its row `places[i]`.
pub(super) struct Rows<'a> {
    pub(super) matrix: &'a mut [f64],
    pub(super) width: usize,
    /// Distinct.
    pub(super) places: &'a [usize],
}

impl Rows<'_> {
    fn range(&self, i: usize) -> std::ops::Range<usize> {
        let start = self.places[i] * self.width;
        start..start + self.width
    }

    fn scale(&mut self, i: usize, factor: f64) {
        let row = self.range(i);
        self.matrix[row].iter_mut().for_each(|v| *v *= factor);
    }

    /// Row `to` += `factor` · row `from`.
    fn add(&mut self, to: usize, factor: f64, from: usize) {
        let ranges = [self.range(to), self.range(from)];
        // Places are distinct, so the rows never overlap.
        if let Ok([to, from]) = self.matrix.get_disjoint_mut(ranges) {
            to.iter_mut().zip(from).for_each(|(to, from)| *to += factor * *from);
        }
    }
}
