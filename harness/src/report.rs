//! report.html: tables and charts in one page that needs nothing else.

use crate::bench::Group;
use crate::charts;
use crate::machine::Machine;
use crate::row::Row;
use crate::table::{COLUMNS, LEGEND};

const STYLE: &str = "body{font:15px/1.5 'DejaVu Sans',Verdana,sans-serif;max-width:1100px;margin:2em auto;padding:0 1em;color:#222}\
table{border-collapse:collapse;font-size:13px;width:100%}th,td{padding:.25em .6em;text-align:right;border-bottom:1px solid #ddd}\
th:first-child,td:first-child{text-align:left;font-family:monospace}td.reason{text-align:left;color:#a33}\
svg{width:100%;height:auto;margin:1em 0}p.small{font-size:13px;color:#666}";

/// The page.
pub fn page(groups: &[Group], machine: &Machine) -> String {
    let sections: String = groups.iter().map(section).collect();
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>prt bench</title><style>{STYLE}</style></head>\n\
         <body><h1>prt bench</h1>\n<p class=\"small\">{}</p>\n<p class=\"small\">{}</p>\n{sections}</body></html>\n",
        escape(&machine.line()),
        escape(LEGEND).replace('\n', "<br>"),
    )
}

fn section(group: &Group) -> String {
    let titles: String = COLUMNS.iter().map(|(title, _)| format!("<th>{title}</th>")).collect();
    let rows: String = group.rows.iter().map(row).collect();
    let charts: String = charts::of(group).iter().map(|chart| chart.svg(None)).collect();
    let title = escape(&group.title);
    format!("<h2>{title}</h2>\n<table><tr><th>method</th>{titles}</tr>\n{rows}</table>\n{charts}\n")
}

fn row(row: &Row) -> String {
    let figures: String = match row.is_ok() {
        true => COLUMNS.iter().map(|(_, f)| format!("<td>{}</td>", f(row).unwrap_or_else(|| "–".into()))).collect(),
        false => format!("<td class=\"reason\" colspan=\"{}\">failed: {}</td>", COLUMNS.len(), escape(&row.reason)),
    };
    format!("<tr><td>{}</td>{figures}</tr>\n", escape(&row.method))
}

/// `text` where HTML expects text or a quoted attribute.
fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_files_cannot_become_markup() {
        let failed = Row { method: "<b>".into(), ..Row::default() }.failed("a & \"b\"");
        let group = Group { title: "<script>".into(), file_name: String::new(), rows: vec![failed] };
        let page = page(&[group], &Machine::here(1));
        assert!(!page.contains("<script>") && !page.contains("<b>") && page.contains("failed: a &amp; &quot;b&quot;"));
    }
}
