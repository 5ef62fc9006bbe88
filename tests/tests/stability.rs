//! Where methods fail: ours keep the bounds that the atlas states, and the papers' printed forms break where it says that they do.

use prt_harness::progress::Steps;
use prt_harness::stability::atlas::{Atlas, PARTS, chosen, measure};
use std::sync::LazyLock;

/// Measured once for all tests.
static ATLAS: LazyLock<Atlas> =
    LazyLock::new(|| chosen(&[]).and_then(|cases| measure(cases, &Steps::new(0))).expect("all cases"));

#[test]
fn what_is_done_here_keeps_its_bound_from_harmless_to_hopeless() {
    let beyond = ATLAS.violated().flat_map(|outcome| {
        let of = |point| format!("{}: {point:?}, bound {:e}", outcome.case.name, outcome.bound(point));
        outcome.violations().map(of).collect::<Vec<_>>()
    });
    let beyond: Vec<String> = beyond.collect();
    assert!(beyond.is_empty(), "{}", beyond.join("\n"));
}

#[test]
fn printed_forms_break_where_it_is_said_and_nowhere_before() {
    for (_, outcome) in ATLAS.outcomes() {
        let points: Vec<_> = outcome.points.iter().map(|point| (point.value, &point.printed)).collect();
        assert_eq!(outcome.breaks(), outcome.case.breaks, "{}: {points:?}", outcome.case.name);
    }
}

#[test]
fn cases_have_names_of_their_own_and_values_that_a_logarithm_can_show() {
    let names: Vec<&str> = PARTS.iter().flat_map(|part| part.cases.iter().map(|case| case.name)).collect();
    assert!(names.iter().enumerate().all(|(i, name)| !names[..i].contains(name)), "{names:?}");
    for case in PARTS.iter().flat_map(|part| part.cases) {
        assert!(case.values.len() >= 3 && case.values.iter().all(|value| *value > 0.0), "{}", case.name);
        let promised = case.values.iter().all(|value| (case.bound)(*value) >= 0.0 && (case.bound)(*value).is_finite());
        assert!(promised && !case.promise.is_empty(), "{}", case.name);
    }
}
