//! What the page must hold, whatever it looks like.

use super::*;
use crate::bench::Group;
use crate::machine::Machine;
use crate::pictures::{Pictures, Shown};
use crate::png::Png;
use crate::row::{Row, Status};
use serde_json::Value;

fn data(rows: Vec<Row>, title: &str) -> Data {
    let groups = vec![Group { title: title.into(), rows, ..Group::default() }];
    Data { machine: Machine::here(1), groups, selections: Vec::new() }
}

/// What the scripts read.
fn embedded(page: &str) -> Value {
    let (_, rest) = page.split_once("id=\"data\">").unwrap();
    serde_json::from_str(rest.split_once("</script>").unwrap().0).unwrap()
}

#[test]
fn names_of_files_cannot_become_markup() {
    let hostile = "</script><script>alert(1)</script><!--";
    let shown = Shown { method: hostile.into(), family: hostile.into(), ..Shown::default() };
    let pictures = Pictures { light: hostile.into(), shown: vec![shown], ..Pictures::default() };
    let selected = Selected { family: "<i>".into(), grid_method: Some("<u>".into()), ..Selected::default() };
    let of = |name: &str, reason: &str| {
        let row = Row { scene: name.into(), method: format!("<b>{name}"), family: name.into(), ..Row::default() };
        let mut data = data(vec![row.failed(reason)], name);
        data.machine.cpu = name.into();
        data.groups[0].pictures = vec![pictures.clone()];
        data.selections = vec![Selection { title: name.into(), bound: name.into(), rows: vec![selected.clone()] }];
        page(&data, None)
    };
    let (page, harmless) = (of(hostile, "a & \"b\""), of("teapot", "c"));
    for tag in ["<script", "</script", "<!--", "<b>", "<i>", "<u>", "<img"] {
        assert_eq!(page.matches(tag).count(), harmless.matches(tag).count(), "{tag}");
    }
    assert!(page.contains("failed: a &amp; &quot;b&quot;") && page.contains("&lt;b&gt;&lt;/script&gt;"));
    let embedded = embedded(&page);
    assert_eq!(embedded["groups"][0]["title"], hostile);
    assert_eq!(embedded["groups"][0]["pictures"][0]["light"], hostile);
}

#[test]
fn every_row_is_there_twice_as_a_line_of_its_table_and_with_every_column_of_results_csv() {
    let ok = |method: &str, error| Row {
        method: method.into(),
        family: crate::family::of(method),
        status: Status::Ok,
        error: Some(error),
        resident_bytes: Some(1500),
        multiplications: Some(3),
        additions: Some(4),
        ..Row::default()
    };
    let failed = Row { method: "dense".into(), family: "dense".into(), ..Row::default() }.failed("would need 9 GB");
    let rows = vec![ok("csr", 0.0), ok("haar+truncate:terms=64", 0.0312), failed];
    let page = page(&data(rows.clone(), "teapot"), None);
    let embedded = embedded(&page);
    for (row, read) in rows.iter().zip(embedded["groups"][0]["rows"].as_array().unwrap()) {
        let Value::Object(columns) = serde_json::to_value(row).unwrap() else { panic!("a row is an object") };
        columns.iter().for_each(|(name, value)| assert_eq!(&read[name], value, "{name}"));
        assert!(page.contains(&format!("{}</th>", row.method.replace(':', "<wbr>:"))), "{} has no line", row.method);
    }
    assert_eq!(embedded["groups"][0]["rows"][1]["label"], "64");
    assert_eq!(embedded["groups"][0]["rows"][1]["flops"], 7);
    assert!(page.contains("<td>1.50 kB</td>") && page.contains("<td>0.0312</td>") && page.contains("would need 9 GB"));
    let names: Vec<&str> =
        embedded["families"].as_array().unwrap().iter().map(|f| f["name"].as_str().unwrap()).collect();
    assert_eq!(names, ["csr", "haar+truncate", "dense"]);
}

#[test]
fn sections_without_data_are_absent_and_pictures_are_in_the_page() {
    let mut data = data(Vec::new(), "teapot");
    let bare = page(&data, None);
    assert!(!bare.contains("id=\"pictures\"") && !bare.contains("id=\"selections\""));
    let shown = Shown { picture: Png(b"foo".into()), strip: Some(Png(b"f".into())), ..Shown::default() };
    data.groups[0].pictures = vec![Pictures { shown: vec![shown], ..Pictures::default() }];
    data.selections = vec![Selection::default()];
    let page = page(&data, None);
    assert!(page.contains("id=\"pictures\"") && page.contains("id=\"selections\""));
    let shown = &embedded(&page)["groups"][0]["pictures"][0]["shown"][0];
    assert_eq!(shown["picture"], "data:image/png;base64,Zm9v");
    assert_eq!(shown["strip"], "data:image/png;base64,Zg==");
}

#[test]
fn the_page_asks_nothing_of_anybody() {
    let page = page(&data(Vec::new(), "teapot"), None);
    for word in ["src=\"", "href=\"http", "@import", "url(", "fetch(", "XMLHttpRequest", "innerHTML"] {
        assert!(!page.contains(word), "{word}");
    }
}
