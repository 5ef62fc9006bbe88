//! What tracing took, and what went wrong on the way.

use std::ops::AddAssign;

/// Counts of a path tracer. They are whole numbers: their sum does not depend on the order.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Tally {
    /// Samples taken.
    pub paths: u64,
    /// Rays cast, those towards lights included.
    pub rays: u64,
    /// Samples darkened to [`PathParams::clamp`](super::PathParams::clamp).
    pub clamped: u64,
    /// Samples that were NaN or infinite, and were taken for 0.
    pub not_finite: u64,
}

impl AddAssign for Tally {
    fn add_assign(&mut self, other: Tally) {
        self.paths += other.paths;
        self.rays += other.rays;
        self.clamped += other.clamped;
        self.not_finite += other.not_finite;
    }
}
