//! Unfoldings that are never formed: products with a mode of an array, in blocks of a fixed size.
//!
//! In C order mode n of an array is `outer` slabs, each of I_n rows of `inner` numbers side by side; its unfolding X (I_n x
//! outer·inner) has the slabs next to one another. The last mode is one matrix, transposed; the first one is one slab. What is
//! read at a time is a block: some columns of X, in double precision. Sums over blocks are taken in groups whose number does not
//! depend on that of threads, and in order.

use ndarray::{Array2, Array3, ArrayD, ArrayView2, ArrayViewD, ArrayViewMut3, Axis, s};
use prt_transfer::linalg;
use prt_transfer::random::Random;
use rayon::prelude::*;
use std::ops::Range;

/// Numbers in a block, about.
const BLOCK: usize = 1 << 18;
/// Columns of a block at least, where there are as many.
const COLUMNS: usize = 256;
/// Numbers that partial sums hold at most, all together; there are at least two of them.
const PARTIAL: usize = 1 << 24;
/// Partial sums at most.
const GROUPS: usize = 16;

/// What arrays are made of.
pub(super) trait Element: Copy + Into<f64> + Send + Sync {}

impl Element for f32 {}
impl Element for f64 {}

/// ‖T‖².
pub(super) fn energy<T: Element>(tensor: &ArrayViewD<T>) -> f64 {
    let square = |value: &T| {
        let value: f64 = (*value).into();
        value * value
    };
    let parts: Vec<f64> = values(tensor).par_chunks(BLOCK).map(|part| part.iter().map(square).sum()).collect();
    parts.iter().sum()
}

/// The elements in C order.
pub(super) fn values<'a, T>(tensor: &ArrayViewD<'a, T>) -> &'a [T] {
    tensor.to_slice().expect("arrays are in C order here: copied on the way in")
}

/// X of one mode.
#[derive(Clone, Copy)]
pub(super) struct Unfolding<'a, T> {
    values: &'a [T],
    outer: usize,
    rows: usize,
    inner: usize,
}

/// Columns of an unfolding: these numbers of the rows of these slabs.
#[derive(Clone)]
struct Block {
    outer: Range<usize>,
    inner: Range<usize>,
}

impl Block {
    fn columns(&self) -> usize {
        self.outer.len() * self.inner.len()
    }
}

impl<'a, T: Element> Unfolding<'a, T> {
    /// Of an array in C order.
    pub(super) fn new(tensor: &ArrayViewD<'a, T>, mode: usize) -> Self {
        let shape = tensor.shape();
        let (outer, inner) = (shape[..mode].iter().product(), shape[mode + 1..].iter().product());
        Unfolding { values: values(tensor), outer, rows: shape[mode], inner }
    }

    /// I_n.
    pub(super) fn rows(&self) -> usize {
        self.rows
    }

    /// The product of the other sizes.
    pub(super) fn columns(&self) -> usize {
        self.outer * self.inner
    }

    /// ‖X‖².
    pub(super) fn energy(&self) -> f64 {
        energy(&ArrayViewD::from_shape(vec![self.values.len()], self.values).expect("one mode"))
    }

    /// X Xᵀ (rows x rows).
    pub(super) fn gram(&self) -> Array2<f64> {
        let half = self.sum(&self.blocks(), self.rows, self.rows, |_, block, sum| {
            let x = self.block(0..self.rows, block);
            add_half_gram(x, !self.is_last(), sum);
        });
        mirrored(half)
    }

    /// Xᵀ X (columns x columns).
    pub(super) fn gram_of_columns(&self) -> Array2<f64> {
        let (all, columns) = (self.everything(), self.columns());
        let half = self.sum(&self.bands(), columns, columns, |_, rows, sum| {
            let x = self.block(rows.clone(), &all);
            add_half_gram(x, self.is_last(), sum);
        });
        mirrored(half)
    }

    /// X Xᵀ Q (rows x k) for Q (rows x k).
    pub(super) fn gram_times(&self, q: ArrayView2<f64>) -> Array2<f64> {
        let transposed = standard(q.t());
        self.sum(&self.blocks(), self.rows, q.ncols(), |_, block, sum| {
            let x = self.natural(0..self.rows, block);
            let mut image = Array2::zeros((q.ncols(), x.ncols()));
            linalg::times(transposed.view(), x.view(), image.view_mut());
            *sum += &times_transposed(&x, &image);
        })
    }

