//! The Pareto frontier of cost against error.

/// Indices of the points that no other point beats: none has less error at no more cost, or less cost at no more error.
///
/// Points are `(error, cost)`, both better when smaller; an error of 0 is the best there is and is kept like any other. Of
/// equal points the first is kept. Points that are not finite are left out. The result ascends in error and descends in cost.
pub fn frontier(points: &[(f64, f64)]) -> Vec<usize> {
    let finite = |&i: &usize| points[i].0.is_finite() && points[i].1.is_finite();
    let mut order: Vec<usize> = (0..points.len()).filter(finite).collect();
    order.sort_by(|&a, &b| points[a].partial_cmp(&points[b]).expect("finite points compare"));
    let mut kept: Vec<usize> = Vec::new();
    for i in order {
        if kept.last().is_none_or(|&last| points[i].1 < points[last].1) {
            kept.push(i);
        }
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::frontier;
    use proptest::prelude::*;

    /// `a` is at least as good in both and better in one.
    fn beats(a: (f64, f64), b: (f64, f64)) -> bool {
        a.0 <= b.0 && a.1 <= b.1 && a != b
    }

    proptest! {
        // A coarse grid, so that ties and duplicates are common; 0 is a perfect point.
        #[test]
        fn nothing_kept_is_beaten_and_everything_dropped_is(grid in prop::collection::vec((0u8..8, 0u8..8), 0..40)) {
            let points: Vec<(f64, f64)> = grid.iter().map(|&(e, c)| (f64::from(e), f64::from(c))).collect();
            let kept = frontier(&points);
            for i in 0..points.len() {
                let beaten = points.iter().any(|&other| beats(other, points[i]));
                let repeated = points[..i].contains(&points[i]);
                prop_assert_eq!(kept.contains(&i), !beaten && !repeated, "{:?} of {:?}", points[i], points);
            }
            prop_assert!(kept.windows(2).all(|w| points[w[0]].0 < points[w[1]].0 && points[w[0]].1 > points[w[1]].1));
        }
    }

    #[test]
    fn the_perfect_point_stays_and_what_is_not_finite_goes() {
        let points = [(0.1, 1.0), (0.0, 9.0), (f64::NAN, 0.0), (0.2, f64::INFINITY), (0.05, 9.0)];
        assert_eq!(frontier(&points), [1, 0]);
    }
}
