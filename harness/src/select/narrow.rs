//! What a grid leaves between its points: whole numbers, and the bound itself as a parameter.

use super::bound::Bound;
use super::hunt::Hunt;
use crate::registry::families::Family;

/// Sizes nearer than this to each other are not told apart.
const NEAR: f64 = 1.04;

impl Hunt<'_, '_> {
    /// The family's parameter that takes the bound itself, where it can.
    pub(super) fn parameter(&self, family: &Family) -> Option<(&'static str, f64)> {
        match self.log.goal.bound {
            Bound::Error(bound) if bound < 1.0 => Some((family.bounded?, bound)),
            _ => None,
        }
    }

    /// Tries the bound itself as a parameter, with the best configuration or that of the start.
    pub(super) fn by_parameter(&mut self, family: &Family, start: &[usize]) {
        let Some((parameter, bound)) = self.parameter(family) else { return };
        let point = self.log.best_point().unwrap_or_else(|| start.to_vec());
        let label = self.log.grid.label_by(&point, parameter, bound);
        self.attempt_label(&label, None);
    }

    /// Halves the whole numbers between the best size and the next that does not keep the bound: what is needed in truth.
    pub(super) fn between(&mut self) -> Option<usize> {
        let (grid, best) = (self.log.grid, self.log.best_point()?);
        let next = if self.log.goal.is_kept_by_large_models() { best[0].checked_sub(1)? } else { best[0] + 1 };
        let [mut kept, mut failed] = grid.numbers(best[0], next)?;
        while kept.abs_diff(failed) > 1 && kept.max(failed) as f64 / kept.min(failed) as f64 > NEAR {
            let middle = kept.midpoint(failed);
            match self.attempt_label(&grid.label_between(&best, middle), None) {
                Some(true) => kept = middle,
                Some(false) => failed = middle,
                None => break,
            }
        }
        Some(kept)
    }
}