    /// X Ω (rows x k), Ω (columns x k) random, of mean 0 and independent elements: the sum of four uniform numbers of 16 bits
    /// stands for a normal one.
    pub(super) fn sketch(&self, k: usize, seed: u64) -> Array2<f64> {
        self.sum(&self.blocks(), self.rows, k, |index, block, sum| {
            let mut random = Random(Random(Random(seed).bits() ^ index as u64).bits());
            let x = self.natural(0..self.rows, block);
            let omega = Array2::from_shape_simple_fn((k, x.ncols()), || bell(&mut random));
            *sum += &times_transposed(&x, &omega);
        })
    }

    /// X V (rows x k) for V (columns x k).
    pub(super) fn times(&self, v: ArrayView2<f64>) -> Array2<f64> {
        let mut out = Array2::zeros((self.rows, v.ncols()));
        let (bands, all) = (self.bands(), self.everything());
        let parts = out.axis_chunks_iter_mut(Axis(0), bands[0].len()).into_par_iter();
        parts.zip(&bands).for_each(|(part, rows)| {
            linalg::times(self.natural(rows.clone(), &all).view(), v, part);
        });
        out
    }

    fn is_last(&self) -> bool {
        self.inner == 1
    }

    fn everything(&self) -> Block {
        Block { outer: 0..self.outer, inner: 0..self.inner }
    }

    /// Slabs of a block, and numbers of each of their rows: one of the two is as large as it gets.
    fn tile(&self) -> [usize; 2] {
        let columns = (BLOCK / self.rows.max(1)).max(COLUMNS);
        if self.inner < columns { [columns / self.inner.max(1), self.inner.max(1)] } else { [1, columns] }
    }

    fn blocks(&self) -> Vec<Block> {
        let [slabs, wide] = self.tile();
        let of_slabs =
            |outer: Range<usize>| pieces(self.inner, wide).map(move |inner| Block { outer: outer.clone(), inner });
        pieces(self.outer, slabs).flat_map(of_slabs).collect()
    }

    /// Rows of about a block all together.
    fn bands(&self) -> Vec<Range<usize>> {
        pieces(self.rows, (BLOCK / self.columns().max(1)).max(16)).collect()
    }

    /// Rows x columns, or the transpose where the mode is the last: as they lie in memory.
    fn block(&self, rows: Range<usize>, block: &Block) -> Array2<f64> {
        let mut copy = Vec::with_capacity(rows.len() * block.columns());
        if self.is_last() {
            for slab in block.outer.clone() {
                let start = slab * self.rows;
                copy.extend(self.values[start + rows.start..start + rows.end].iter().map(|v| (*v).into()));
            }
            return Array2::from_shape_vec((block.columns(), rows.len()), copy).expect("as many as were copied");
        }
        for row in rows.clone() {
            for slab in block.outer.clone() {
                let start = (slab * self.rows + row) * self.inner;
                let run = &self.values[start + block.inner.start..start + block.inner.end];
                copy.extend(run.iter().map(|v| (*v).into()));
            }
        }
        Array2::from_shape_vec((rows.len(), block.columns()), copy).expect("as many as were copied")
    }

    /// Rows x columns.
    fn natural(&self, rows: Range<usize>, block: &Block) -> Array2<f64> {
        let copy = self.block(rows, block);
        if self.is_last() { standard(copy.t()) } else { copy }
    }

    /// What `add` makes of all items, in groups.
    fn sum<I: Sync>(
        &self,
        items: &[I],
        rows: usize,
        columns: usize,
        add: impl Fn(usize, &I, &mut Array2<f64>) + Sync,
    ) -> Array2<f64> {
        let groups = (PARTIAL / (rows * columns).max(1)).clamp(2, GROUPS);
        let size = items.len().div_ceil(groups).max(1);
        let part = |(group, items): (usize, &[I])| {
            let mut sum = Array2::zeros((rows, columns));
            items.iter().enumerate().for_each(|(i, item)| add(group * size + i, item, &mut sum));
            sum
        };
        let parts: Vec<Array2<f64>> = items.par_chunks(size).enumerate().map(part).collect();
        parts.into_iter().reduce(|sum, part| sum + part).unwrap_or_else(|| Array2::zeros((rows, columns)))
    }
}

