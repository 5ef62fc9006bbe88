//! The atlas of failure: a chart and a table of bounds for each part.

use super::html::escape;
use crate::stability::atlas::table::Row;
use crate::stability::atlas::{Atlas, Outcome, chart};

/// A chart and a table for each part.
pub(super) fn parts(atlas: &Atlas) -> String {
    let part = |(part, outcomes): &(&'static _, Vec<Outcome>)| {
        let svg = chart::chart(part, outcomes).svg(None);
        let rows: String = outcomes.iter().map(row).collect();
        let heads: String = HEADS.iter().map(|head| format!("<th scope=\"col\">{head}</th>")).collect();
        format!(
            "<figure class=\"case\">{svg}</figure>\n<div class=\"scroll\"><table class=\"bounds\">\n\
             <caption class=\"apart\">Bounds: {}</caption>\n<thead><tr>{heads}</tr></thead>\n\
             <tbody>\n{rows}</tbody>\n</table></div>\n",
            escape(part.title)
        )
    };
    atlas.parts.iter().map(part).collect()
}

const HEADS: [&str; 8] = ["case", "driven", "as printed", "at the end", "beyond from", "here", "", "bound"];

fn row(outcome: &Outcome) -> String {
    let Row { range, here, bound, printed, breaks, kept } = Row::of(outcome);
    let case = outcome.case;
    let mut text = [case.title, case.source, case.parameter, case.printed.name, case.here.name, case.promise]
        .map(escape)
        .into_iter();
    let mut next = || text.next().unwrap_or_default();
    let (title, source, parameter, theirs, ours, promise) = (next(), next(), next(), next(), next(), next());
    let verdict = if kept { "<b class=\"kept\">kept</b>" } else { "<b class=\"broken\">broken</b>" };
    let breaks = breaks.unwrap_or_else(|| "–".into());
    format!(
        "<tr><th scope=\"row\">{title}<br><span class=\"faint\">{source}</span></th>\
         <td class=\"text\">{parameter}<br><span class=\"faint\">{range}</span></td><td class=\"text\">{theirs}</td>\
         <td>{printed}</td><td>{breaks}</td><td class=\"text\">{ours}</td><td>{here}</td>\
         <td class=\"text\">{verdict} {bound}<br><span class=\"faint\">{promise}</span></td></tr>\n"
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stability::atlas::{PARTS, Point};

    #[test]
    fn every_case_has_its_line_its_curves_and_a_verdict() {
        let outcome =
            |case| Outcome { case, points: vec![Point { value: 1.0, printed: Err("x".into()), here: Ok(1e9) }] };
        let atlas = Atlas { parts: PARTS.iter().map(|p| (p, p.cases.iter().map(outcome).collect())).collect() };
        let (page, cases) = (parts(&atlas), atlas.outcomes().count());
        assert_eq!(page.matches("<tr><th scope=\"row\">").count(), cases);
        assert_eq!((page.matches(">broken<").count(), page.matches(">kept<").count()), (cases, 0));
        assert_eq!((page.matches("<svg").count(), page.matches("<figure").count()), (PARTS.len(), PARTS.len()));
        // Not a failure of the page: each black cross is a form that is no number there.
        assert!(page.matches(">×</text>").count() >= cases);
    }
}
