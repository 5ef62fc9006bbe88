use super::{folder, names};
use glam::Vec3;
use prt_transfer::io::mesh::{self, read_obj, read_ply};
use prt_transfer::mesh::Mesh;

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
fn a_broken_obj_names_the_line() {
    names(read_obj(b"v 0 0 0\nv 1 x 0\n"), "line 2");
    names(read_obj(b"v 0 0 0\n\n# c\nf 1 2/ 3//q\n"), "line 4");
    names(read_obj(b"v 0 0 0\nv 1 0 0\nf 1 2 3\n"), "faces");
    names(read_obj(b"v 0 0 0\nv 1 0 0\nf 1 2 -9\n"), "faces");
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