/// T ×_n Uᵀ: mode n multiplied by `matrix` U (I_n x R), so that its size becomes R.
pub(super) fn product<T: Element>(tensor: ArrayViewD<T>, mode: usize, matrix: ArrayView2<f64>) -> ArrayD<f64> {
    let x = Unfolding::new(&tensor, mode);
    let (matrix, transposed) = (standard(matrix), standard(matrix.t()));
    let mut out = Array3::zeros((x.outer, matrix.ncols(), x.inner));
    let tiles = tiles(out.view_mut(), x.tile());
    x.blocks().into_par_iter().zip(tiles).for_each(|(block, mut tile)| {
        let values = x.block(0..x.rows, &block);
        if x.is_last() {
            let mut rows = Array2::zeros((block.columns(), matrix.ncols()));
            linalg::times(values.view(), matrix.view(), rows.view_mut());
            tile.index_axis_mut(Axis(2), 0).assign(&rows);
            return;
        }
        let (mut columns, wide) = (Array2::zeros((matrix.ncols(), block.columns())), block.inner.len());
        linalg::times(transposed.view(), values.view(), columns.view_mut());
        for (i, mut slab) in tile.outer_iter_mut().enumerate() {
            slab.assign(&columns.slice(s![.., i * wide..(i + 1) * wide]));
        }
    });
    let mut shape = tensor.shape().to_vec();
    shape[mode] = matrix.ncols();
    out.into_shape_with_order(shape).expect("as many elements")
}

/// T ×_k U_kᵀ for all modes k but `skip`, the cheapest order: with a before b it costs |T| (R_a + R_a R_b/I_a), so that modes ascend
/// by 1/I - 1/R.
pub(super) fn project<T: Element>(tensor: ArrayViewD<T>, matrices: &[Array2<f64>], skip: Option<usize>) -> ArrayD<f64> {
    let mut modes: Vec<usize> = (0..matrices.len()).filter(|mode| Some(*mode) != skip).collect();
    let cost = |mode: &usize| {
        let (rows, columns) = matrices[*mode].dim();
        1.0 / rows as f64 - 1.0 / columns as f64
    };
    modes.sort_by(|a, b| cost(a).total_cmp(&cost(b)));
    let Some((first, rest)) = modes.split_first() else { return tensor.mapv(|v| v.into()) };
    let start = product(tensor, *first, matrices[*first].view());
    rest.iter().fold(start, |array, &mode| product(array.view(), mode, matrices[mode].view()))
}

/// `x` x `x`ᵀ where rows are to be multiplied with one another, else `x`ᵀ `x`.
fn add_half_gram(x: Array2<f64>, of_rows: bool, sum: &mut Array2<f64>) {
    if of_rows {
        linalg::add_half_gram_of_rows(x.view(), sum.view_mut())
    } else {
        linalg::add_gram(x.view(), sum.view_mut())
    }
}

fn mirrored(mut half: Array2<f64>) -> Array2<f64> {
    for i in 0..half.nrows() {
        for j in 0..i {
            half[[j, i]] = half[[i, j]];
        }
    }
    half
}

/// A (m x k) · B (k x n).
pub(super) fn times(a: ArrayView2<f64>, b: ArrayView2<f64>) -> Array2<f64> {
    let mut out = Array2::zeros((a.nrows(), b.ncols()));
    linalg::times(a.as_standard_layout().view(), b.as_standard_layout().view(), out.view_mut());
    out
}

fn times_transposed(a: &Array2<f64>, b: &Array2<f64>) -> Array2<f64> {
    let mut out = Array2::zeros((a.nrows(), b.nrows()));
    linalg::times_transposed_f64(a.view(), b.view(), out.view_mut());
    out
}

/// A row-major copy where it is not.
pub(super) fn standard(matrix: ArrayView2<f64>) -> Array2<f64> {
    matrix.as_standard_layout().into_owned()
}

/// 0..`all` in pieces of `size`, the last one shorter.
fn pieces(all: usize, size: usize) -> impl Iterator<Item = Range<usize>> {
    (0..all).step_by(size).map(move |start| start..all.min(start + size))
}

/// An array in parts of so many slabs and so many numbers of the last mode.
fn tiles(array: ArrayViewMut3<f64>, [slabs, wide]: [usize; 2]) -> Vec<ArrayViewMut3<f64>> {
    split(array, Axis(0), slabs).into_iter().flat_map(|part| split(part, Axis(2), wide)).collect()
}

fn split(mut rest: ArrayViewMut3<f64>, axis: Axis, size: usize) -> Vec<ArrayViewMut3<f64>> {
    let mut parts = Vec::new();
    while rest.len_of(axis) > size {
        let (part, beyond) = rest.split_at(axis, size);
        parts.push(part);
        rest = beyond;
    }
    parts.push(rest);
    parts
}

