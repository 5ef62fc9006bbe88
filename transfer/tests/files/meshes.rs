use super::{folder, names};
use glam::{Vec2, Vec3};
use prt_transfer::io::mesh::{self, read_charted_obj, read_charted_ply, read_obj, read_ply};
use prt_transfer::mesh::Mesh;
use prt_transfer::texels::Border;

/// A quadrilateral and a triangle over it, with properties and elements that nobody asked for.
const HEADER: &str = "comment made by hand\nobj_info nothing\nelement vertex 4\nproperty float x\nproperty double y\n\
    property short z\nproperty list uchar float weights\nproperty float nx\nproperty float ny\nproperty float nz\n\
    element face 2\nproperty uchar flag\nproperty list uchar uint vertex_index\nelement edge 1\nproperty int a\n\
    property list ushort double lengths\nend_header\n";
const CORNERS: [[i16; 3]; 4] = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, -7]];

fn expected() -> Mesh {
    Mesh {
        positions: CORNERS.map(|c| Vec3::from(c.map(f32::from))).to_vec(),
        normals: vec![Vec3::Z; 4],
        faces: vec![[0, 1, 2], [0, 2, 3], [3, 2, 1]],
    }
}

fn ascii() -> String {
    let vertices: String = CORNERS.iter().map(|[x, y, z]| format!("{x} {y} {z} 2 0.5 0.5 0 0 2\n")).collect();
    format!("ply\nformat ascii 1.0\n{HEADER}{vertices}9 4 0 1 2 3\n9 3 3 2 1\n5 2 1.5 2.5\n")
}

macro_rules! binary {
    ($name:literal, $bytes:ident) => {{
        let mut file = format!("ply\nformat binary_{}_endian 1.0\n{HEADER}", $name).into_bytes();
        for [x, y, z] in CORNERS {
            file.extend(f32::from(x).$bytes());
            file.extend(f64::from(y).$bytes());
            file.extend(z.$bytes());
            file.push(1);
            [0.5f32, 0.0, 0.0, 2.0].iter().for_each(|v| file.extend(v.$bytes()));
        }
        for face in [&[0u32, 1, 2, 3][..], &[3, 2, 1]] {
            file.extend([9, face.len() as u8]);
            face.iter().for_each(|v| file.extend(v.$bytes()));
        }
        file.extend(5i32.$bytes());
        file.extend(2u16.$bytes());
        [1.5f64, 2.5].iter().for_each(|v| file.extend(v.$bytes()));
        file
    }};
}

#[test]
fn the_three_encodings_of_ply_are_one_mesh() {
    assert_eq!(read_ply(ascii().as_bytes()).unwrap(), expected());
    assert_eq!(read_ply(ascii().replace('\n', "\r\n").as_bytes()).unwrap(), expected());
    assert_eq!(read_ply(&binary!("little", to_le_bytes)).unwrap(), expected());
    assert_eq!(read_ply(&binary!("big", to_be_bytes)).unwrap(), expected());
}

#[test]
fn a_broken_ply_names_the_place() {
    let text = ascii();
    let with = |from: &str, to: &str| {
        assert!(text.contains(from));
        read_ply(text.replacen(from, to, 1).as_bytes())
    };
    names(read_ply(b"solid"), "line 1");
    names(with("format ascii 1.0", "format ebcdic 1.0"), "line 2");
    names(with("property short z", "property word z"), "line 8");
    names(with("property double y\n", ""), "x, y, z");
    names(with("vertex_index", "corners"), "vertex_index");
    names(with("1 0 0 2", "1 zero 0 2"), "line 21");
    names(with("1 0 0 2", "nan 0 0 2"), "vertex 1");
    names(with("3 3 2 1", "3 4 2 1"), "triangle 2");
    names(with("3 3 2 1", "3 -1 2 1"), "line 25");
    let little = binary!("little", to_le_bytes);
    names(read_ply(&little[..little.len() - 1]), &format!("byte {}", little.len() - 8));
}

#[test]
fn one_normal_of_no_length_means_no_normals() {
    assert_eq!(read_ply(ascii().replacen("0 0 2\n", "0 0 0\n", 1).as_bytes()).unwrap().normals, []);
}

