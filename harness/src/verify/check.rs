//! Two figures that should be one, and how far apart they may be.

use super::decoder::Answer;
use crate::lights::LIGHTS;
use crate::row::Row;
use prt_transfer::Label;

/// Codecs that keep every element, unless they are given a bound on the error.
const EXACT: [&str; 6] = ["dense", "csr", "compact", "runs", "visibility", "bicluster"];

/// What errors may differ by, as a share of the larger.
///
/// This program decodes and relights in f32, the decoder in f64. Where rounding has the square D relative to the matrix, a squared error E
/// becomes another by 2 √(E D) + D at most, which is at most `RELATIVE` · E + D / `RELATIVE`, and a little. Hence the floor: D is ε² where sums do not
/// cancel. Where they do, as for wide lobes, D is larger, but rounding has nothing to do with the error itself and averages out beside it.
const RELATIVE: f64 = 1e-3;
/// What squared errors may differ by however small they are.
const FLOOR: f64 = f32::EPSILON as f64 * f32::EPSILON as f64 / RELATIVE;
/// What the largest error may differ by, as a share of the largest element: a few roundings.
const FLOOR_MAX: f64 = 8.0 * f32::EPSILON as f64;

/// How far apart two figures may be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Rule {
    /// Both are 0: the method is exact.
    Zero,
    /// They are the same.
    Same,
    /// They differ by no more than so much, and the share of the larger.
    Near(f64),
}

/// A figure of results.csv (ours) and what the decoder has for it (theirs).
#[derive(Clone, Copy, Debug)]
pub(super) struct Check {
    /// The column of results.csv.
    pub(super) figure: &'static str,
    pub(super) ours: Option<f64>,
    pub(super) theirs: Option<f64>,
    pub(super) rule: Rule,
}

impl Check {
    /// How far apart they are; infinite where there is only one, or where one is no number.
    pub(super) fn deviation(&self) -> f64 {
        match (self.ours, self.theirs) {
            (None, None) => 0.0,
            (Some(ours), Some(theirs)) if ours == theirs => 0.0,
            (Some(ours), Some(theirs)) if ours.is_finite() && theirs.is_finite() => (ours - theirs).abs(),
            _ => f64::INFINITY,
        }
    }

    /// How far apart they may be.
    pub(super) fn tolerance(&self) -> f64 {
        let larger = [self.ours, self.theirs].into_iter().flatten().fold(0.0, |a: f64, b| a.max(b.abs()));
        match self.rule {
            Rule::Zero | Rule::Same => 0.0,
            Rule::Near(floor) => floor + RELATIVE * larger,
        }
    }

    /// Whether they agree.
    pub(super) fn is_ok(&self) -> bool {
        let zero = |figure: Option<f64>| figure.is_none_or(|f| f == 0.0);
        let rule = self.rule != Rule::Zero || (zero(self.ours) && zero(self.theirs));
        rule && self.deviation() <= self.tolerance()
    }
}

/// Every figure of a row that the decoder has too.
pub(super) fn of(row: &Row, label: &Label, answer: &Answer) -> Vec<Check> {
    let count = |n: u64| Some(n as f64);
    let mut checks = vec![
        Check {
            figure: "file_bytes",
            ours: row.file_bytes.and_then(count),
            theirs: count(answer.file_bytes),
            rule: Rule::Same,
        },
        Check {
            figure: "non_zeros",
            ours: count(row.non_zeros as u64),
            theirs: count(answer.non_zeros),
            rule: Rule::Same,
        },
    ];
    if let Some(resident) = answer.resident_bytes {
        let ours = row.resident_bytes.and_then(count);
        checks.push(Check { figure: "resident_bytes", ours, theirs: count(resident), rule: Rule::Same });
        let theirs = (answer.non_zeros > 0).then(|| resident as f64 / answer.non_zeros as f64);
        let ours = row.bytes_per_non_zero;
        checks.push(Check { figure: "bytes_per_non_zero", ours, theirs, rule: Rule::Same });
    }
    let near = |floor| if is_exact(label) { Rule::Zero } else { Rule::Near(floor) };
    let max = FLOOR_MAX * answer.matrix_max;
    checks.extend([
        Check { figure: "error", ours: row.error, theirs: Some(answer.error), rule: near(FLOOR) },
        Check { figure: "error_sphere", ours: row.error_sphere, theirs: answer.error_sphere, rule: near(FLOOR) },
        Check { figure: "error_max", ours: row.error_max, theirs: Some(answer.error_max), rule: near(max) },
    ]);
    if is_linear(label) {
        let figures = ["error_relit_sky", "error_relit_room"].into_iter().zip(LIGHTS).zip(row.relit_errors());
        // Relit in f32 by either method: exact ones have an error too.
        checks.extend(figures.map(|((figure, light), ours)| {
            let theirs = answer.relit.get(light).copied();
            Check { figure, ours, theirs, rule: Rule::Near(FLOOR) }
        }));
    }
    checks
}

/// Whether what is decoded is the matrix itself.
fn is_exact(label: &Label) -> bool {
    let bounded = label.codec.params.iter().any(|(name, _)| name == "max_error");
    label.transform.name == "identity" && EXACT.contains(&label.codec.name.as_str()) && !bounded
}

