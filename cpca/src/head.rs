//! The few coordinates in which most of the energy of the samples lies: distances in them bound distances.
//!
//! With an orthonormal basis of which the first h directions are the head, a vector is its h coordinates and the length of the
//! rest, its tail. Any orthonormal directions give valid bounds; those of the leading principal components give tight ones.

use ndarray::{Array2, ArrayView1, ArrayView2, ArrayViewMut2, s};
use prt_transfer::Result;
use prt_transfer::linalg;
use prt_transfer::random::Random;
use prt_transfer::samples::{Samples, square};
use rayon::prelude::*;

/// Up to so many dimensions the head is everything.
const WHOLE: usize = 48;
/// Coordinates of a head at most.
const MOST: usize = 96;
/// What a head may leave to the tails, as a part of the samples' energy around their mean.
const TAIL: f64 = 0.04;
/// Samples that decide on the directions.
const DECIDING: usize = 4096;
/// A head that leaves no more than such a part of the samples' energy around their mean is taken for everything: what clusters
/// are told apart by changes by no more than this part, the model's components are computed from whole samples.
pub(crate) const NULL: f64 = 1e-6;
/// Samples that a thread projects at a time.
pub(crate) const BLOCK: usize = 256;

/// Samples in the coordinates of a head.
pub(crate) struct Head {
    /// The mean of all samples.
    origin: Vec<f32>,
    /// size x dimension; `None` where the head is everything.
    axes: Option<Array2<f32>>,
    size: usize,
    /// count x size.
    coordinates: Vec<f32>,
    /// Of the coordinates of each sample.
    squares: Vec<f32>,
    /// Lengths of what is not in the coordinates.
    tails: Vec<f32>,
}

/// A vector seen from a head.
pub(crate) struct Seen {
    pub(crate) coordinates: Vec<f32>,
    pub(crate) tail: f64,
}

impl Head {
    pub(crate) fn of(samples: &Samples) -> Result<Head> {
        let (count, n) = (samples.count(), samples.dimension());
        let origin = mean(samples);
        let axes = if n <= WHOLE { None } else { Some(axes(samples, &origin)?) };
        let size = axes.as_ref().map_or(n, Array2::nrows);
        let mut head =
            Head { origin, axes, size, coordinates: vec![0.0; count * size], squares: Vec::new(), tails: Vec::new() };
        let mut coordinates = std::mem::take(&mut head.coordinates);
        let lengths: Vec<(f32, f32)> = coordinates
            .par_chunks_mut(BLOCK * size.max(1))
            .enumerate()
            .flat_map_iter(|(block, out)| head.project(samples, block * BLOCK, out))
            .collect();
        head.coordinates = coordinates;
        (head.squares, head.tails) = lengths.into_iter().unzip();
        Ok(head)
    }

    /// Coordinates of consecutive samples into `out`, and their squares and tails.
    fn project(&self, samples: &Samples, first: usize, out: &mut [f32]) -> Vec<(f32, f32)> {
        let (n, count) = (self.origin.len(), out.len() / self.size.max(1));
        let mut centred = samples.values()[first * n..][..count * n].to_vec();
        centred.chunks_mut(n.max(1)).for_each(|row| row.iter_mut().zip(&self.origin).for_each(|(x, o)| *x -= o));
        match &self.axes {
            None => out.copy_from_slice(&centred),
            Some(axes) => {
                let rows = ArrayView2::from_shape((count, n), &centred).expect("as many as were copied");
                let out = ArrayViewMut2::from_shape((count, self.size), out).expect("as many as were asked for");
                linalg::times_transposed(rows, axes.view(), out);
            }
        }
        let lengths = out.chunks(self.size.max(1)).zip(centred.chunks(n.max(1))).map(|(head, whole)| {
            let head = square(head);
            (head as f32, if self.axes.is_none() { 0.0 } else { (square(whole) - head).max(0.0).sqrt() as f32 })
        });
        lengths.collect()
    }

    /// Samples and their head; where nearly nothing is outside the head, the samples are those in it.
    pub(crate) fn alone<'a>(self, samples: Samples<'a>) -> (Samples<'a>, Head) {
        let sum = |lengths: &mut dyn Iterator<Item = f64>| lengths.sum::<f64>();
        let inside = sum(&mut self.squares.iter().map(|s| f64::from(*s)));
        let outside = sum(&mut self.tails.iter().map(|t| f64::from(*t).powi(2)));
        if self.axes.is_none() || outside > NULL * inside {
            return (samples, self);
        }
        let samples = samples.with_values(self.coordinates.clone(), self.size);
        let (origin, tails) = (vec![0.0; self.size], vec![0.0; self.tails.len()]);
        (samples, Head { origin, axes: None, tails, ..self })
    }

    /// Whether there are no tails.
    pub(crate) fn is_whole(&self) -> bool {
        self.axes.is_none()
    }

    pub(crate) fn size(&self) -> usize {
        self.size
    }

    /// Coordinates of a sample.
    pub(crate) fn coordinates(&self, sample: usize) -> &[f32] {
        &self.coordinates[sample * self.size..][..self.size]
    }

    pub(crate) fn square(&self, sample: usize) -> f32 {
        self.squares[sample]
    }

    pub(crate) fn tail(&self, sample: usize) -> f32 {
        self.tails[sample]
    }

    /// A point, and directions (rows of the samples' dimension).
    pub(crate) fn see(&self, point: &[f32], directions: &[f32]) -> Vec<Seen> {
        let n = point.len();
        let mut rows: Vec<f32> = point.iter().zip(&self.origin).map(|(x, o)| x - o).collect();
        rows.extend_from_slice(directions);
        let rows = Array2::from_shape_vec((1 + directions.len() / n.max(1), n), rows).expect("whole rows");
        let Some(axes) = &self.axes else {
            return rows.outer_iter().map(|row| Seen { coordinates: row.to_vec(), tail: 0.0 }).collect();
        };
        let mut heads = Array2::zeros((rows.nrows(), self.size));
        linalg::times_transposed(rows.view(), axes.view(), heads.view_mut());
        let squared = |row: ArrayView1<f32>| square(row.as_slice().expect("rows are contiguous"));
        let seen = rows.outer_iter().zip(heads.outer_iter()).map(|(row, head)| {
            let tail = (squared(row) - squared(head)).max(0.0).sqrt();
            Seen { coordinates: head.to_vec(), tail }
        });
        seen.collect()
    }
}