#[test]
fn obj_groups_share_vertices_and_negative_indices_count_from_the_end() {
    // Latin-1 in a comment and a name, groups, materials, texture coordinates, a continued line, points and lines.
    let text =
        b"# caf\xe9\nmtllib a.mtl\no t\xe9a\nv 0 0 0\nv 1 0 0\nv 1 1 0\nvt 0 0\ng one\nusemtl red\nf 1/1 2/1 3/1\n\
        g two\nv 0 1 0 # corner\nf -4 -2 \\\n -1\np 1\nl 1 2\n";
    let mesh = read_obj(text).unwrap();
    assert_eq!(mesh.positions, [Vec3::ZERO, Vec3::X, Vec3::new(1.0, 1.0, 0.0), Vec3::Y]);
    assert_eq!(mesh.faces, [[0, 1, 2], [0, 2, 3]]);
    assert_eq!(mesh.normals, []);
}

#[test]
fn obj_polygons_are_fans_and_a_vertex_has_one_normal() {
    let text = b"v 0 0 0\nv 1 0 0\nv 2 1 0\nv 1 2 0\nv 0 1 0\nvn 0 0 3\nvn 0 2 0\nf 1//1 2//1 3//1 4//1 5//1\nf 1//2 2//2 3//1\n";
    let mesh = read_obj(text).unwrap();
    assert_eq!(mesh.faces, [[0, 1, 2], [0, 2, 3], [0, 3, 4], [5, 6, 2]]);
    assert_eq!(mesh.positions[5..], mesh.positions[..2]);
    assert_eq!((mesh.normals[0], mesh.normals[5]), (Vec3::Z, Vec3::Y));
}

#[test]
fn obj_normals_that_some_corner_does_not_have_are_no_normals() {
    let text = "v 0 0 0\nv 1 0 0\nv 1 1 0\nvn 0 0 1\n";
    for faces in ["f 1 2 3\n", "f 1//1 2//1 3//1\nf 3/1 2 1\n", "f 1//1 2//1 3\n", "f 1// 2// 3//\n"] {
        let mesh = read_obj(format!("{text}{faces}").as_bytes()).unwrap();
        assert_eq!((mesh.positions.len(), mesh.normals), (3, vec![]), "{faces}");
    }
    // A line has no normals to begin with.
    assert_eq!(read_obj(format!("{text}f 1 2\nf 1//1 2//1 3//1\n").as_bytes()).unwrap().normals, [Vec3::Z; 3]);
}

#[test]
fn a_broken_obj_names_the_line() {
    names(read_obj(b"v 0 0 0\nv 1 x 0\n"), "line 2");
    names(read_obj(b"v 0 0 0\n\n# c\nf 1 2/ 3//q\n"), "line 4");
    names(read_obj(b"v 0 0 0\nv 1 0 0\nf 1 2 3\n"), "faces");
    names(read_obj(b"v 0 0 0\nv 1 0 0\nf 1 2 -9\n"), "line 3: expected indices of v, vt and vn that are there");
    // Three times as much is no number of 64 bits.
    for index in ["-9", "9223372036854775807", "6148914691236517206", "-9223372036854775808"] {
        for text in [
            format!("vn 0 0 1\nv 0 0 0\nf 1//1 1//{index} 1//1\n"),
            format!("v 0 0 0\n\nf 1//1 1//1 1//{index}\nvn 0 0 1\n"),
        ] {
            names(read_obj(text.as_bytes()), "line 3: expected indices");
        }
    }
    names(read_obj(b"v nan 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 3\n"), "vertex 0");
    names(read_obj(b"v 0 0 0\n"), "at least one face");
}

#[test]
fn the_extension_chooses_the_reader() {
    let folder = folder();
    let path = folder.path().join("a.PLY");
    std::fs::write(&path, ascii()).unwrap();
    assert_eq!(mesh::read(&path).unwrap(), expected());
    names(mesh::read("a.stl"), ".ply, .obj");
}

/// Two triangles of a square that is cut along its diagonal, one of them with vertices of other normals.
const CHART: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt .5 0\nvt .5 1\nvt 1 1 0\nvt 0.75 0.25\nvn 0 0 2\nvn 0 1 0\n\
    f 1/1/1 2/2/1 3/3/1\nf 1/2/1 3/4/1 4/5/2\np 1\n";