/// Whether relighting is the product of the decoded matrix with the light: not where a light loses coefficients.
fn is_linear(label: &Label) -> bool {
    !label.transform.params.iter().any(|(name, _)| name == "light_terms")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn label(method: &str) -> Label {
        method.parse().unwrap()
    }

    /// A row and what the decoder has for it, in agreement.
    fn agreeing(method: &str, error: f64) -> (Row, Answer) {
        let relit = [error, error / 2.0];
        let row = Row {
            method: method.into(),
            non_zeros: 1000,
            file_bytes: Some(500),
            resident_bytes: Some(3300),
            bytes_per_non_zero: Some(3.3),
            error: Some(error),
            error_sphere: Some(2.0 * error),
            error_max: Some(10.0 * error),
            error_relit_sky: Some(relit[0]),
            error_relit_room: Some(relit[1]),
            ..Row::default()
        };
        let answer = Answer {
            file_bytes: 500,
            resident_bytes: Some(3300),
            non_zeros: 1000,
            error,
            error_sphere: Some(2.0 * error),
            error_max: 10.0 * error,
            matrix_max: 1.0,
            relit: LIGHTS.map(String::from).into_iter().zip(relit).collect(),
            ..Answer::default()
        };
        (row, answer)
    }

    /// The figures that disagree.
    fn disagreeing(row: &Row, answer: &Answer) -> Vec<&'static str> {
        of(row, &label(&row.method), answer).iter().filter(|c| !c.is_ok()).map(|c| c.figure).collect()
    }

    #[test]
    fn equal_figures_agree_and_so_do_errors_apart_by_rounding() {
        for (method, error) in [("csr", 0.0), ("f16", 4e-8), ("haar+truncate:terms=9", 0.3), ("pca", 0.0)] {
            let (row, mut answer) = agreeing(method, error);
            assert_eq!(disagreeing(&row, &answer), [""; 0], "{method}");
            // A squared error of rounding alone, and a share of 1e-6.
            let apart = |figure: f64| figure * (1.0 + 1e-6) + 1e-13;
            if method != "csr" {
                answer.error = apart(answer.error);
                answer.error_sphere = answer.error_sphere.map(apart);
                answer.error_max = apart(answer.error_max);
            }
            answer.relit.values_mut().for_each(|figure| *figure = apart(*figure));
            assert_eq!(disagreeing(&row, &answer), [""; 0], "{method}");
        }
    }

    #[test]
    fn an_error_that_is_another_by_one_percent_disagrees_however_small() {
        for error in [4e-8, 1e-3, 0.5] {
            let (row, answer) = agreeing("truncate:terms=9", error);
            let near = |figure: f64| Some(1.01 * figure);
            for (figure, row) in [
                ("error", Row { error: near(error), ..row.clone() }),
                ("error_sphere", Row { error_sphere: near(2.0 * error), ..row.clone() }),
                ("error_relit_sky", Row { error_relit_sky: near(error), ..row.clone() }),
                ("error_relit_room", Row { error_relit_room: near(error / 2.0), ..row.clone() }),
            ] {
                assert_eq!(disagreeing(&row, &answer), [figure], "{error}");
            }
        }
        let (row, answer) = agreeing("truncate:terms=9", 1e-3);
        assert_eq!(disagreeing(&Row { error_max: Some(0.0101), ..row }, &answer), ["error_max"]);
    }

    #[test]
    fn an_exact_method_without_any_error_is_the_only_one_that_agrees() {
        let tiny = |error| agreeing("bicluster:levels=1", error);
        let (row, answer) = tiny(0.0);
        assert_eq!(disagreeing(&row, &answer), [""; 0]);
        // As large as what an inexact method may differ by, and the same on both sides.
        let (row, answer) = tiny(1e-20);
        assert_eq!(disagreeing(&row, &answer), ["error", "error_sphere", "error_max"]);
        for inexact in ["bicluster:max_error=0.01", "f16", "haar+csr"] {
            let (row, answer) = agreeing(inexact, 1e-20);
            assert_eq!(disagreeing(&row, &answer), [""; 0], "{inexact}");
        }
    }

    #[test]
    fn sizes_agree_to_the_byte_or_not_at_all_and_what_does_not_follow_is_not_compared() {
        let (row, answer) = agreeing("f16", 1e-8);
        let of = |change: &dyn Fn(&mut Answer)| {
            let mut answer = answer.clone();
            change(&mut answer);
            disagreeing(&row, &answer)
        };
        assert_eq!(of(&|a| a.file_bytes += 1), ["file_bytes"]);
        assert_eq!(of(&|a| a.resident_bytes = Some(3301)), ["resident_bytes", "bytes_per_non_zero"]);
        assert_eq!(of(&|a| a.non_zeros -= 1), ["non_zeros", "bytes_per_non_zero"]);
        assert_eq!(of(&|a| a.resident_bytes = None), [""; 0]);
    }

    #[test]
    fn a_figure_that_only_one_of_both_has_or_that_is_no_number_disagrees() {
        let (row, answer) = agreeing("pca", 0.1);
        let missing = Row { error_sphere: None, error_relit_room: Some(f64::NAN), ..row.clone() };
        assert_eq!(disagreeing(&missing, &answer), ["error_sphere", "error_relit_room"]);
        let silent = Answer { error_sphere: None, relit: Default::default(), ..answer.clone() };
        assert_eq!(disagreeing(&row, &silent), ["error_sphere", "error_relit_sky", "error_relit_room"]);
        // A light that loses coefficients is not relit by what is decoded.
        let row = Row { method: "haar:light_terms=9+csr".into(), ..row };
        assert_eq!(disagreeing(&row, &Answer { relit: Default::default(), ..answer }), [""; 0]);
    }
}
