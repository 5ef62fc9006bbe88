//! The best models within a bound, beside what a grid finds.

use super::data::{Selected, Selection};
use super::html::escape;
use crate::number::{bytes, short};

const NONE: &str = "–";

/// A table for each selection.
pub(super) fn tables(selections: &[Selection]) -> String {
    selections.iter().map(table).collect()
}

fn table(selection: &Selection) -> String {
    let largest = selection.rows.iter().map(|row| row.bytes).max().unwrap_or(0);
    let rows: String = selection.rows.iter().map(|row| line(row, largest)).collect();
    let heads = [
        "family",
        "model",
        "bytes",
        "error",
        "1 thr, ms",
        "encodes",
        "model of the grid",
        "bytes",
        "error",
        "gap",
        "encodes",
    ];
    let heads: String = heads.iter().map(|head| format!("<th scope=\"col\">{head}</th>")).collect();
    format!(
        "<div class=\"scroll\"><table class=\"selection\">\n<caption>{} · <span class=\"bound\">{}</span></caption>\n\
         <thead><tr>{heads}</tr></thead>\n<tbody>\n{rows}</tbody>\n</table></div>\n",
        escape(&selection.title),
        escape(&selection.bound)
    )
}

fn line(row: &Selected, largest: u64) -> String {
    let part = 100.0 * row.bytes as f64 / largest.max(1) as f64;
    let or_none = |text: Option<String>| text.unwrap_or_else(|| NONE.into());
    let cells = [
        or_none(row.relight_ms.map(short)),
        row.encodes.to_string(),
        or_none(row.grid_method.as_deref().map(escape)),
        or_none(row.grid_bytes.map(bytes)),
        or_none(row.grid_error.map(short)),
        or_none(row.gap_percent.map(gap)),
        or_none(row.grid_encodes.and_then(|grid| share(row.encodes, grid))),
    ];
    let cells: String = cells.iter().map(|cell| format!("<td>{cell}</td>")).collect();
    let (family, method, size, error) = (escape(&row.family), escape(&row.method), bytes(row.bytes), short(row.error));
    format!(
        "<tr><th scope=\"row\">{family}</th><td>{method}</td><td class=\"bar\" style=\"--part:{part:.1}%\">{size}</td>\
         <td>{error}</td>{cells}</tr>\n"
    )
}

/// How much more than the grid's the selected model takes.
fn gap(percent: f64) -> String {
    // Not -0.0.
    format!("{:+.1} %", if percent.abs() < 0.05 { 0.0 } else { percent }).replace('-', "−")
}

/// Encodes of the selection, as a part of the grid's.
fn share(encodes: u64, grid: u64) -> Option<String> {
    (grid > 0).then(|| format!("{:.0} % of {grid}", 100.0 * encodes as f64 / grid as f64))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_gap_is_what_the_grid_saves_and_the_share_what_it_costs() {
        assert_eq!([10.0, -5.0, -0.01].map(gap), ["+10.0 %", "−5.0 %", "+0.0 %"]);
        assert_eq!(share(12, 240).as_deref(), Some("5 % of 240"));
    }

    #[test]
    fn a_family_without_a_grid_has_no_gap() {
        let selected = Selected { family: "<cpca>".into(), method: "cpca".into(), bytes: 10, ..Selected::default() };
        let html =
            tables(&[Selection { title: "teapot".into(), bound: "error ≤ 1e-3".into(), rows: vec![selected] }]);
        assert!(html.contains("&lt;cpca&gt;") && html.contains("error ≤ 1e-3"));
        assert_eq!(html.matches("<td>–</td>").count(), 6, "{html}");
    }
}
