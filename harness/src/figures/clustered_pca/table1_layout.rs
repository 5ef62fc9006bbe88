//! Table 1, each of the paper's lines with ours below it.

use super::table1::Measured;
use crate::figures::outcome::Outcome;
use crate::tables::beside::{Beside, Cell, Column, Line};

/// Seconds and SE of static, then of iterative encoding, then iterative over static.
fn cells(seconds: [Option<f64>; 2], errors: [Option<f64>; 2], cell: fn(f64) -> Cell) -> Vec<Cell> {
    let ratio = |[of_static, iterative]: [Option<f64>; 2]| Some(iterative? / of_static?);
    let figures = [seconds[0], errors[0], seconds[1], errors[1]].map(|figure| figure.map(cell).into());
    figures.into_iter().chain([ratio(seconds).into(), ratio(errors).into()]).collect()
}

impl Measured {
    fn printed(&self) -> Line {
        let line = self.line;
        let [seconds, errors] =
            [line.printed.map(|p| p.seconds), line.printed.map(|p| p.error)].map(|two| two.map(Some));
        let sizes = [line.mesh.vertices, line.clusters, line.components].map(Cell::from);
        let cells = sizes.into_iter().chain(cells(seconds, errors, Cell::Printed)).collect();
        Line::printed(format!("{} {} {}", line.model, line.brdf, line.matrix), cells)
    }

    fn ours(&self) -> Line {
        let name = format!("{} {}", self.line.model, self.line.brdf);
        let failed = |o: &Outcome| (!o.row.is_ok()).then(|| format!("{}: {}", o.row.method, o.row.reason));
        let subject = match (&self.subject, self.outcomes.iter().find_map(failed)) {
            (Err(reason), _) => return Line::ours(name.clone(), (name, ""), Err(reason.clone())),
            (Ok(_), Some(reason)) => return Line::ours(name.clone(), (name, ""), Err(reason)),
            (Ok(subject), None) => subject,
        };
        let of = |figure: fn(&Outcome) -> Option<f64>| [0, 1].map(|i| self.outcomes.get(i).and_then(figure));
        let samples = self.outcomes.first().map_or(0, |o| o.row.samples);
        let sizes = [samples, self.clusters, self.line.components].map(Cell::from);
        let cells = sizes.into_iter().chain(cells(of(|o| o.row.encode_s), of(Outcome::squared_error), Cell::Figure));
        let scene = subject.split(" · ").next().unwrap_or(subject);
        Line::ours(scene, (subject, "cpca, static and iterative"), Ok(cells.collect()))
    }
}

/// Two lines for each of the paper's.
pub(super) fn beside(lines: &[Measured]) -> Beside {
    Beside {
        addition: "",
        title: "Table 1: static and iterative encoding (Sloan et al. 2003)".into(),
        subjects: Vec::new(),
        head: "model",
        columns: vec![
            Column::whole("samples", "m_p"),
            Column::whole("clusters", "m_c"),
            Column::whole("components", "n'"),
            Column::new("static_s", "static s"),
            Column::new("static_se", "SE"),
            Column::new("iterative_s", "iterative s"),
            Column::new("iterative_se", "SE"),
            Column::new("time_ratio", "time, it./st."),
            Column::new("se_ratio", "SE, it./st."),
        ],
        lines: lines.iter().flat_map(|measured| [measured.printed(), measured.ours()]).collect(),
        why: "SE is a sum over all vertices of another mesh: compare the ratio of the two ways. Times are of a 2.2 GHz \
              Pentium 4 there and of all threads here, on a built-in scene of fewer vertices and clusters. Subsurface \
              scattering is left out of the third line.",
    }
}