#[test]
fn obj_vertices_are_split_where_the_chart_is_cut() {
    let charted = read_charted_obj(CHART.as_bytes()).unwrap();
    let corner = |face: usize| charted.mesh.faces[face].map(|v| v as usize);
    assert_eq!((corner(0), corner(1)), ([0, 1, 2], [3, 4, 5]));
    let plain = read_obj(CHART.as_bytes()).unwrap();
    for (face, &found) in charted.mesh.faces.iter().enumerate() {
        assert_eq!(charted.mesh.corners(found), plain.corners(plain.faces[face]));
    }
    let uv = [[0.0, 0.0], [0.5, 0.0], [0.5, 1.0], [0.5, 0.0], [1.0, 1.0], [0.75, 0.25]];
    assert_eq!(charted.uv, uv.map(Vec2::from));
    assert_eq!(charted.border, Border::Clamp);
    assert_eq!(charted.mesh.normals, [[Vec3::Z; 5].as_slice(), &[Vec3::Y]].concat());
    // Corners that have all in common are one vertex; without normals only the cut splits.
    let text =
        CHART.replace("/1\n", "\n").replace("/1 ", " ").replace("/2\n", "\n").replace("1/2 3/4 4/5", "1/1 3/3 4/5");
    let smooth = read_charted_obj(text.as_bytes()).unwrap();
    assert_eq!((smooth.mesh.faces, smooth.mesh.normals), (vec![[0, 1, 2], [0, 2, 3]], vec![]));
}

#[test]
fn ply_vertices_have_texture_coordinates_under_three_pairs_of_names() {
    let (first, second) = ("property float nx\n", "property float ny\n");
    for [u, v] in [["s", "t"], ["u", "v"], ["texture_u", "texture_v"]] {
        let text =
            ascii().replace(first, &format!("property float {u}\n")).replace(second, &format!("property float {v}\n"));
        let text = text.replace("2 0.5 0.5 0 0 2", "1 7 0.25 0.75 2");
        let charted = read_charted_ply(text.as_bytes()).unwrap();
        assert_eq!((charted.uv, &charted.mesh.faces), (vec![Vec2::new(0.25, 0.75); 4], &expected().faces));
        assert_eq!(read_ply(text.as_bytes()).unwrap(), charted.mesh);
    }
}

#[test]
fn meshes_without_a_chart_are_refused_with_what_to_do() {
    let expected = "expected texture coordinates (vt in f v/vt/vn of .obj, s t or u v of .ply vertices), found none; unwrap the mesh";
    let corners = "v 0 0 0\nv 1 0 0\nv 1 1 0\n";
    names(read_charted_ply(ascii().as_bytes()), expected);
    // No vt at all, vt that no face has, and faces with vt that are not there.
    for rest in ["f 1 2 3\n", "vt 0 0\nf 1 2 3\n", "vn 0 0 1\nf 1//1 2//1 3//1\n", "f 1/1 2/1 3/1\n"] {
        names(read_charted_obj(format!("{corners}{rest}").as_bytes()), expected);
    }
    let folder = folder();
    let path = folder.path().join("a.obj");
    std::fs::write(&path, CHART).unwrap();
    assert_eq!(mesh::read_charted(&path).unwrap(), read_charted_obj(CHART.as_bytes()).unwrap());
    std::fs::write(&path, format!("{corners}f 1 2 3\n")).unwrap();
    names(mesh::read_charted(&path), "a.obj: obj: vertices: expected texture coordinates");
    names(mesh::read_charted("a.stl"), ".ply, .obj");
}

#[test]
fn a_broken_chart_names_the_place() {
    let with = |from: &str, to: &str| {
        assert!(CHART.contains(from));
        read_charted_obj(CHART.replacen(from, to, 1).as_bytes())
    };
    names(
        with("1/2/1 3/4/1", "1/2/1 3//1"),
        "line 13: expected texture coordinates at every corner, as on line 12, found a corner",
    );
    names(
        with("f 1/1/1 2/2/1 3/3/1", "f 1//1 2//1 3//1"),
        "line 12: expected texture coordinates at every corner, as on line 13",
    );
    names(with("4/5/2", "4/6/2"), "faces");
    names(with("4/5/2", "4/-6/2"), "line 13: expected indices of v, vt and vn that are there, found one beyond");
    names(with("4/5/2", "4/0/2"), "line 13: expected texture coordinates at every corner");
    names(with("vt 1 1 0", "vt 1"), "line 8: expected a statement v, vn, vt or f");
    names(
        with("vt 1 1 0", "vt 1 1.25"),
        "texture coordinates of vertex 4: expected two numbers from 0 to 1, found [1, 1.25]",
    );
    names(with("vt 1 1 0", "vt nan 0"), "texture coordinates of vertex 4");
    // None of which a reader of the surface alone minds.
    assert!(read_obj(CHART.replace("vt 1 1 0", "vt 1").as_bytes()).is_ok());
}
