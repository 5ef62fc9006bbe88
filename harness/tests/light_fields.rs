//! Surface light fields as a user meets them: traced, compressed, drawn, and refused.

mod common;

use common::{done, prt};
use serde_json::Value;
use std::path::Path;

/// Fine enough for a picture.
const FINER: [&str; 6] = ["--texels", "24x24", "--directions", "32x16", "--diffuse-paths", "64"];
/// The smallest world, at a size that takes a second.
const SMALL: [&str; 6] = ["--texels", "12x12", "--directions", "12x6", "--diffuse-paths", "16"];

fn json(text: &str) -> Value {
    serde_json::from_str(text).unwrap()
}

/// The sentence of a run that must fail.
fn refused(arguments: &[&str], folder: &Path) -> String {
    let output = prt(arguments, folder);
    let message = String::from_utf8_lossy(&output.stderr).to_string();
    assert_eq!((output.status.code(), message.lines().count()), (Some(1), 1), "{arguments:?}: {message}");
    message
}

/// Numbers of a picture's comparison.
fn drawn(arguments: &[&str], folder: &Path) -> Value {
    let picture = ["render", "glossy-sphere", "--size", "48x40", "--json", "-o", "picture.png"];
    json(&done(&[&picture[..], arguments].concat(), folder))
}

#[test]
fn a_world_is_traced_compressed_and_drawn_as_its_paths_show_it() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let made = ["slf", "glossy-sphere", "--method", "sphere=slf:clusters=8:components=6", "--json", "-o", "field"];
    let told = json(&done(&[&made[..], &FINER].concat(), folder));
    let shapes = told["shapes"].as_array().unwrap();
    assert_eq!(shapes.iter().map(|s| s["shape"].as_str().unwrap()).collect::<Vec<_>>(), ["floor", "lamp", "sphere"]);
    for shape in shapes {
        // Eq. 5, and the bytes of the sections that it counts.
        let (m, n) = (24 * 24, 32 * 16);
        let counts = &shape["counts"];
        let [k, eta] = ["components", "clusters"].map(|name| counts[name].as_u64().unwrap());
        assert_eq!(counts["surface_map"], 3 * m * k);
        assert_eq!(counts["view_maps"], 3 * eta * n * k);
        assert_eq!((&counts["mean_map"], &counts["cluster_ids"]), (&(3 * m).into(), &m.into()));
        let sections = shape["sections"].as_array().unwrap();
        let bytes = |name: &str| -> u64 {
            let named = sections.iter().filter(|s| s[0].as_str().unwrap().ends_with(name));
            named.map(|s| s[1].as_u64().unwrap()).sum()
        };
        assert_eq!([bytes("/surface"), bytes("/views")], [4 * 3 * m * k, 4 * 3 * eta * n * k]);
        // A matte shape is one number a texel, to the last bit.
        let matte = shape["shape"] != "sphere";
        assert_eq!((k == 0 && eta == 1, shape["error"] == 0.0), (matte, matte), "{shape}");
        let file = folder.join(format!("field/{}.prt", shape["shape"].as_str().unwrap()));
        assert_eq!(file.metadata().unwrap().len(), shape["file_bytes"].as_u64().unwrap());
    }
    assert!(folder.join("field/shapes.csv").exists());

    done(&["render", "glossy-sphere", "--size", "48x40", "--reference", "--samples", "12", "-o", "paths.exr"], folder);
    let compared = ["--slf", "field", "--compare", "paths.exr", "--beside", "beside.png"];
    let error = drawn(&compared, folder)["relative_squared_error"].as_f64().unwrap();
    assert!(error < 0.1, "{error}");
    // What is not compressed at all is no worse, and a shape without a field is traced.
    done(&[&["slf", "glossy-sphere", "--method", "dense", "-o", "dense"][..], &FINER].concat(), folder);
    let dense = drawn(&["--slf", "dense", "--compare", "paths.exr"], folder);
    assert!(dense["relative_squared_error"].as_f64().unwrap() < error + 1e-3, "{dense}");
    std::fs::remove_file(folder.join("dense/floor.prt")).unwrap();
    let traced = drawn(&["--slf", "dense", "--compare", "paths.exr"], folder);
    assert!(traced["note"].as_str().unwrap().contains("floor") && traced["relative_squared_error"].is_number());
}

