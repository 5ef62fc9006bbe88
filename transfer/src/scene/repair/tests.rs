use super::*;
use crate::texels::Border;
use glam::Vec2;
use proptest::prelude::*;

fn square() -> Mesh {
    Mesh {
        positions: vec![Vec3::ZERO, Vec3::X, Vec3::new(1.0, 1.0, 0.0), Vec3::Y],
        normals: vec![Vec3::Z; 4],
        faces: vec![[0, 1, 2], [0, 2, 3]],
    }
}

#[test]
fn a_sound_mesh_is_returned_bit_for_bit() {
    let (mesh, repairs) = repair(square()).unwrap();
    assert_eq!(mesh, square());
    assert_eq!(repairs.to_string(), "nothing to repair");
}

#[test]
fn every_kind_of_damage_is_counted_as_what_it_is() {
    let mut mesh = square();
    mesh.positions.extend([Vec3::splat(9.0), Vec3::new(0.5, 0.0, 0.0)]);
    mesh.normals.extend([Vec3::Z, Vec3::Z]);
    mesh.normals[1] = Vec3::Z * 2.0;
    mesh.normals[3] = Vec3::ZERO;
    // Vertex 4 belongs to no face; vertex 5 lies on the line from 0 to 1.
    mesh.faces.extend([[1, 1, 2], [0, 5, 1], [2, 0, 1], [2, 0, 3], [3, 2, 0]]);
    let (mesh, repairs) = repair(mesh).unwrap();
    let expected =
        Repairs { degenerate_faces: 2, duplicate_faces: 3, unused_vertices: 2, computed_normals: 1, scaled_normals: 1 };
    assert_eq!(repairs, expected);
    assert_eq!(mesh, square());
    assert_eq!(
        repairs.to_string(),
        "dropped 2 degenerate faces, dropped 3 duplicate faces, dropped 2 unused vertices, \
         computed 1 normal and scaled 1 normal to unit length"
    );
}

#[test]
fn vertices_that_share_a_position_stay_apart() {
    let mut mesh = square();
    mesh.positions.extend([Vec3::ZERO, Vec3::X, Vec3::Z]);
    mesh.normals.extend([Vec3::NEG_Y; 3]);
    mesh.faces.push([4, 5, 6]);
    let (kept, repairs) = repair(mesh.clone()).unwrap();
    assert_eq!((kept, repairs), (mesh.clone(), Repairs::default()));
    // Without normals, the split vertices get those of their own side.
    let normals = std::mem::take(&mut mesh.normals);
    let (computed, repairs) = repair(mesh).unwrap();
    assert_eq!((computed.normals, repairs.computed_normals), (normals, 7));
}

#[test]
fn computed_normals_do_not_depend_on_how_a_side_is_cut() {
    // A cube's corner: three squares, of which one contributes two triangles, meet under equal angles.
    let (o, x, y, z) = (Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z);
    let mesh = Mesh {
        positions: vec![o, x, y, z, x + y],
        normals: Vec::new(),
        faces: vec![[0, 4, 1], [0, 2, 4], [0, 1, 3], [0, 3, 2]],
    };
    let (mesh, _) = repair(mesh).unwrap();
    assert!((mesh.normals[0] - Vec3::splat(-1.0).normalize()).length() < 1e-6);
}

#[test]
fn a_chart_keeps_the_places_of_the_vertices_that_are_kept() {
    let mut mesh = square();
    let uv: Vec<Vec2> = mesh.positions.iter().map(|p| p.truncate()).collect();
    let sound = Charted::new(mesh.clone(), uv.clone(), Border::Clamp).unwrap();
    // A vertex of no face, before all others.
    mesh.positions.insert(0, Vec3::splat(9.0));
    mesh.normals.clear();
    mesh.faces.iter_mut().flatten().for_each(|v| *v += 1);
    let uv = [vec![Vec2::splat(0.5)], uv].concat();
    let (repaired, repairs) = Charted::new(mesh, uv, Border::Clamp).unwrap().repaired().unwrap();
    assert_eq!(repaired, sound);
    assert_eq!(repairs, Repairs { unused_vertices: 1, computed_normals: 4, ..Repairs::default() });
    let few = Charted { uv: vec![Vec2::ZERO], ..sound };
    assert!(few.repaired().unwrap_err().to_string().contains("expected 4, found 1"));
}

#[test]
fn both_sides_of_a_sheet_leave_a_unit_normal() {
    let mesh = Mesh {
        positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::new(0.0, 0.0, 1e-9)],
        normals: Vec::new(),
        faces: vec![[0, 1, 2], [3, 2, 1]],
    };
    let (mesh, _) = repair(mesh).unwrap();
    assert!(mesh.normals.iter().all(|n| n.is_normalized()));
}

#[test]
fn damage_beyond_repair_is_refused_with_its_place() {
    let refused = |change: fn(&mut Mesh)| {
        let mut mesh = square();
        change(&mut mesh);
        repair(mesh).unwrap_err().to_string()
    };
    assert!(refused(|m| m.positions[2].z = f32::INFINITY).contains("vertex 2"));
    assert!(refused(|m| m.faces[1] = [0, 7, 1]).contains("face 1: expected vertex indices below 4, found 7"));
    assert!(refused(|m| m.normals.truncate(1)).contains("expected 4, found 1"));
    assert!(refused(|m| m.faces = vec![[0, 0, 1]]).contains("dropped 1 degenerate face"));
    assert!(refused(|m| *m = Mesh::default()).contains("at least one face"));
}

proptest! {
    #[test]
    fn repairing_twice_is_repairing_once(
        cells in prop::collection::vec((0..3i8, 0..3i8, 0..2i8), 3..12),
        normals in prop::option::of(prop::collection::vec((-2..3i8, -2..3i8, -2..3i8), 12)),
        faces in prop::collection::vec((0..12u32, 0..12u32, 0..12u32), 1..20),
    ) {
        let vector = |&(x, y, z): &(i8, i8, i8)| Vec3::new(x.into(), y.into(), z.into());
        let n = cells.len();
        let mesh = Mesh {
            positions: cells.iter().map(vector).collect(),
            normals: normals.map_or(Vec::new(), |list| list[..n].iter().map(vector).collect()),
            faces: faces.iter().map(|&(a, b, c)| [a, b, c].map(|v| v % n as u32)).collect(),
        };
        if let Ok((once, _)) = repair(mesh) {
            once.check().unwrap();
            prop_assert!(once.normals.iter().all(|n| (n.length() - 1.0).abs() < 1e-4));
            let (twice, repairs) = repair(once.clone()).unwrap();
            prop_assert_eq!(repairs, Repairs::default());
            prop_assert_eq!(twice, once);
        }
    }
}
