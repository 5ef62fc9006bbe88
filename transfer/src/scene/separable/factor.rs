//! Singular values and functions of a BRDF, block by block.

use super::kernel::{Kernel, Moments, Resolution};
use super::svd::Svd;
use crate::error::Result;
use nalgebra::DMatrix;
use rayon::prelude::*;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// Singular values nearer than this, relatively, are ties.
const TIE: f64 = 1e-9;

/// Functions of the azimuth that one block of the operator maps to each other: cos mφ, or sin mφ, of some orders m. cos
/// mφ is even in y and sin mφ odd; in x, cos mφ is even for even m, and sin mφ for odd m.
#[derive(Clone, Debug)]
pub(super) struct Azimuths {
    /// sin mφ instead of cos mφ.
    pub(super) sine: bool,
    /// The orders m, ascending.
    pub(super) orders: Vec<usize>,
}

/// A pair of singular functions f(z, φ) = Σ_m f_m(z) c_m(φ), c_m the normalised cosine or sine.
pub(super) struct Factor {
    /// Its functions of the azimuth.
    pub(super) azimuths: Azimuths,
    /// The singular value.
    pub(super) sigma: f64,
    /// f_m at ring i, times the square root of its weight, at `m_index * rings + i`: of the views,
    pub(super) view: Vec<f64>,
    /// and of the lights. Both have length 1.
    pub(super) light: Vec<f64>,
}

/// c_m is cos mφ or sin mφ divided by this.
pub(in crate::scene) fn norm(order: usize) -> f64 {
    if order == 0 { TAU.sqrt() } else { PI.sqrt() }
}

/// Every factor, by descending singular value, and the sum of all squared singular values of the whole operator, with
/// those beyond the resolution.
pub(super) fn factor(kernel: &Kernel, resolution: Resolution) -> Result<(Vec<Factor>, f64)> {
    let (blocks, energy) = if resolution.sectors == 1 {
        isotropic(kernel, resolution.orders)
    } else {
        anisotropic(kernel, resolution.orders, resolution.sectors)
    };
    let decomposed: Vec<Vec<Factor>> =
        blocks.into_par_iter().map(|(azimuths, matrix)| decompose(&azimuths, matrix)).collect::<Result<_>>()?;
    let numbered = decomposed.into_iter().enumerate();
    let mut factors: Vec<(usize, Factor)> =
        numbered.flat_map(|(b, list)| list.into_iter().map(move |f| (b, f))).collect();
    factors.sort_by(|(_, a), (_, b)| b.sigma.total_cmp(&a.sigma));
    for run in factors.chunk_by_mut(|(_, a), (_, b)| b.sigma >= (1.0 - TIE) * a.sigma) {
        run.sort_by_key(|(block, _)| *block);
    }
    Ok((factors.into_iter().map(|(_, f)| f).collect(), energy))
}

/// A part of the operator that maps some functions of the azimuth to each other, and the same matrix for each set of
/// them.
type Block = (Vec<Azimuths>, DMatrix<f64>);

/// The blocks of an operator that knows only relative azimuths: one for each order, cosine and sine alike.
fn isotropic(kernel: &Kernel, orders: usize) -> (Vec<Block>, f64) {
    let rings = &kernel.rings;
    let n = rings.len();
    let rows: Vec<(Vec<Vec<f64>>, f64)> = rings
        .par_iter()
        .map(|view| {
            let mut moments = Moments::new(orders);
            let mut energy = 0.0;
            let row = rings
                .iter()
                .map(|light| {
                    kernel.moments(view.z, (1.0, 0.0), light.z, &mut moments);
                    energy += TAU * view.view * light.light * light.z.powi(2) * moments.square;
                    let scale = (view.view * light.light).sqrt() * light.z;
                    moments.cos.iter().map(|p| scale * p).collect()
                })
                .collect();
            (row, energy)
        })
        .collect();
    let azimuths = |order: usize, sine| Azimuths { sine, orders: vec![order] };
    let block = |order: usize| {
        let pair =
            if order == 0 { vec![azimuths(0, false)] } else { vec![azimuths(order, false), azimuths(order, true)] };
        (pair, DMatrix::from_fn(n, n, |i, j| rows[i].0[j][order]))
    };
    ((0..orders).map(block).collect(), rows.iter().map(|r| r.1).sum())
}

