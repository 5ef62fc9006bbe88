//! Figures over a parameter: a panel for each figure, a line for each method.

use super::axis::LogAxis;
use super::grid::{self, Grid};
use super::pen::{self, FAINT, GRID, INK, SMALL, line, marker, poly_line, text};
use super::place::{self, Box2};
use super::style::Style;
use crate::machine::Machine;
use kuva::render::render::{Scene, TextAnchor};

/// Between the first and the last mark and the ends of the frame.
const AIR: f64 = 16.0;
/// Of frames.
const HEIGHT: f64 = 210.0;
/// Where a method failed.
const CROSS: &str = "×";
/// Between the labels of two marks.
const GAP: f64 = 8.0;

/// One chart, ready to be drawn.
#[derive(Clone, Debug)]
pub struct Panels {
    /// What the parameter does.
    pub title: String,
    /// To what.
    pub subject: String,
    /// One line each.
    pub methods: Vec<String>,
    /// One panel each.
    pub panels: Vec<Panel>,
}

/// A figure of every method at every mark.
#[derive(Clone, Debug)]
pub struct Panel {
    /// Over it: quantity and unit, or a title and more below it.
    pub heading: Vec<String>,
    /// Name of the parameter.
    pub parameter: String,
    /// Its values in order, at equal distances.
    pub marks: Vec<String>,
    /// By method, then by mark. What failed is `None` and is drawn as a cross; what is no positive number has no place on a
    /// logarithmic axis and leaves a gap.
    pub values: Vec<Vec<Option<f64>>>,
}

impl Panels {
    /// As SVG; with a line that says where it was measured.
    pub fn svg(&self, machine: Option<&Machine>) -> String {
        super::svg(&self.scene(machine))
    }

    /// As PNG of twice the SVG's size in pixels.
    pub fn png(&self, machine: &Machine) -> anyhow::Result<Vec<u8>> {
        super::png(&self.scene(Some(machine)))
    }

    fn scene(&self, machine: Option<&Machine>) -> Scene {
        let headings: Vec<Vec<String>> = self.panels.iter().map(|panel| grid::lines(&panel.heading)).collect();
        let lines = headings.iter().map(Vec::len).max().unwrap_or(1);
        let layout = Grid { height: HEIGHT, lines };
        let mut scene = layout.page(&self.title, &self.subject, self.panels.len());
        let failed = self.panels.iter().flat_map(|panel| &panel.values).any(|values| values.contains(&None));
        let remark = failed.then(|| format!("{CROSS} failed"));
        grid::legend(&mut scene, &self.methods, |method| self.width(method), remark.as_deref());
        for (i, panel) in self.panels.iter().enumerate() {
            grid::heading(&mut scene, &layout.frame(i), &headings[i].iter().map(String::as_str).collect::<Vec<_>>());
            self.panel(&mut scene, panel, layout.frame(i));
        }
        pen::machine_line(&mut scene, grid::LEFT, machine);
        scene
    }

    /// The first lines are the widest, so that one that is covered by another is seen on both sides of it.
    fn width(&self, method: usize) -> f64 {
        1.8 + 1.6 * (self.methods.len() - 1 - method).min(5) as f64
    }

    fn panel(&self, scene: &mut Scene, panel: &Panel, frame: Box2) {
        let values = || panel.values.iter().flatten().flatten().copied().filter(|v| drawable(*v));
        let axis = LogAxis::new(values(), frame.bottom, frame.top);
        panel.ground(scene, &frame);
        pen::upright(scene, &axis, &frame);
        for (method, values) in panel.values.iter().enumerate() {
            let style = Style::of(method);
            let places = values.iter().enumerate().map(|(mark, value)| {
                let drawn = value.filter(|v| drawable(*v));
                drawn.map(|value| (panel.place(mark, &frame), axis.pixel(value)))
            });
            let places: Vec<Option<(f64, f64)>> = places.collect();
            // A line for every stretch without a gap.
            for stretch in places.split(Option::is_none).filter(|stretch| stretch.len() > 1) {
                poly_line(scene, stretch.iter().copied().flatten().collect(), style.colour, self.width(method));
            }
            places.iter().flatten().for_each(|&(x, y)| marker(scene, style, x, y));
        }
        self.failures(scene, panel, &frame);
    }

