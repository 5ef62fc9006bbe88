//! A place in space for every light coefficient, such that coefficients which rows have in common lie close together.
//!
//! Texels lie where their directions point. Where the basis has no directions the matrix itself tells: the leading vectors of
//! its random walk row → column → row (the spectral embedding of its bipartite graph) vary slowly along the columns that rows
//! share.

use prt_transfer::TransferMatrix;
use prt_transfer::random::Random;

/// A place.
pub(crate) type Place = [f32; 3];

/// Elements that the embedding looks at, about.
const SAMPLE: usize = 1 << 20;
/// Steps of the walk. The vectors need not have converged: any smooth ones will do.
const STEPS: usize = 24;

/// One for each column of the matrix.
pub(crate) fn places(matrix: &TransferMatrix) -> Vec<Place> {
    match matrix.basis().directions() {
        Some(directions) => directions.into_iter().map(|d| d.map(|c| c as f32)).collect(),
        None => embedding(matrix),
    }
}

/// Orthogonal iteration with the random walk of every n-th row, after the constant vector has been taken out.
fn embedding(matrix: &TransferMatrix) -> Vec<Place> {
    let step = matrix.non_zeros().div_ceil(SAMPLE).max(1);
    let rows: Vec<Vec<u32>> = (0..matrix.rows())
        .step_by(step)
        .map(|row| matrix.row(row).non_zeros().map(|(column, _)| column as u32).collect())
        .collect();
    let mut degrees = vec![0f32; matrix.lights()];
    rows.iter().flatten().for_each(|&c| degrees[c as usize] += 1.0);
    let mut random = Random(1);
    let mut start = || random.below(1 << 24) as f32 / (1 << 23) as f32 - 1.0;
    let mut places: Vec<Place> = (0..matrix.lights()).map(|_| [start(), start(), start()]).collect();
    for _ in 0..STEPS {
        let mut next = vec![[0f32; 3]; places.len()];
        for row in &rows {
            let mut mean = [0f32; 3];
            row.iter().for_each(|&c| add(&mut mean, &places[c as usize]));
            let mean = mean.map(|m| m / row.len().max(1) as f32);
            row.iter().for_each(|&c| add(&mut next[c as usize], &mean));
        }
        next.iter_mut().zip(&degrees).for_each(|(p, &d)| *p = p.map(|c| c / d.max(1.0)));
        orthogonalise(&mut next, &degrees);
        places = next;
    }
    places
}

fn add(sum: &mut Place, place: &Place) {
    sum.iter_mut().zip(place).for_each(|(s, p)| *s += p);
}

/// Makes the three vectors orthogonal to the constant and to each other, of norm 1, in the walk's stationary measure.
fn orthogonalise(places: &mut [Place], degrees: &[f32]) {
    let total: f64 = degrees.iter().map(|&d| f64::from(d)).sum::<f64>().max(1.0);
    for axis in 0..3 {
        let product = |other: &dyn Fn(&Place) -> f64, places: &[Place]| -> f64 {
            places.iter().zip(degrees).map(|(p, &d)| f64::from(d) * f64::from(p[axis]) * other(p)).sum::<f64>() / total
        };
        let mean = product(&|_| 1.0, places) as f32;
        places.iter_mut().for_each(|p| p[axis] -= mean);
        for before in 0..axis {
            let overlap = product(&|p| f64::from(p[before]), places) as f32;
            places.iter_mut().for_each(|p| p[axis] -= overlap * p[before]);
        }
        let norm = product(&|p| f64::from(p[axis]), places).sqrt().max(1e-30) as f32;
        places.iter_mut().for_each(|p| p[axis] /= norm);
    }
}
