//! The table of a matrix, which is there without any script.

use super::data::Labelled;
use super::html::escape;
use super::quantity::{Fields, Quantity, measured};
use crate::bench::Group;
use crate::charts::Marker;
use crate::row::Row;
use serde_json::Value;

/// A spread above this part of its median is marked.
pub(super) use crate::timing::STEADY as UNSTEADY;

/// The table of the matrix at this place of the data.
pub(super) fn table(index: usize, matrix: &Group, families: &[String]) -> String {
    let rows: Vec<Fields> = matrix.rows.iter().map(fields).collect();
    let columns = measured(&rows);
    let heads: String = columns.iter().map(|q| head(q)).collect();
    let lines = matrix.rows.iter().zip(&rows).enumerate();
    let body: String = lines.map(|(i, (row, fields))| line(i, row, fields, &columns, families)).collect();
    let title = escape(&matrix.title);
    format!(
        "<section class=\"matrix\" data-group=\"{index}\" aria-label=\"{title}\">\n<div class=\"scroll\"><table>\n\
         <caption>{title}</caption>\n<thead><tr><th scope=\"col\">method</th>{heads}</tr></thead>\n\
         <tbody>\n{body}</tbody>\n</table></div>\n</section>\n"
    )
}

/// A row as JSON; nothing but its own fields could make that fail, and then it has no figures.
pub(super) fn fields(row: &Row) -> Fields {
    match serde_json::to_value(Labelled::new(row)) {
        Ok(Value::Object(fields)) => fields,
        _ => Fields::new(),
    }
}

fn class(quantity: &Quantity) -> &'static str {
    if quantity.usual { "" } else { " class=\"more\"" }
}

fn head(quantity: &Quantity) -> String {
    let Quantity { key, head, axis, how, .. } = quantity;
    let title = escape(&format!("{axis}. {how}"));
    format!("<th scope=\"col\" data-key=\"{key}\" title=\"{title}\"{}>{}</th>", class(quantity), escape(head))
}

fn line(index: usize, row: &Row, fields: &Fields, columns: &[&Quantity], families: &[String]) -> String {
    let place = families.iter().position(|family| *family == row.family).unwrap_or_default();
    let figure = |q: &&Quantity| format!("<td{}>{}</td>", class(q), q.text(fields).unwrap_or_else(|| "–".into()));
    let figures: String = match row.is_ok() {
        true => columns.iter().map(figure).collect(),
        false => {
            format!("<td class=\"reason\" colspan=\"{}\">failed: {}</td>", columns.len().max(1), escape(&row.reason))
        }
    };
    let (marker, method, mark) = (Marker::of(place).svg(), breakable(&row.method), unsteady(fields, columns));
    format!("<tr data-row=\"{index}\"><th scope=\"row\">{marker}{method}{mark}</th>{figures}</tr>\n")
}

/// A label that may go on in the next line before a parameter.
fn breakable(method: &str) -> String {
    escape(method).replace(':', "<wbr>:")
}

/// A mark that names the times of a row whose runs lay far apart.
fn unsteady(row: &Fields, columns: &[&Quantity]) -> String {
    let spreads = columns.iter().filter_map(|q| Some((q, q.spread(row)?))).filter(|(_, spread)| *spread > UNSTEADY);
    let texts: Vec<String> = spreads
        .map(|(q, spread)| format!("{}: quartiles {:.0} % of the median apart", q.axis, 100.0 * spread))
        .collect();
    match texts.is_empty() {
        true => String::new(),
        false => format!(" <abbr class=\"unsteady\" title=\"{}\">±</abbr>", escape(&texts.join("\n"))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::row::Status;

    fn html(rows: Vec<Row>) -> String {
        table(0, &Group { rows, ..Group::default() }, &["csr".into()])
    }

    #[test]
    fn only_times_that_varied_by_a_tenth_are_marked_and_columns_without_figures_are_left_out() {
        let row = |spread| Row {
            method: "csr".into(),
            status: Status::Ok,
            relight_1_ms: Some(2.0),
            relight_1_spread_ms: Some(spread),
            ..Row::default()
        };
        let (steady, unsteady) = (html(vec![row(0.2)]), html(vec![row(0.5)]));
        assert!(!steady.contains("±") && unsteady.contains("quartiles 25 % of the median apart"), "{unsteady}");
        assert!(
            steady.contains("data-key=\"relight_1_ms\"") && !steady.contains("data-key=\"file_bytes\""),
            "{steady}"
        );
    }

    #[test]
    fn a_failed_row_spans_the_columns_of_the_others() {
        let ok =
            Row { method: "csr".into(), status: Status::Ok, error: Some(0.0), encode_s: Some(1.0), ..Row::default() };
        let failed = Row { method: "dense".into(), ..Row::default() }.failed("would need 9 GB");
        assert!(html(vec![ok, failed]).contains("colspan=\"2\">failed: would need 9 GB</td>"));
    }
}
