//! Singular functions at any direction, by Nyström's extension: the operator's own integral of what is known at the
//! rings.

use super::Views;
use super::factor::{Azimuths, Factor};
use super::kernel::{Kernel, Moments, Resolution};
use crate::scene::brdf::Brdf;

/// The singular functions of the terms that are kept.
pub(super) struct Extension<'a> {
    kernel: Kernel<'a>,
    terms: Vec<Term>,
    /// Fourier orders that the terms use.
    orders: usize,
}

struct Term {
    azimuths: Azimuths,
    /// Densities at `m_index * rings + ring`, weights included: ∫ ρ(v, ·) density is φ(v),
    view: Vec<f64>,
    /// and that of lights ψ(s).
    light: Vec<f64>,
}

/// Buffers for one thread.
pub(super) struct Scratch {
    moments: Moments,
    turns: Vec<(f64, f64)>,
}

impl<'a> Extension<'a> {
    pub(super) fn new(brdf: &'a Brdf, views: Views, resolution: Resolution, factors: &[Factor]) -> Extension<'a> {
        // Fewer orders need fewer nodes of the azimuth.
        let orders = factors.iter().flat_map(|f| &f.azimuths.orders).max().map_or(0, |m| m + 1);
        let kernel = Kernel::new(brdf, views, Resolution { orders, ..resolution });
        let rings = kernel.rings.len();
        let term = |f: &Factor| Term {
            azimuths: f.azimuths.clone(),
            // φ = (1/σ) ∫ ρ cos θ χ dω, with χ the singular function of the lights.
            view: (0..f.light.len())
                .map(|i| (i, kernel.rings[i % rings]))
                .map(|(i, ring)| f.light[i] * ring.light.sqrt() * ring.z / f.sigma)
                .collect(),
            // ψ = ∫ ρ φ dμ
            light: (0..f.view.len()).map(|i| f.view[i] * kernel.rings[i % rings].view.sqrt()).collect(),
        };
        let terms = factors.iter().map(term).collect();
        Extension { kernel, terms, orders }
    }

    /// The functions of the azimuth of each term.
    pub(super) fn azimuths(&self) -> impl Iterator<Item = &Azimuths> {
        self.terms.iter().map(|t| &t.azimuths)
    }

    pub(super) fn scratch(&self) -> Scratch {
        Scratch { moments: Moments::new(self.orders), turns: vec![(0.0, 1.0); self.orders] }
    }

    /// φ_k and ψ_k cos θ of the direction with cosine `z` > 0 and azimuth (cos, sin).
    pub(super) fn at(
        &self,
        z: f64,
        (cos, sin): (f64, f64),
        scratch: &mut Scratch,
        view: &mut [f64],
        light: &mut [f64],
    ) {
        let Scratch { moments, turns } = scratch;
        for m in 1..self.orders {
            let (s, c) = turns[m - 1];
            turns[m] = (s * cos + c * sin, c * cos - s * sin);
        }
        view.fill(0.0);
        light.fill(0.0);
        let rings = &self.kernel.rings;
        for (i, ring) in rings.iter().enumerate() {
            self.kernel.moments(z, (cos, sin), ring.z, moments);
            for ((term, view), light) in self.terms.iter().zip(view.iter_mut()).zip(light.iter_mut()) {
                for (row, &m) in term.azimuths.orders.iter().enumerate() {
                    let value = moments.of(term.azimuths.sine, m, turns[m]);
                    *view += value * term.view[row * rings.len() + i];
                    *light += value * term.light[row * rings.len() + i];
                }
            }
        }
        light.iter_mut().for_each(|psi| *psi *= z);
    }
}
