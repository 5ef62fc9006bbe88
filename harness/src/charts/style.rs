//! Markers: a colour that colour-blind readers can tell apart, and a shape for those who print in grey.

/// Okabe and Ito's palette without its yellow, which is too light for a white page.
const COLOURS: [&str; 7] = ["#000000", "#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9"];

/// Corners on the unit circle, turns clockwise from the top; `None` is a circle.
const SHAPES: [Option<&[f64]>; 6] = [
    None,
    Some(&[0.125, 0.375, 0.625, 0.875]),
    Some(&[0.0, 1.0 / 3.0, 2.0 / 3.0]),
    Some(&[0.0, 0.25, 0.5, 0.75]),
    Some(&[0.5, 0.5 + 1.0 / 3.0, 0.5 + 2.0 / 3.0]),
    Some(&[0.0, 0.2, 0.4, 0.6, 0.8]),
];

/// How a family looks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Style {
    pub(super) colour: &'static str,
    corners: Option<&'static [f64]>,
}

impl Style {
    /// The style of the family at this place of the order; 42 families pass before one returns.
    pub(super) fn of(index: usize) -> Style {
        Style { colour: COLOURS[index % COLOURS.len()], corners: SHAPES[index % SHAPES.len()] }
    }

    /// The outline around a centre as SVG path data; `None` is a circle.
    pub(super) fn outline(&self, x: f64, y: f64, radius: f64) -> Option<String> {
        let corners = self.corners?.iter().map(|turn| {
            let (sin, cos) = (turn * std::f64::consts::TAU).sin_cos();
            // A polygon inside a circle looks smaller than the circle.
            format!("{:.2} {:.2}", x + 1.2 * radius * sin, y - 1.2 * radius * cos)
        });
        Some(format!("M {} Z", corners.collect::<Vec<_>>().join(" L ")))
    }
}

#[cfg(test)]
mod tests {
    use super::Style;

    #[test]
    fn forty_two_families_look_different() {
        let styles: Vec<Style> = (0..42).map(Style::of).collect();
        assert!(styles.iter().enumerate().all(|(i, style)| !styles[..i].contains(style)));
    }
}