/// The mean of all samples: sums of blocks in their order, whatever the threads.
fn mean(samples: &Samples) -> Vec<f32> {
    let n = samples.dimension();
    let sums: Vec<Vec<f64>> = samples
        .values()
        .par_chunks(BLOCK * n.max(1))
        .map(|block| {
            let mut sum = vec![0f64; n];
            block.chunks(n.max(1)).for_each(|row| sum.iter_mut().zip(row).for_each(|(s, x)| *s += f64::from(*x)));
            sum
        })
        .collect();
    let mut sum = vec![0f64; n];
    sums.iter().for_each(|block| sum.iter_mut().zip(block).for_each(|(s, b)| *s += b));
    sum.iter().map(|s| (s / samples.count().max(1) as f64) as f32).collect()
}

/// Leading directions of some of the samples, as many as leave little: two steps of subspace iteration from random
/// directions.
fn axes(samples: &Samples, origin: &[f32]) -> Result<Array2<f32>> {
    let n = samples.dimension();
    let stride = samples.count().div_ceil(DECIDING).max(1);
    let chosen: Vec<usize> = (0..samples.count()).step_by(stride).collect();
    let mut rows = Array2::<f32>::zeros((chosen.len(), n));
    for (mut out, &sample) in rows.outer_iter_mut().zip(&chosen) {
        out.iter_mut().zip(samples.row(sample)).zip(origin).for_each(|((out, x), o)| *out = x - o);
    }
    let whole: f64 = rows.iter().map(|v| f64::from(*v).powi(2)).sum();
    let most = MOST.min(n).min(chosen.len().max(1));
    let mut random = Random(0x5eed);
    let mut axes = Array2::from_shape_simple_fn((most, n), || random.uniform() as f32 - 0.5);
    orthonormalise(&mut axes);
    let columns = rows.t().as_standard_layout().into_owned();
    let mut energies = Vec::new();
    for _ in 0..2 {
        let mut products = Array2::<f32>::zeros((chosen.len(), most));
        multiply(&rows, &axes, &mut products);
        // Rayleigh-Ritz: turn the directions into those of descending energy.
        let mut gram = Array2::<f64>::zeros((most, most));
        linalg::add_gram(products.mapv(f64::from).view(), gram.view_mut());
        let spectrum = linalg::eigen(gram.view())?;
        let turn = spectrum.vectors.mapv(|v| v as f32);
        let mut turned = Array2::<f32>::zeros((chosen.len(), most));
        multiply(&products, &turn, &mut turned);
        let turned = turned.t().as_standard_layout().into_owned();
        multiply(&turned, &columns, &mut axes);
        orthonormalise(&mut axes);
        energies = spectrum.values;
    }
    let mut left = whole;
    let needed = energies.iter().take_while(|energy| {
        let more = left > TAIL * whole;
        left -= **energy;
        more
    });
    let size = needed.count().next_multiple_of(8).clamp(8.min(most), most);
    Ok(axes.slice(s![..size, ..]).as_standard_layout().into_owned())
}

/// `out` = `a` · `b`ᵀ by blocks of rows on all threads.
fn multiply(a: &Array2<f32>, b: &Array2<f32>, out: &mut Array2<f32>) {
    out.axis_chunks_iter_mut(ndarray::Axis(0), BLOCK).into_par_iter().enumerate().for_each(|(block, out)| {
        let first = block * BLOCK;
        linalg::times_transposed(a.slice(s![first..first + out.nrows(), ..]), b.view(), out);
    });
}

/// Gram and Schmidt, twice, in double precision; directions that are none become zero.
fn orthonormalise(rows: &mut Array2<f32>) {
    let mut done: Vec<Vec<f64>> = Vec::with_capacity(rows.nrows());
    for mut row in rows.outer_iter_mut() {
        let mut v: Vec<f64> = row.iter().map(|v| f64::from(*v)).collect();
        let before = v.iter().map(|v| v * v).sum::<f64>();
        for _ in 0..2 {
            for other in &done {
                let a: f64 = v.iter().zip(other).map(|(v, o)| v * o).sum();
                v.iter_mut().zip(other).for_each(|(v, o)| *v -= a * o);
            }
        }
        let after = v.iter().map(|v| v * v).sum::<f64>();
        let scale = if after > 1e-10 * before { 1.0 / after.sqrt() } else { 0.0 };
        row.iter_mut().zip(&v).for_each(|(out, v)| *out = (v * scale) as f32);
        if scale > 0.0 {
            v.iter_mut().for_each(|v| *v *= scale);
            done.push(v);
        }
    }
}
