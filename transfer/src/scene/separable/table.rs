//! Functions of the hemisphere in a table that is cheap to read.
//!
//! Nodes form a square grid over the stereographic projection (x, y) / (1 + z), which maps the hemisphere to the unit
//! disk. It has neither pole nor seam, keeps angles, costs one division, and its cells near the horizon are half as
//! large as those at the normal. Nodes just beyond the horizon continue a function f by 2 f(horizon) - f(mirrored at
//! the horizon), so that bilinear interpolation is of second order up to the horizon.

use super::extension::{Extension, Scratch};
use glam::Vec3;
use rayon::prelude::*;

/// Cells along an edge of the square: 2.7° at the normal, 1.3° at the horizon.
const CELLS: usize = 84;

/// Values of several functions at every node.
pub(super) struct Table {
    terms: usize,
    /// At `((row * (CELLS + 1)) + column) * terms + term`.
    values: Vec<f32>,
}

impl Table {
    /// Tables of φ_k and of ψ_k cos θ.
    pub(super) fn tabulate(extension: &Extension) -> (Table, Table) {
        let odd: Vec<[bool; 2]> = extension.azimuths().map(|a| [(a.orders[0] % 2 == 1) != a.sine, a.sine]).collect();
        let terms = odd.len();
        let rows: Vec<Vec<Vec<f64>>> = (0..=CELLS / 2)
            .into_par_iter()
            .map_init(
                || extension.scratch(),
                |scratch, y| (0..=CELLS / 2).map(|x| node(extension, [x, y], terms, scratch)).collect(),
            )
            .collect();
        // A quarter is computed; parity gives the others.
        let table = |from: usize| {
            let mut values = Vec::with_capacity((CELLS + 1) * (CELLS + 1) * terms);
            for (row, column) in (0..=CELLS).flat_map(|row| (0..=CELLS).map(move |column| (row, column))) {
                let quarter = &rows[row.abs_diff(CELLS / 2)][column.abs_diff(CELLS / 2)];
                let mirrored = [column < CELLS / 2, row < CELLS / 2];
                values.extend(quarter[from..from + terms].iter().zip(&odd).map(|(value, odd)| {
                    let negative = (odd[0] && mirrored[0]) != (odd[1] && mirrored[1]);
                    if negative { -*value as f32 } else { *value as f32 }
                }));
            }
            Table { terms, values }
        };
        (table(0), table(terms))
    }

    /// Writes the functions at the unit vector `direction` to `out`; zeros at the horizon and below.
    #[inline]
    pub(super) fn read<T: From<f32>>(&self, direction: Vec3, out: &mut [T]) {
        assert_eq!(out.len(), self.terms, "one place for each term");
        if direction.z <= 0.0 {
            return out.iter_mut().for_each(|v| *v = T::from(0.0));
        }
        const HALF: f32 = 0.5 * CELLS as f32;
        let scale = HALF / (1.0 + direction.z);
        let (x, y) = (direction.x * scale + HALF, direction.y * scale + HALF);
        let (column, row) = ((x as usize).min(CELLS - 1), (y as usize).min(CELLS - 1));
        let (u, v) = (x - column as f32, y - row as f32);
        let weights = [(1.0 - u) * (1.0 - v), u * (1.0 - v), (1.0 - u) * v, u * v];
        let pair = |row: usize| {
            let first = (row * (CELLS + 1) + column) * self.terms;
            self.values[first..first + 2 * self.terms].split_at(self.terms)
        };
        let ((a, b), (c, d)) = (pair(row), pair(row + 1));
        for ((((out, a), b), c), d) in out.iter_mut().zip(a).zip(b).zip(c).zip(d) {
            *out = T::from(weights[0] * a + weights[1] * b + weights[2] * c + weights[3] * d);
        }
    }
}

/// φ_k, then ψ_k cos θ, at node (x, y), counted from the centre; zeros where no direction above the horizon needs it.
fn node(extension: &Extension, [x, y]: [usize; 2], terms: usize, scratch: &mut Scratch) -> Vec<f64> {
    // The horizon cannot be evaluated, and nothing changes so near to it.
    const HORIZON: f64 = 1e-6;
    let cell = 2.0 / CELLS as f64;
    let (x, y) = (x as f64 * cell, y as f64 * cell);
    let radius = x.hypot(y);
    let mut out = vec![0.0; 2 * terms];
    if radius > 1.0 + 2.0 * cell {
        return out;
    }
    let azimuth = if radius > 0.0 { (x / radius, y / radius) } else { (1.0, 0.0) };
    let z = (1.0 - radius * radius) / (1.0 + radius * radius);
    let (view, light) = out.split_at_mut(terms);
    extension.at(z.abs().max(HORIZON), azimuth, scratch, view, light);
    if z < 0.0 {
        let (mut horizon, mut zero) = (vec![0.0; terms], vec![0.0; terms]);
        extension.at(HORIZON, azimuth, scratch, &mut horizon, &mut zero);
        view.iter_mut().zip(&horizon).for_each(|(v, h)| *v = 2.0 * h - *v);
        light.iter_mut().for_each(|v| *v = -*v);
    }
    out
}
