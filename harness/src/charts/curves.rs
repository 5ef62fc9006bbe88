//! Curves over planes with two logarithmic axes; panels have one scale upwards, unless they show different things.

use super::axis::LogAxis;
use super::grid::{self, Grid};
use super::pen::{self, FAINT, INK, SMALL, line, marker_of, poly_line, text};
use super::place::{self, Box2};
use super::style::Style;
use crate::machine::Machine;
use kuva::render::render::{Scene, TextAnchor};

/// A few panels can be high.
const HIGH: Grid = Grid { height: 320.0, lines: 1 };
const LOW: Grid = Grid { height: 210.0, lines: 1 };
const LINE: f64 = 1.8;
/// Curves have many points.
const MARKER: f64 = 3.6;
/// How close the boxes are that keep labels off a line.
const STRIDE: f64 = 5.0;
const DASHES: Option<&str> = Some("5,4");
/// Between the base lines of reference lines' names.
const NAME: f64 = 14.0;

/// One chart, ready to be drawn.
#[derive(Clone, Debug)]
pub struct Curves {
    /// What is compared.
    pub title: String,
    /// On what.
    pub subject: String,
    /// Names of the curves.
    pub names: Vec<String>,
    /// What the labels of points say, if there are any.
    pub remark: Option<String>,
    /// Whether each panel has a scale of its own upwards.
    pub apart: bool,
    /// One panel each.
    pub planes: Vec<Plane>,
}

/// One quantity across.
#[derive(Clone, Debug, Default)]
pub struct Plane {
    /// Quantity and unit upwards.
    pub upwards: String,
    /// Quantity and unit across.
    pub across: String,
    /// The points of each curve, in the order in which they are joined.
    pub curves: Vec<Vec<Dot>>,
    /// Reference lines: where they stand across, and their names.
    pub references: Vec<(f64, String)>,
}

/// A point of a curve. What is no positive number has no place on a logarithmic axis and leaves a gap.
#[derive(Clone, Debug)]
pub struct Dot {
    /// Across.
    pub x: f64,
    /// Upwards.
    pub y: f64,
    /// Written beside the marker, if anything.
    pub label: String,
}

impl Dot {
    fn is_drawable(&self) -> bool {
        [self.x, self.y].iter().all(|v| drawable(*v))
    }
}

fn drawable(value: f64) -> bool {
    value.is_finite() && value > 0.0
}

impl Curves {
    /// As SVG; with a line that says where it was measured.
    pub fn svg(&self, machine: Option<&Machine>) -> String {
        super::svg(&self.scene(machine))
    }

    /// As PNG of twice the SVG's size in pixels.
    pub fn png(&self, machine: &Machine) -> anyhow::Result<Vec<u8>> {
        super::png(&self.scene(Some(machine)))
    }

    fn scene(&self, machine: Option<&Machine>) -> Scene {
        let grid = if self.planes.len() <= 3 { HIGH } else { LOW };
        let mut scene = grid.page(&self.title, &self.subject, self.planes.len());
        grid::legend(&mut scene, &self.names, |_| LINE, self.remark.as_deref());
        for (i, plane) in self.planes.iter().enumerate() {
            let frame = grid.frame(i);
            // One scale upwards for all panels, so that they can be compared; unless nobody would.
            let shown = if self.apart { std::slice::from_ref(plane) } else { &self.planes[..] };
            let dots = shown.iter().flat_map(|plane| &plane.curves).flatten().filter(|dot| dot.is_drawable());
            let upwards = LogAxis::new(dots.map(|dot| dot.y), frame.bottom, frame.top);
            grid::heading(&mut scene, &frame, &[&plane.upwards]);
            plane.draw(&mut scene, &upwards, frame);
        }
        pen::machine_line(&mut scene, grid::LEFT, machine);
        scene
    }
}

impl Plane {
    fn draw(&self, scene: &mut Scene, upwards: &LogAxis, frame: Box2) {
        let dots = || self.curves.iter().flatten().filter(|dot| dot.is_drawable());
        let references = || self.references.iter().filter(|(x, _)| drawable(*x));
        let places = dots().map(|dot| dot.x).chain(references().map(|(x, _)| *x));
        let across = LogAxis::new(places, frame.left, frame.right);
        pen::upright(scene, upwards, &frame);
        pen::level(scene, &across, &frame);
        let middle = (frame.left + frame.right) / 2.0;
        text(scene, (middle, frame.bottom + 38.0), SMALL, FAINT, TextAnchor::Middle, &self.across);
        let mut obstacles = self.lines(scene, &across, &frame);
        let place = |dot: &Dot| (across.pixel(dot.x), upwards.pixel(dot.y));
        for (i, curve) in self.curves.iter().enumerate() {
            // A line for every stretch without a gap.
            for stretch in curve.split(|dot| !dot.is_drawable()).filter(|stretch| stretch.len() > 1) {
                let places: Vec<(f64, f64)> = stretch.iter().map(place).collect();
                obstacles.extend(places.windows(2).flat_map(|ends| along(ends[0], ends[1])));
                poly_line(scene, places, Style::of(i).colour, LINE);
            }
            let drawn = curve.iter().filter(|dot| dot.is_drawable());
            drawn.for_each(|dot| marker_of(scene, Style::of(i), place(dot), MARKER));
        }
        // All markers are in the way, those without a label too.
        obstacles.extend(dots().map(place).map(|(x, y)| Box2::around(x, y, MARKER + 1.0, MARKER + 1.0)));
        let labelled: Vec<&Dot> = dots().filter(|dot| !dot.label.is_empty()).collect();
        let places: Vec<(f64, f64)> = labelled.iter().map(|dot| place(dot)).collect();
        let texts: Vec<&str> = labelled.iter().map(|dot| dot.label.as_str()).collect();
        let labels = place::labels(&places, &texts, SMALL.into(), frame, &obstacles);
        for (at, label) in labels.into_iter().zip(texts) {
            text(scene, at, SMALL, INK, TextAnchor::Start, label);
        }
    }