    /// A row of crosses at the top, less being better, for each method that failed anywhere.
    fn failures(&self, scene: &mut Scene, panel: &Panel, frame: &Box2) {
        let failed = panel.values.iter().enumerate().filter(|(_, values)| values.contains(&None));
        for (row, (method, values)) in failed.enumerate() {
            for mark in (0..values.len()).filter(|&mark| values[mark].is_none()) {
                let at = (panel.place(mark, frame), frame.top + 12.0 + 10.0 * row as f64);
                text(scene, at, 14, Style::of(method).colour, TextAnchor::Middle, CROSS);
            }
        }
    }
}

impl Panel {
    /// The marks of the parameter, labels where there is room: at both ends, where a method fails, first.
    fn ground(&self, scene: &mut Scene, frame: &Box2) {
        line(scene, (frame.left, frame.bottom), (frame.right, frame.bottom), INK, 1.0, None);
        let last = self.marks.len().saturating_sub(1);
        let mut order: Vec<usize> = (0..self.marks.len()).collect();
        order.sort_by_key(|&i| i != 0 && i != last);
        let mut taken: Vec<(f64, f64)> = Vec::new();
        for (i, mark) in order.into_iter().map(|i| (i, &self.marks[i])) {
            let (x, reach) = (self.place(i, frame), place::width(mark, SMALL.into()) / 2.0);
            let labelled = taken.iter().all(|(other, theirs)| (x - other).abs() >= reach + theirs + GAP);
            let length = if labelled { 6.0 } else { 3.0 };
            line(scene, (x, frame.bottom), (x, frame.bottom + length), INK, 1.0, None);
            if labelled {
                taken.push((x, reach));
                line(scene, (x, frame.top), (x, frame.bottom), GRID, 1.0, None);
                text(scene, (x, frame.bottom + 19.0), SMALL, INK, TextAnchor::Middle, mark);
            }
        }
        let middle = (frame.left + frame.right) / 2.0;
        text(scene, (middle, frame.bottom + 38.0), SMALL, FAINT, TextAnchor::Middle, &self.parameter);
    }

    /// Where a mark lies across.
    fn place(&self, mark: usize, frame: &Box2) -> f64 {
        let steps = self.marks.len().saturating_sub(1).max(1) as f64;
        frame.left + AIR + (frame.right - frame.left - 2.0 * AIR) * mark as f64 / steps
    }
}

fn drawable(value: f64) -> bool {
    value.is_finite() && value > 0.0
}

#[cfg(test)]
mod tests {
    use super::*;

    fn panels(values: Vec<Vec<Option<f64>>>) -> Panels {
        let marks: Vec<String> = (0..values.first().map_or(0, Vec::len)).map(|i| (1 << i).to_string()).collect();
        let methods = (0..values.len()).map(|i| format!("method{i}")).collect();
        let panel = |title: &str| Panel {
            heading: vec![title.into()],
            parameter: "levels".into(),
            marks: Vec::clone(&marks),
            values: values.clone(),
        };
        let panels = ["one, s", "two, B"].map(panel).into();
        Panels { title: "t".into(), subject: "s".into(), methods, panels }
    }

    #[test]
    fn every_value_has_its_marker_a_gap_breaks_the_line_and_a_failure_is_a_cross() {
        let chart = panels(vec![
            vec![Some(1.0), Some(2.0), Some(3.0), Some(4.0), Some(5.0)],
            vec![Some(1.0), Some(2.0), None, Some(0.0), Some(5.0)],
        ]);
        let svg = chart.svg(Some(&Machine::here(2)));
        let count = |what: &str| svg.matches(what).count();
        // Circles are the first method's, squares the second's; one more of each in the legend.
        let lines = count("fill=\"none\"");
        assert_eq!((count("<circle"), count("<path") - lines), (2 * 5 + 1, 2 * 3 + 1), "{svg}");
        assert_eq!((lines, count(">×</text>")), (2 * 2, 2), "{svg}");
        for text in ["one, s", "two, B", "levels", "16", "method1", "× failed"] {
            assert!(svg.contains(&format!(">{text}</text>")), "{text} is missing");
        }
    }

    #[test]
    fn charts_of_one_mark_of_failures_only_or_of_nothing_are_drawn_too() {
        for values in [vec![vec![Some(1.0)]], vec![vec![None, None]], vec![vec![]], vec![]] {
            let svg = panels(values).svg(None);
            assert!(svg.starts_with("<svg") && !svg.contains("NaN") && !svg.contains("inf"), "{svg}");
        }
    }
}
