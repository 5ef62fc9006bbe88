//! A page of panels beside each other under one title and one legend.

use super::pen::{self, FAINT, INK, line, marker, text};
use super::place::{self, Box2};
use super::style::Style;
use kuva::render::render::{Scene, TextAnchor};

/// Panels beside each other.
const COLUMNS: usize = 3;
pub(super) const LEFT: f64 = 64.0;
const TOP: f64 = 116.0;
/// From one panel to the next one in its row, and the width of its frame.
const ACROSS: (f64, f64) = (376.0, 300.0);
/// Between the frames of two rows.
const BETWEEN: f64 = 86.0;
const WIDTH: f64 = LEFT + 3.0 * ACROSS.0 - 40.0;

/// Panels whose frames are so high, with so many lines over each.
#[derive(Clone, Copy)]
pub(super) struct Grid {
    pub(super) height: f64,
    pub(super) lines: usize,
}

/// From a line over a panel to the next one.
const LINE: f64 = 16.0;

impl Grid {
    /// An empty page for so many panels.
    pub(super) fn page(&self, title: &str, subject: &str, panels: usize) -> Scene {
        let rows = panels.div_ceil(COLUMNS).max(1) as f64;
        let mut scene = pen::page(WIDTH, TOP + rows * (self.height + self.between()) + 4.0);
        text(&mut scene, (LEFT, 32.0), 18, INK, TextAnchor::Start, title);
        text(&mut scene, (LEFT, 54.0), 12, FAINT, TextAnchor::Start, subject);
        scene
    }

    /// Where a panel is.
    pub(super) fn frame(&self, panel: usize) -> Box2 {
        let left = LEFT + ACROSS.0 * (panel % COLUMNS) as f64;
        let top = TOP + self.more() + (self.height + self.between()) * (panel / COLUMNS) as f64;
        Box2 { left, top, right: left + ACROSS.1, bottom: top + self.height }
    }

    fn between(&self) -> f64 {
        BETWEEN + self.more()
    }

    /// What lines beyond the first take.
    fn more(&self) -> f64 {
        LINE * self.lines.saturating_sub(1) as f64
    }
}

/// Texts in lines as wide as a panel and the space to the next one allow.
pub(super) fn lines(texts: &[String]) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for text in texts {
        let mut line = String::new();
        for word in text.split(' ') {
            let longer = if line.is_empty() { word.to_string() } else { format!("{line} {word}") };
            if !line.is_empty() && place::width(&longer, 12.0) > ACROSS.0 - 12.0 {
                lines.push(std::mem::replace(&mut line, word.to_string()));
            } else {
                line = longer;
            }
        }
        lines.push(line);
    }
    lines
}

/// What stands over a panel: a title, and what else there is below it.
pub(super) fn heading(scene: &mut Scene, frame: &Box2, lines: &[&str]) {
    for (i, line) in lines.iter().enumerate() {
        let base = frame.top - 12.0 - LINE * (lines.len() - 1 - i) as f64;
        text(scene, (frame.left - 8.0, base), 12, if i == 0 { INK } else { FAINT }, TextAnchor::Start, line);
    }
}

/// A line with its marker for each name, in the style of its place and as wide as `width` says; then a remark.
pub(super) fn legend(scene: &mut Scene, names: &[String], width: impl Fn(usize) -> f64, remark: Option<&str>) {
    let mut x = LEFT;
    for (i, name) in names.iter().enumerate() {
        line(scene, (x, 76.0), (x + 22.0, 76.0), Style::of(i).colour, width(i), None);
        marker(scene, Style::of(i), x + 11.0, 76.0);
        text(scene, (x + 28.0, 80.0), 12, INK, TextAnchor::Start, name);
        x += 28.0 + place::width(name, 12.0) + 24.0;
    }
    if let Some(remark) = remark {
        text(scene, (x, 80.0), 12, FAINT, TextAnchor::Start, remark);
    }
}