    /// Draws the reference lines with their names at the top, and says what they cover.
    fn lines(&self, scene: &mut Scene, across: &LogAxis, frame: &Box2) -> Vec<Box2> {
        let mut covered = Vec::new();
        for (i, (x, name)) in self.references.iter().filter(|(x, _)| drawable(*x)).enumerate() {
            let (x, base) = (across.pixel(*x), frame.top + 10.0 + NAME * i as f64);
            let width = place::width(name, SMALL.into());
            let fits = x + 6.0 + width <= frame.right;
            let (anchor, at) = if fits { (TextAnchor::Start, x + 6.0) } else { (TextAnchor::End, x - 6.0) };
            line(scene, (x, frame.top), (x, frame.bottom), INK, 1.0, DASHES);
            text(scene, (at, base), SMALL, INK, anchor, name);
            let left = if fits { at } else { at - width };
            covered.push(Box2 { left, top: base - 10.0, right: left + width, bottom: base + 2.0 });
            covered.push(Box2 { left: x - 1.0, top: frame.top, right: x + 1.0, bottom: frame.bottom });
        }
        covered
    }
}

/// Boxes along a line, which together cover little more than it does.
fn along(from: (f64, f64), to: (f64, f64)) -> impl Iterator<Item = Box2> {
    let (dx, dy) = (to.0 - from.0, to.1 - from.1);
    let steps = (dx.hypot(dy) / STRIDE).ceil().max(1.0);
    (0..=steps as usize).map(move |i| {
        let share = i as f64 / steps;
        Box2::around(from.0 + share * dx, from.1 + share * dy, 2.0, 2.0)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn dot(x: f64, y: f64) -> Dot {
        Dot { x, y, label: String::new() }
    }

    fn chart(curves: Vec<Vec<Dot>>, references: Vec<(f64, String)>) -> Curves {
        let names = (0..curves.len()).map(|i| format!("n' = {i}")).collect();
        let planes = ["bytes", "relight, ms"].map(|across| Plane {
            upwards: "error".into(),
            across: across.into(),
            curves: curves.clone(),
            references: references.clone(),
        });
        let (title, subject) = ("t".into(), "s".into());
        Curves { title, subject, remark: None, names, apart: false, planes: planes.into() }
    }

    #[test]
    fn every_point_has_its_marker_every_curve_its_legend_and_a_gap_breaks_the_line() {
        let mut curves = vec![
            vec![dot(1.0, 1e-2), dot(10.0, 1e-3), dot(100.0, 1e-4)],
            vec![dot(2.0, 1e-1), dot(4.0, 1e-2), dot(8.0, 0.0), dot(16.0, 1e-5), dot(f64::NAN, 1e-5)],
        ];
        curves[0][1].label = "256".into();
        let chart = chart(curves, vec![(50.0, "dense, exact".into()), (0.0, "nowhere".into())]);
        let svg = chart.svg(Some(&Machine::here(2)));
        let count = |what: &str| svg.matches(what).count();
        // Circles are the first curve's, squares the second's; one more of each in the legend. A lone point has no line.
        let lines = count("fill=\"none\"");
        assert_eq!((count("<circle"), count("<path") - lines), (2 * 3 + 1, 2 * 3 + 1), "{svg}");
        assert_eq!((lines, count("stroke-dasharray")), (2 * 2, 2), "{svg}");
        let told = svg.replace("&apos;", "'").replace("&#39;", "'");
        for text in ["bytes", "relight, ms", "error", "n' = 0", "n' = 1", "256", "dense, exact"] {
            assert!(told.contains(&format!(">{text}</text>")), "{text}: {told}");
        }
        assert!(!svg.contains("nowhere"), "{svg}");
    }

    #[test]
    fn all_panels_have_one_scale_upwards_unless_they_stand_apart() {
        let mut chart = chart(vec![vec![dot(1.0, 1e-2), dot(10.0, 1e-3)]], Vec::new());
        chart.planes[1].curves[0].push(dot(5.0, 1e-6));
        for apart in [false, true] {
            let svg = Curves { apart, ..chart.clone() }.svg(None);
            let heights: Vec<&str> =
                svg.split("<circle").skip(2).filter_map(|c| c.split("cy=\"").nth(1)?.split('"').next()).collect();
            assert_eq!(heights[..2] != heights[2..4], apart, "{svg}");
        }
    }

    #[test]
    fn charts_of_one_point_of_references_only_or_of_nothing_are_drawn_too() {
        for (curves, references) in [
            (vec![vec![dot(1.0, 1.0)]], Vec::new()),
            (vec![vec![dot(0.0, 0.0)], Vec::new()], vec![(3.0, "dense".to_string())]),
            (Vec::new(), Vec::new()),
        ] {
            let svg = chart(curves, references).svg(None);
            assert!(svg.starts_with("<svg") && !svg.contains("NaN") && !svg.contains("inf"), "{svg}");
        }
    }
}