#[test]
fn fields_are_the_same_on_any_number_of_threads_and_as_a_matrix_too() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let made = ["slf", "glossy-sphere", "--shape", "sphere", "--method", "slf:clusters=4:components=3"];
    done(&[&made[..], &SMALL, &["--threads", "1", "-o", "one"]].concat(), folder);
    done(&[&made[..], &SMALL, &["--threads", "2", "--keep", "-o", "two"]].concat(), folder);
    let read = |path: &str| std::fs::read(folder.join(path)).unwrap();
    assert_eq!(read("one/sphere.prt"), read("two/sphere.prt"));
    done(&[&made[..], &SMALL, &["--seed", "1", "-o", "other"]].concat(), folder);
    assert_ne!(read("one/sphere.prt"), read("other/sphere.prt"));
    // The field that was kept is a matrix like any other.
    let described = ["--responses", "texels:12x12:octahedral:reflected", "--basis", "latlong:12x6", "-o", "again.prt"];
    let encode = ["encode", "slf:clusters=4:components=3", "two/sphere.npy"];
    done(&[&encode[..], &described].concat(), folder);
    assert_eq!(read("again.prt"), read("one/sphere.prt"));
}

#[test]
fn what_cannot_be_sampled_or_drawn_is_refused_in_one_sentence() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let write = |name: &str, text: &str| std::fs::write(folder.join(name), text).unwrap();
    let corners = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 2 0 0\n";
    write("bare.obj", &format!("{corners}f 1 2 3\n"));
    write("over.obj", &format!("{corners}vt 0 0\nvt 1 0\nvt 1 1\nf 1/1 2/2 3/3\nf 1/1 3/2 4/3\n"));
    write("flat.obj", &format!("{corners}vt 0 0\nvt 1 0\nvt 1 1\nf 1/1 2/2 5/3\n"));
    write("outside.obj", &format!("{corners}vt 0 0\nvt 7 0\nvt 1 1\nf 1/1 2/2 3/3\n"));
    let sampled = |mesh: &str| refused(&[&["slf", mesh, "-o", "x"][..], &SMALL].concat(), folder);
    for (mesh, word) in [
        ("bare.obj", "texture coordinates"),
        ("over.obj", "overlap"),
        ("flat.obj", "area"),
        ("outside.obj", "0 to 1"),
        ("teapot", "cornell-spheres"),
    ] {
        let message = sampled(mesh);
        assert!(message.contains(word), "{mesh}: {message}");
    }
    let world = |options: &[&str]| refused(&[&["slf", "glossy-sphere", "-o", "x"][..], options].concat(), folder);
    assert!(world(&["--texels", "cube=4x4"]).contains("no shape cube"));
    assert!(world(&["--light", "sky"]).contains("its own lights"));
    assert!(world(&["--filter", "3"]).contains("supersampling"));
    assert!(world(&["--method", "nothing"]).contains("nothing"));
    assert!(!folder.join("x").exists(), "nothing is written before everything is checked");

    std::fs::create_dir(folder.join("empty")).unwrap();
    let render =
        |options: &[&str]| refused(&[&["render", "glossy-sphere", "-o", "p.png"][..], options].concat(), folder);
    assert!(render(&["--slf", "empty"]).contains("prt slf makes them"));
    assert!(render(&["T.prt"]).contains("--slf"));
    assert!(render(&["--reference", "--vertices", "5"]).contains("--vertices"));
    let direct = ["render", "two-polygons", "--reference", "--size", "8x8", "-o", "p.png"];
    assert!(refused(&[&direct[..], &["--seed", "1"]].concat(), folder).contains("--bounces"));
    // Paths of a built-in scene need no chart; looking up needs a field.
    done(&[&direct[..], &["--samples", "1", "--bounces", "2", "--seed", "1"]].concat(), folder);
    assert!(refused(&[&direct[..], &["--interpolation", "paper"]].concat(), folder).contains("--slf"));
}

#[test]
fn fireflies_are_cut_only_when_asked_and_then_counted() {
    let folder = tempfile::tempdir().unwrap();
    let clamped = |options: &[&str]| {
        let made = ["slf", "glossy-sphere", "--shape", "sphere", "--json", "-o", "field"];
        let told = json(&done(&[&made[..], &SMALL, options].concat(), folder.path()));
        told["shapes"][0]["clamped"].as_u64().unwrap()
    };
    assert_eq!(clamped(&[]), 0);
    assert!(clamped(&["--clamp", "0.5"]) > 100);
}
