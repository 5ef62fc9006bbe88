//! What every table promises.

use super::beside::{Cell, Column, Line};
use super::*;

fn beside() -> Beside {
    let cells = |a: f64, b: Cell| vec![Cell::from(a), b, Cell::Figure(7.0)];
    let failed = |name: &str, method: &str| Line::ours(name, ("blob", method), Err("out of memory".into()));
    Beside {
        addition: "",
        title: "Table 0".into(),
        subjects: vec!["a blob".into()],
        head: "model",
        columns: vec![Column::bytes("file_bytes", "file"), Column::new("error", "error"), Column::whole("hidden", "")],
        lines: vec![
            Line::printed("bunny", cells(1_234_567.0, Cell::Printed(10_996.5))),
            Line::ours("blob, csr", ("blob", "csr"), Ok(cells(999.0, Cell::from(0.012_345)))),
            failed("blob, f16", "f16"),
            failed("blob, f32", "f32"),
            Line::ours("blob, dense", ("blob", "dense"), Ok(vec![Cell::Nothing, "none".into()])),
        ],
        why: "Another mesh.",
    }
}

#[test]
fn what_is_printed_keeps_its_digits_and_ours_stand_below_it() {
    let text = beside().terminal();
    let words = |start: &str| {
        let line = text.lines().find(|line| line.starts_with(start)).unwrap_or_else(|| panic!("{start}: {text}"));
        line[start.len()..].split_whitespace().map(String::from).collect::<Vec<_>>()
    };
    assert_eq!(words("bunny, the paper's"), ["1.23", "MB", "10996.5"]);
    assert_eq!(words("  blob, csr"), ["999", "B", "0.0123"]);
    assert_eq!((words("  blob, f16"), words("  blob, dense")), (vec!["-".into(); 2], vec!["-".into(), "none".into()]));
    assert!(text.starts_with("\nTable 0\na blob\n") && !text.contains('7'), "what programs alone read: {text}");
    // The same subject for the same reason: once.
    assert!(text.ends_with("\nblob, f16: out of memory\nAnother mesh."), "{text}");
}

#[test]
fn markdown_and_csv_have_every_line_and_csv_every_column_exactly() {
    let (beside, machine) = (beside(), Machine::here(2));
    let markdown = beside.markdown();
    let bars: Vec<usize> = markdown.lines().filter(|l| l.starts_with('|')).map(|l| l.matches('|').count()).collect();
    assert_eq!(bars, [4; 2 + 5], "{markdown}");
    assert!(
        markdown.contains("| **bunny, the paper's** | 1.23 MB |") && markdown.ends_with("Another mesh.\n"),
        "{markdown}"
    );
    let csv = beside.csv(&machine).unwrap();
    let mut reader = csv::Reader::from_reader(csv.as_slice());
    let head = "source,subject,method,status,reason,file_bytes,error,hidden,machine";
    assert_eq!(reader.headers().unwrap(), head.split(',').collect::<Vec<_>>());
    let records: Vec<Vec<String>> = reader.deserialize().map(Result::unwrap).collect();
    assert_eq!(records[0], ["paper", "bunny", "", "ok", "", "1234567", "10996.5", "7", ""]);
    assert_eq!(records[1][..8], ["measured", "blob", "csr", "ok", "", "999", "0.012345", "7"]);
    assert_eq!(records[2][..8], ["measured", "blob", "f16", "failed", "out of memory", "", "", ""]);
    assert_eq!((records.len(), &records[1][8]), (5, &machine.line()));
    assert!(beside.is_measured() && !Beside { lines: vec![beside.lines[0].clone()], ..beside }.is_measured());
}

#[test]
fn every_table_of_every_paper_is_listed_and_no_chart_of_our_own() {
    let list = list();
    for (paper, expected) in [
        ("biclustering", &["table1", "table2", "figure6"][..]),
        ("clustered-pca", &["figure2", "figure3", "figure10", "table1"]),
        ("slf", &["table1"]),
        ("tensor", &["table1", "table2", "figure4", "figure5"]),
    ] {
        let paper = find(paper).unwrap();
        let names: Vec<&str> = tables(paper).map(|figure| figure.name).collect();
        assert_eq!(names, expected, "{}", paper.name);
        assert!(tables(paper).all(|figure| list.contains(figure.table.unwrap())), "{list}");
    }
    assert!(!list.contains("bandwidth") && list.lines().all(|line| line.chars().count() <= 120), "{list}");
}
