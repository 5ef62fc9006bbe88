//! Successive halving over configurations: everything but the first axis.
//!
//! Jamieson and Talwalkar, *Non-stochastic Best Arm Identification and Hyperparameter Optimization* (2016): every rung gives some more effort to
//! the configurations that are left and drops the half that promises less. The effort is an encode; what a configuration promises is told from
//! all encodes so far, since figures of neighbours are alike.

use super::grid::Point;
use super::hunt::Hunt;
use super::models::Promise;

/// Configurations that get an encode in each rung.
const ENCODES: usize = 3;
/// An encode that is expected to better the best by less than this part is not worth it.
const LEAST_GAIN: f64 = 4e-3;

impl Hunt<'_, '_> {
    /// Finds the configurations that promise most, and tries them where they promise it; the last look is at every point of the grid.
    pub(super) fn halve(&mut self, start: &[usize]) {
        let size = self.log.best_point().map_or(start[0], |best| best[0]);
        for change in self.log.grid.changes(start) {
            let point = self.crossing(&[&[size], &change[1..]].concat());
            self.attempt(&point);
        }
        if self.log.best_point().is_none() {
            // Where it is not kept by the largest model of all, it is hardly kept by any.
            let largest = self.log.grid.largest();
            self.attempt(&self.crossing(&largest));
        }
        let mut alive = self.log.grid.configurations();
        while alive.len() > 1 && self.left > 0 {
            alive = self.better_half(alive);
            for configuration in alive.iter().take(ENCODES) {
                if let Some(point) = self.most_promising(std::slice::from_ref(configuration)) {
                    self.attempt(&point);
                }
            }
        }
        let all = self.log.grid.configurations();
        while self.left > 0
            && let Some(point) = self.most_promising(&all)
        {
            self.attempt(&point);
        }
    }

    /// Half of the configurations, those that promise most.
    fn better_half(&self, alive: Vec<Point>) -> Vec<Point> {
        let half = alive.len().div_ceil(2);
        let Some(models) = self.models() else { return alive.into_iter().take(half).collect() };
        let gain = |configuration: &Point| {
            let possible = self.sizes_of(configuration).filter(|point| !self.log.is_ruled_out(point));
            possible.map(|point| models.promise(&self.log.grid.places(&point)).gain).fold(0.0, f64::max)
        };
        let mut ranked: Vec<(f64, Point)> = alive.into_iter().map(|point| (gain(&point), point)).collect();
        ranked.sort_by(|a, b| b.0.total_cmp(&a.0));
        ranked.into_iter().take(half).map(|(_, point)| point).collect()
    }

    /// The point that was not tried and promises most, where that is enough.
    fn most_promising(&self, configurations: &[Point]) -> Option<Point> {
        let models = self.models()?;
        let mut best: Option<(Promise, Point)> = None;
        for point in configurations.iter().flat_map(|configuration| self.sizes_of(configuration)) {
            if self.log.known(&point).is_some() || self.log.is_ruled_out(&point) {
                continue;
            }
            let promise = models.promise(&self.log.grid.places(&point));
            if promise.gain > best.as_ref().map_or(LEAST_GAIN, |(best, _)| best.gain) {
                best = Some((promise, point));
            }
        }
        best.map(|(_, point)| point)
    }

    /// The first size of a configuration, as models come to keep the bound, that is expected to keep it; or the one nearest to it.
    fn crossing(&self, point: &[usize]) -> Point {
        let Some(models) = self.models() else { return point.to_vec() };
        let excess = |point: &Point| models.promise(&self.log.grid.places(point)).excess;
        let mut sizes: Vec<Point> = self.sizes_of(point).collect();
        if !self.log.goal.is_kept_by_large_models() {
            sizes.reverse();
        }
        let kept = sizes.iter().position(|point| excess(point) <= 0.0);
        kept.and_then(|at| sizes.get(at).cloned()).or_else(|| sizes.pop()).unwrap_or_else(|| point.to_vec())
    }

    fn sizes_of(&self, configuration: &[usize]) -> impl Iterator<Item = Point> {
        let rest = configuration[1..].to_vec();
        (0..self.log.grid.sizes()).map(move |size| [&[size], &rest[..]].concat())
    }
}
