//! A cluster in two.

use crate::refit::fit;
use crate::residual::explicit;
use crate::subspaces::Subspace;
use prt_transfer::Result;
use prt_transfer::samples::Samples;

/// Rounds of two-way LBG within the cluster.
const ROUNDS: usize = 3;

/// Two subspaces for the members of one.
pub(crate) struct Halves {
    pub(crate) subspaces: [Subspace; 2],
    /// Squared error of the members, each in the nearer.
    pub(crate) error: f64,
}

/// Cuts a cluster's members across its first component, or towards the farthest of them where it has none, and fits a subspace of so
/// many components to either half. `None` where there are not two that differ.
pub(crate) fn halves(samples: &Samples, whole: &Subspace, group: &[u32], components: usize) -> Result<Option<Halves>> {
    let row = |sample: u32| samples.row(sample as usize);
    let axis: Vec<f32> = match whole.components.get(..samples.dimension()) {
        Some(first) => first.to_vec(),
        None => match farthest(samples, group, &whole.mean) {
            Some(sample) => row(sample).iter().zip(&whole.mean).map(|(x, m)| x - m).collect(),
            None => return Ok(None),
        },
    };
    let along = |x: &[f32]| {
        x.iter().zip(&whole.mean).zip(&axis).map(|((x, m), a)| f64::from(x - m) * f64::from(*a)).sum::<f64>()
    };
    let mut right: Vec<bool> = group.iter().map(|&sample| along(row(sample)) > 0.0).collect();
    let mut best: Option<Halves> = None;
    for _ in 0..ROUNDS {
        let half =
            |which: bool| group.iter().zip(&right).filter(|(_, r)| **r == which).map(|(g, _)| *g).collect::<Vec<u32>>();
        let (left_half, right_half) = (half(false), half(true));
        if left_half.is_empty() || right_half.is_empty() {
            break;
        }
        let fitted = |half: &[u32]| fit(samples, half, components, &whole.components);
        let subspaces = [fitted(&left_half)?, fitted(&right_half)?];
        let mut error = 0.0;
        for (right, &sample) in right.iter_mut().zip(group) {
            let [a, b] = [&subspaces[0], &subspaces[1]].map(|half| explicit(row(sample), &half.mean, &half.components));
            *right = b < a;
            error += a.min(b);
        }
        if best.as_ref().is_none_or(|best| error < best.error) {
            best = Some(Halves { subspaces, error });
        }
    }
    Ok(best)
}

/// The first of those farthest from the mean; `None` where all lie in it.
fn farthest(samples: &Samples, group: &[u32], mean: &[f32]) -> Option<u32> {
    let mut far = (0.0, None);
    for &sample in group {
        let distance = explicit(samples.row(sample as usize), mean, &[]);
        if distance > far.0 {
            far = (distance, Some(sample));
        }
    }
    far.1
}