/// The four blocks by parity in x and y.
fn anisotropic(kernel: &Kernel, orders: usize, sectors: usize) -> (Vec<Block>, f64) {
    let parity = |sine: bool, first: usize| Azimuths { sine, orders: (first..orders).step_by(2).collect() };
    let classes = [parity(false, 0), parity(false, 1), parity(true, 1), parity(true, 2)];
    let n = kernel.rings.len();
    let rows: Vec<([DMatrix<f64>; 4], f64)> =
        kernel.rings.par_iter().enumerate().map(|(i, _)| strip(kernel, &classes, orders, sectors, i)).collect();
    let block = |(c, class): (usize, &Azimuths)| {
        let size = class.orders.len() * n;
        let at = |row: usize, column: usize| rows[row % n].0[c][(row / n, column)];
        (vec![class.clone()], DMatrix::from_fn(size, size, at))
    };
    (classes.iter().enumerate().map(block).collect(), rows.iter().map(|r| r.1).sum())
}

/// The rows of the four blocks that belong to ring `i` of views: `orders of the class x (orders of the class · rings)`.
fn strip(
    kernel: &Kernel,
    classes: &[Azimuths; 4],
    orders: usize,
    sectors: usize,
    i: usize,
) -> ([DMatrix<f64>; 4], f64) {
    let (n, view) = (kernel.rings.len(), kernel.rings[i]);
    let mut out = classes.each_ref().map(|c| DMatrix::zeros(c.orders.len(), c.orders.len() * n));
    let (mut moments, mut energy) = (Moments::new(orders), 0.0);
    // By symmetry a quarter turn stands for all four.
    let share = 4.0 * FRAC_PI_2 / sectors as f64;
    for sector in 0..sectors {
        let phi = FRAC_PI_2 * (sector as f64 + 0.5) / sectors as f64;
        let turns: Vec<(f64, f64)> = (0..orders).map(|m| (m as f64 * phi).sin_cos()).collect();
        for (j, light) in kernel.rings.iter().enumerate() {
            kernel.moments(view.z, (phi.cos(), phi.sin()), light.z, &mut moments);
            energy += share * view.view * light.light * light.z.powi(2) * moments.square;
            let scale = share * (view.view * light.light).sqrt() * light.z;
            for (class, out) in classes.iter().zip(&mut out) {
                for (column, &m) in class.orders.iter().enumerate() {
                    let value = scale * moments.of(class.sine, m, turns[m]);
                    for (row, &m) in class.orders.iter().enumerate() {
                        let (sin, cos) = turns[m];
                        out[(row, column * n + j)] += value * if class.sine { sin } else { cos } / norm(m);
                    }
                }
            }
        }
    }
    (out, energy)
}

impl Moments {
    /// ∫ ρ c_m dφ over the azimuth of the light, at the view whose m-fold azimuth has this (sin, cos).
    pub(in crate::scene) fn of(&self, sine: bool, m: usize, (sin, cos): (f64, f64)) -> f64 {
        let (p, q) = (self.cos[m], self.sin[m]);
        (if sine { sin * p + cos * q } else { cos * p - sin * q }) / norm(m)
    }
}

/// The factors of a block, those of one singular value side by side in the order of `azimuths`.
fn decompose(azimuths: &[Azimuths], matrix: DMatrix<f64>) -> Result<Vec<Factor>> {
    let size = matrix.nrows();
    if size == 0 || matrix.iter().all(|v| *v == 0.0) {
        return Ok(Vec::new());
    }
    let Svd { u, sigma, v } = Svd::new(&matrix)?;
    let factors = |k: usize| {
        let (mut view, mut light): (Vec<f64>, Vec<f64>) =
            (u.column(k).iter().copied().collect(), v.column(k).iter().copied().collect());
        if is_negative(&view) {
            view.iter_mut().chain(&mut light).for_each(|x| *x = -*x);
        }
        let sigma = sigma[k];
        azimuths.iter().map(move |a| Factor { azimuths: a.clone(), sigma, view: view.clone(), light: light.clone() })
    };
    Ok((0..size).flat_map(factors).collect())
}

/// Whether the component of largest magnitude is below 0; the first of those that are as large.
fn is_negative(vector: &[f64]) -> bool {
    let largest = vector.iter().fold(0f64, |m, x| m.max(x.abs()));
    vector.iter().find(|x| x.abs() >= (1.0 - TIE) * largest).is_some_and(|x| *x < 0.0)
}
