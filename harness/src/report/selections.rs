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
    // Where no grid was tried there is nothing to stand in its columns.
    let beside = selection.rows.iter().any(|row| row.grid_encodes.is_some());
    let rows: String = selection.rows.iter().map(|row| line(row, largest, beside)).collect();
    let (ours, grid) =
        (["family", "model", "bytes", "error", "1 thr, ms", "encodes"], if beside { &GRID[..] } else { &[] });
    let heads: String = ours.iter().chain(grid).map(|head| format!("<th scope=\"col\">{head}</th>")).collect();
    format!(
        "<div class=\"scroll\"><table class=\"selection\">\n<caption>{} · <span class=\"bound\">{}</span></caption>\n\
         <thead><tr>{heads}</tr></thead>\n<tbody>\n{rows}</tbody>\n</table></div>\n",
        escape(&selection.title),
        escape(&selection.bound)
    )
}

/// Columns of the grid.
const GRID: [&str; 5] = ["of the grid's", "gap", "model of the grid", "bytes", "error"];

fn line(row: &Selected, largest: u64, beside: bool) -> String {
    let part = 100.0 * row.bytes as f64 / largest.max(1) as f64;
    let or_none = |text: Option<String>| text.unwrap_or_else(|| NONE.into());
    let ours = [or_none(row.relight_ms.map(short)), row.encodes.to_string()];
    let grid = [
        or_none(row.grid_encodes.and_then(|grid| share(row.encodes, grid))),
        or_none(row.gap_percent.map(gap)),
        or_none(row.grid_method.as_deref().map(escape)),
        or_none(row.grid_bytes.map(bytes)),
        or_none(row.grid_error.map(short)),
    ];
    let cells = ours.iter().chain(grid.iter().filter(|_| beside));
    let cells: String = cells.map(|cell| format!("<td>{cell}</td>")).collect();
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
    fn a_grid_has_its_columns_where_there_is_one() {
        let one = Selected { family: "<cpca>".into(), method: "cpca".into(), bytes: 10, ..Selected::default() };
        let other = Selected { grid_encodes: Some(40), gap_percent: Some(-2.0), encodes: 4, ..one.clone() };
        let page = |rows| tables(&[Selection { title: "teapot".into(), bound: "error ≤ 1e-3".into(), rows }]);
        let alone = page(vec![one.clone()]);
        assert!(alone.contains("&lt;cpca&gt;") && alone.contains("error ≤ 1e-3") && !alone.contains("gap"));
        let both = page(vec![one, other]);
        assert!(both.contains("<td>10 % of 40</td><td>−2.0 %</td>"), "{both}");
        // All five of a family without, and three of the other.
        assert_eq!([&alone, &both].map(|html| html.matches("<td>–</td>").count()), [1, 2 + 5 + 3], "{both}");
    }
}
