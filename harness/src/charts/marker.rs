//! A family's marker outside of a chart: in tables, legends and charts that a page draws itself.

use super::pen;
use super::style::Style;
use serde::Serialize;

/// Colour and outline around the origin, SVG path data of the size that charts have.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Marker {
    colour: &'static str,
    outline: String,
}

impl Marker {
    /// The marker of the family at this place of the order.
    pub fn of(index: usize) -> Marker {
        let (style, r) = (Style::of(index), pen::MARKER);
        let circle = || format!("M 0 {r} A {r} {r} 0 1 1 0 -{r} A {r} {r} 0 1 1 0 {r} Z");
        Marker { colour: style.colour, outline: style.outline(0.0, 0.0, r).unwrap_or_else(circle) }
    }

    /// A picture of it within a line of text.
    pub fn svg(&self) -> String {
        let Marker { colour, outline } = self;
        let path = format!("<path d=\"{outline}\" fill=\"{colour}\"/>");
        format!("<svg class=\"marker\" viewBox=\"-7 -7 14 14\" aria-hidden=\"true\">{path}</svg>")
    }
}