/// Mean 0, from -2 to 2.
fn bell(random: &mut Random) -> f64 {
    let bits = random.bits();
    let sum: u64 = (0..4).map(|i| (bits >> (16 * i)) & 0xffff).sum();
    sum as f64 / 65536.0 - 131_070.0 / 65536.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use ndarray::Dimension;

    /// X by its definition: columns count the other modes in C order.
    fn unfolded(tensor: &ArrayD<f32>, mode: usize) -> Array2<f64> {
        let columns = tensor.len() / tensor.shape()[mode];
        let mut moved = tensor.view();
        for k in (0..mode).rev() {
            moved.swap_axes(k, k + 1);
        }
        let values = moved.iter().map(|v| f64::from(*v)).collect();
        Array2::from_shape_vec((tensor.shape()[mode], columns), values).unwrap()
    }

    fn arrays() -> Vec<ArrayD<f32>> {
        let shapes: [&[usize]; 9] = [
            &[7],
            &[1],
            &[3, 5],
            &[1, 4, 1],
            &[2, 3, 4],
            &[6, 1, 2, 3],
            &[2, 2, 3, 2, 2],
            // Several blocks in each mode, of slabs, of parts of slabs, and of bands.
            &[700, 3, 300],
            &[3, 1500, 200],
        ];
        let element = |i: ndarray::IxDyn| {
            let hash = i.slice().iter().fold(7usize, |hash, i| (hash * 31 + i * 17) % 1009);
            hash as f32 / 504.0 - 1.0
        };
        shapes.iter().map(|shape| ArrayD::from_shape_fn(shape.to_vec(), element)).collect()
    }

    fn assert_close(a: &Array2<f64>, b: &Array2<f64>) {
        let scale = b.iter().fold(1f64, |scale, v| scale.max(v.abs()));
        let worst = (a - b).iter().fold(0f64, |worst, d| worst.max(d.abs()));
        assert!(a.dim() == b.dim() && worst <= 1e-11 * scale, "{worst:e} of {scale:e}");
    }

    #[test]
    fn products_are_those_of_the_unfolding() {
        for tensor in arrays() {
            for mode in 0..tensor.ndim() {
                let (x, view) = (unfolded(&tensor, mode), tensor.view());
                let unfolding = Unfolding::new(&view, mode);
                let (rows, columns) = x.dim();
                assert_eq!((rows, columns), (unfolding.rows(), unfolding.columns()));
                assert!((unfolding.energy() - x.iter().map(|v| v * v).sum::<f64>()).abs() <= 1e-11 * x.len() as f64);
                let gram = x.dot(&x.t());
                assert_close(&unfolding.gram(), &gram);
                if columns <= 2000 {
                    assert_close(&unfolding.gram_of_columns(), &x.t().dot(&x));
                }
                let test = |rows: usize| Array2::from_shape_fn((rows, 2), |(i, j)| ((i * 7 + j * 3) % 5) as f64 - 2.0);
                assert_close(&unfolding.gram_times(test(rows).view()), &gram.dot(&test(rows)));
                assert_close(&unfolding.times(test(columns).view()), &x.dot(&test(columns)));
                let projected = product(tensor.view(), mode, test(rows).view()).mapv(|v| v as f32);
                let expected = test(rows).t().dot(&x);
                assert_close(&unfolded(&projected, mode), &expected.mapv(|v| f64::from(v as f32)));
            }
        }
    }

    #[test]
    fn a_sketch_is_in_the_range_differs_by_seed_and_has_the_norm_it_should() {
        for tensor in arrays() {
            let view = tensor.view();
            let x = Unfolding::new(&view, 0);
            let (a, b) = (x.sketch(64, 1), x.sketch(64, 2));
            assert!(a == x.sketch(64, 1) && a != b);
            // The variance of one of four uniform numbers is 1/12.
            let norm: f64 = a.iter().map(|v| v * v).sum::<f64>() / (64.0 / 3.0);
            assert!((0.4..2.5).contains(&(norm / x.energy())), "{norm} {}", x.energy());
        }
    }

    #[test]
    fn projections_do_not_depend_on_the_order_of_modes() {
        let tensor = &arrays()[6];
        let shape = tensor.raw_dim();
        let matrices: Vec<Array2<f64>> = shape
            .slice()
            .iter()
            .enumerate()
            .map(|(mode, &n)| Array2::from_shape_fn((n, 1 + mode % 2), |(i, j)| (i + 2 * j + mode) as f64 - 1.5))
            .collect();
        for skip in [None, Some(0), Some(3)] {
            let mut expected = tensor.mapv(f64::from);
            for mode in (0..5).filter(|mode| Some(*mode) != skip) {
                expected = product(expected.view(), mode, matrices[mode].view());
            }
            let projected = project(tensor.view(), &matrices, skip);
            assert_eq!(projected.shape(), expected.shape());
            assert!(projected.iter().zip(&expected).all(|(a, b)| (a - b).abs() <= 1e-11 * b.abs().max(1.0)));
        }
    }
}
