//! What all charts are drawn with: texts, lines, markers, an upright axis.

use super::axis::LogAxis;
use super::place::Box2;
use super::style::Style;
use crate::machine::Machine;
use kuva::render::color::Color;
use kuva::render::render::{PathData, Primitive, Scene, TextAnchor};

pub(super) const INK: &str = "#222222";
pub(super) const FAINT: &str = "#6b6b6b";
pub(super) const GRID: &str = "#e6e6e6";
pub(super) const MARKER: f64 = 5.0;
pub(super) const SMALL: u32 = 11;

/// An empty page, pixels.
pub(super) fn page(width: f64, height: f64) -> Scene {
    let mut scene = Scene::new(width, height);
    scene.font_family = Some("'DejaVu Sans', Verdana, sans-serif".into());
    scene
}

/// Where it was measured, at the bottom of the page.
pub(super) fn machine_line(scene: &mut Scene, left: f64, machine: Option<&Machine>) {
    if let Some(machine) = machine {
        let bottom = scene.height - 14.0;
        text(scene, (left, bottom), 10, FAINT, TextAnchor::Start, &machine.line());
    }
}

/// The left edge of `frame` as an axis, with lines across the frame at labelled marks.
pub(super) fn upright(scene: &mut Scene, axis: &LogAxis, frame: &Box2) {
    for tick in axis.ticks() {
        let labelled = tick.label.is_some();
        if labelled {
            line(scene, (frame.left, tick.pixel), (frame.right, tick.pixel), GRID, 1.0, None);
        }
        let length = if labelled { 6.0 } else { 3.0 };
        line(scene, (frame.left - length, tick.pixel), (frame.left, tick.pixel), INK, 1.0, None);
        if let Some(label) = tick.label {
            text(scene, (frame.left - 10.0, tick.pixel + 4.0), 12, INK, TextAnchor::End, &label);
        }
    }
    line(scene, (frame.left, frame.top), (frame.left, frame.bottom), INK, 1.0, None);
}

/// The bottom edge of `frame` as an axis, with lines across the frame at labelled marks.
pub(super) fn level(scene: &mut Scene, axis: &LogAxis, frame: &Box2) {
    for tick in axis.ticks() {
        let labelled = tick.label.is_some();
        if labelled {
            line(scene, (tick.pixel, frame.top), (tick.pixel, frame.bottom), GRID, 1.0, None);
        }
        let length = if labelled { 6.0 } else { 3.0 };
        line(scene, (tick.pixel, frame.bottom), (tick.pixel, frame.bottom + length), INK, 1.0, None);
        if let Some(label) = tick.label {
            text(scene, (tick.pixel, frame.bottom + 20.0), 12, INK, TextAnchor::Middle, &label);
        }
    }
    line(scene, (frame.left, frame.bottom), (frame.right, frame.bottom), INK, 1.0, None);
}

pub(super) fn poly_line(scene: &mut Scene, points: Vec<(f64, f64)>, colour: &str, width: f64) {
    scene.add(Primitive::PolyLine { points, stroke: colour.into(), stroke_width: width, stroke_dasharray: None });
}

pub(super) fn marker(scene: &mut Scene, style: Style, x: f64, y: f64) {
    marker_of(scene, style, (x, y), MARKER);
}

/// A marker of that radius.
pub(super) fn marker_of(scene: &mut Scene, style: Style, (x, y): (f64, f64), radius: f64) {
    let (fill, edge) = (Color::from(style.colour), Color::from("#ffffff"));
    scene.add(match style.outline(x, y, radius) {
        Some(d) => Primitive::Path(Box::new(PathData {
            d,
            fill: Some(fill),
            stroke: edge,
            stroke_width: 1.0,
            opacity: None,
            stroke_dasharray: None,
        })),
        None => Primitive::Circle {
            cx: x,
            cy: y,
            r: radius,
            fill,
            fill_opacity: None,
            stroke: Some(edge),
            stroke_width: Some(1.0),
        },
    });
}

pub(super) fn line(
    scene: &mut Scene,
    from: (f64, f64),
    to: (f64, f64),
    colour: &str,
    width: f64,
    dashes: Option<&str>,
) {
    scene.add(Primitive::Line {
        x1: from.0,
        y1: from.1,
        x2: to.0,
        y2: to.1,
        stroke: colour.into(),
        stroke_width: width,
        stroke_dasharray: dashes.map(String::from),
    });
}

pub(super) fn rectangle(scene: &mut Scene, x: f64, y: f64, width: f64, height: f64, fill: &str) {
    let (stroke, stroke_width, opacity) = (None, None, None);
    scene.add(Primitive::Rect { x, y, width, height, fill: fill.into(), stroke, stroke_width, opacity });
}

pub(super) fn text(scene: &mut Scene, at: (f64, f64), size: u32, colour: &str, anchor: TextAnchor, content: &str) {
    scene.add(Primitive::Text {
        x: at.0,
        y: at.1,
        content: content.into(),
        size,
        anchor,
        rotate: None,
        bold: false,
        color: Some(colour.into()),
    });
}
