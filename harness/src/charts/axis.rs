//! A logarithmic axis.

/// Maps positive values to pixels, decade by decade.
#[derive(Clone, Copy, Debug)]
pub(super) struct LogAxis {
    /// log10 of the values at both ends.
    low: f64,
    high: f64,
    /// Their pixels.
    from: f64,
    to: f64,
}

/// A mark on an axis.
pub(super) struct Tick {
    pub(super) pixel: f64,
    /// None for a mark between the labelled ones.
    pub(super) label: Option<String>,
}

/// Air between the outermost values and the ends, in decades …
const MARGIN: f64 = 0.15;
/// … and as a part of their distance, so that a marker on a long axis has room too.
const SHARE: f64 = 0.025;
/// An axis is at least this long, in decades: a chart of near equals must not look like a landslide.
const LEAST: f64 = 1.0;
/// Up to so many decades there is room for labels at 2 and 5.
const CROWDED: f64 = 2.5;

impl LogAxis {
    /// From pixel `from` to pixel `to`, wide enough for `values`, all of them positive.
    pub(super) fn new(values: impl Iterator<Item = f64>, from: f64, to: f64) -> LogAxis {
        let (low, high) = values.map(f64::log10).fold((f64::MAX, f64::MIN), |(l, h), v| (l.min(v), h.max(v)));
        let (low, high) = if low > high { (0.0, 0.0) } else { (low, high) };
        let span = high - low;
        let air = MARGIN.max(SHARE * span).max((LEAST - span) / 2.0);
        LogAxis { low: low - air, high: high + air, from, to }
    }

    /// Where a value lies.
    pub(super) fn pixel(&self, value: f64) -> f64 {
        self.from + (value.log10() - self.low) / (self.high - self.low) * (self.to - self.from)
    }

    /// Marks at 1 to 9 of every decade; those at 1 have labels, at 2 and 5 too where there is room.
    pub(super) fn ticks(&self) -> Vec<Tick> {
        let span = self.high - self.low;
        // Every second or third decade only, where they would run into each other.
        let stride = (span / 10.0).ceil().max(1.0) as i32;
        // One notation on one axis.
        let plain = self.low >= -3.0 && self.high < 5.0;
        let decades = self.low.floor() as i32..=self.high.floor() as i32;
        let marks = decades.flat_map(|decade| (1..10).map(move |digit| (decade, digit)));
        let inside = marks.filter(|&(decade, digit)| {
            let place = f64::from(decade) + f64::from(digit).log10();
            (self.low..=self.high).contains(&place) && (digit == 1 || span <= 6.0)
        });
        inside
            .map(|(decade, digit)| {
                let labelled = match digit {
                    1 => decade.rem_euclid(stride) == 0,
                    2 | 5 => span <= CROWDED,
                    _ => false,
                };
                let value = f64::from(digit) * 10f64.powi(decade);
                Tick { pixel: self.pixel(value), label: labelled.then(|| label(decade, digit, plain)) }
            })
            .collect()
    }
}

/// `0.02` or `500` where numbers are plain; else `10⁻⁵`, `2·10¹²`.
fn label(decade: i32, digit: i32, plain: bool) -> String {
    if decade == 0 {
        return digit.to_string();
    }
    if plain {
        return format!("{:.*}", (-decade).max(0) as usize, f64::from(digit) * 10f64.powi(decade));
    }
    let factor = if digit == 1 { String::new() } else { format!("{digit}·") };
    format!("{factor}10{}", decade.to_string().chars().map(superscript).collect::<String>())
}

fn superscript(c: char) -> char {
    const DIGITS: [char; 10] = ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'];
    c.to_digit(10).map_or('⁻', |d| DIGITS[d as usize])
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn every_value_lies_inside_in_its_order_and_some_mark_has_a_label(
            exponents in prop::collection::vec(-20.0..6.0f64, 1..20),
        ) {
            let values: Vec<f64> = exponents.iter().map(|e| 10f64.powf(*e)).collect();
            let axis = LogAxis::new(values.iter().copied(), 100.0, 700.0);
            for (a, b) in values.iter().zip(values.iter().skip(1)) {
                let (p, q) = (axis.pixel(*a), axis.pixel(*b));
                prop_assert!((100.0..=700.0).contains(&p) && (a < b) == (p < q || a == b && p == q), "{a} {b} {p} {q}");
            }
            let ticks = axis.ticks();
            prop_assert!(ticks.iter().any(|t| t.label.is_some()));
            prop_assert!(ticks.iter().all(|t| (99.0..=701.0).contains(&t.pixel)));
        }
    }

    #[test]
    fn an_axis_has_one_notation() {
        for (decade, digit, text) in [(-3, 2, "0.002"), (0, 5, "5"), (4, 1, "10000")] {
            assert_eq!(label(decade, digit, true), text);
        }
        for (decade, digit, text) in [(-5, 1, "10⁻⁵"), (0, 1, "1"), (12, 2, "2·10¹²")] {
            assert_eq!(label(decade, digit, false), text);
        }
    }
}
