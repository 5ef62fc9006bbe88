use super::*;
use crate::mesh::Mesh;
use crate::random::Random;
use crate::texels::Border;
use glam::{Vec2, Vec3};
use proptest::prelude::*;

/// A chart over points of the square, flat in space with corners of the same coordinates.
fn flat(uv: &[[f32; 2]], faces: &[[u32; 3]]) -> Charted {
    let uv: Vec<Vec2> = uv.iter().map(|&uv| uv.into()).collect();
    let positions = uv.iter().map(|uv| uv.extend(0.0)).collect();
    Charted::new(Mesh { positions, normals: Vec::new(), faces: faces.to_vec() }, uv, Border::Clamp).unwrap()
}

/// The square cut into triangles at random: each is cut in three at a point inside, or with its neighbour in two at an edge.
fn triangulation(seed: u64, cuts: usize, denominator: usize) -> Charted {
    let mut random = Random(seed);
    let mut uv: Vec<[f32; 2]> = vec![[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    let mut faces = vec![[0, 1, 2], [0, 2, 3]];
    for _ in 0..cuts {
        // Points on a coarse lattice are often on edges and at centres of texels.
        let [x, y] = [0, 1].map(|_| random.below(denominator + 1) as f32 / denominator as f32);
        if uv.contains(&[x, y]) {
            continue;
        }
        let p = uv.len() as u32;
        uv.push([x, y]);
        let point = |v: u32| robust::Coord { x: uv[v as usize][0], y: uv[v as usize][1] };
        let side = |a: u32, b: u32| robust::orient2d(point(a), point(b), point(p));
        let mut cut = Vec::new();
        for [a, b, c] in faces {
            let sides = [side(a, b), side(b, c), side(c, a)];
            if sides.iter().any(|&s| s < 0.0) {
                cut.push([a, b, c]);
                continue;
            }
            let parts = [[a, b, p], [b, c, p], [c, a, p]];
            cut.extend(parts.into_iter().zip(sides).filter(|&(_, s)| s > 0.0).map(|(part, _)| part));
        }
        faces = cut;
    }
    // In any order, from any corner, half of them mirrored.
    for i in (1..faces.len()).rev() {
        faces.swap(i, random.below(i + 1));
        faces[i].rotate_left(random.below(3));
    }
    if random.below(2) == 0 {
        uv.iter_mut().for_each(|uv| uv[0] = 1.0 - uv[0]);
    }
    flat(&uv, &faces)
}

proptest! {
    /// Second way: every face is asked for every texel.
    #[test]
    fn triangulations_of_the_square_give_each_texel_the_first_face_around_its_centre(
        seed: u64, cuts in 0usize..60, power in 1u32..7, width in 1usize..33, height in 1usize..33,
    ) {
        let charted = triangulation(seed, cuts, 1 << power);
        let places = charted.places(width, height).unwrap();
        prop_assert_eq!((places.gutter, places.flat), (0, 0));
        let triangles: Vec<Triangle> =
            (0..charted.mesh.faces.len() as u32).map(|f| Triangle::new(&charted, f, [width, height]).unwrap()).collect();
        for (texel, place) in places.places.iter().enumerate() {
            let place = place.unwrap();
            let centre = DVec2::new((texel % width) as f64, (texel / width) as f64) + 0.5;
            let around: Vec<u32> =
                triangles.iter().filter(|t| t.weights(centre).iter().all(|&w| w >= 0.0)).map(|t| t.face).collect();
            prop_assert_eq!(around.first(), Some(&place.face));
            let strictly = triangles.iter().filter(|t| t.depth(centre) > 0.0).count();
            prop_assert!(strictly == 1 || (strictly == 0 && around.len() > 1));
            let uv = charted.uv_at(place.face, place.u, place.v);
            prop_assert!(uv.as_dvec2().distance(DVec2::from(places.texels.centre(texel))) < 1e-5);
        }
    }

    /// Second way: distances from finely sampled faces.
    #[test]
    fn the_gutter_is_what_lookups_touch_and_has_the_nearest_places(
        seed: u64, width in 2usize..14, height in 2usize..14, border in 0usize..3,
    ) {
        let mut random = Random(seed);
        let corner = |random: &mut Random| [0, 1].map(|_| random.uniform() as f32);
        let uv = [corner(&mut random), corner(&mut random), corner(&mut random)];
        let charted = Charted { border: [Border::Clamp, Border::Wrap, Border::Octahedral][border], ..flat(&uv, &[[0, 1, 2]]) };
        let Ok(places) = charted.places(width, height) else { return Ok(()) };
        let owned = |p: DVec2| Triangle::new(&charted, 0, [width, height]).unwrap().depth(p) >= 0.0;
        let steps = 200;
        let samples: Vec<Vec2> = (0..=steps)
            .flat_map(|i| (0..=steps - i).map(move |j| [i, j].map(|k| k as f32 / steps as f32)))
            .map(|[u, v]| charted.uv_at(0, u, v))
            .collect();
        let mut touched = vec![false; width * height];
        for &uv in &samples {
            for (texel, weight) in places.texels.taps(uv.to_array()) {
                touched[texel as usize] |= weight > 1e-4;
            }
        }
        let mut gutter = 0;
        let size = Vec2::new(width as f32, height as f32);
        for (texel, place) in places.places.iter().enumerate() {
            prop_assert!(place.is_some() || !touched[texel], "{texel}");
            let centre = DVec2::new((texel % width) as f64, (texel / width) as f64) + 0.5;
            if owned(centre) {
                continue;
            }
            let Some(place) = place else { continue };
            gutter += 1;
            if border == 0 {
                let centre = centre.as_vec2();
                let nearest = samples.iter().map(|&uv| (uv * size).distance(centre)).fold(f32::INFINITY, f32::min);
                let found = (charted.uv_at(0, place.u, place.v) * size).distance(centre);
                prop_assert!(found < 1.4143 && found <= nearest + 1e-4, "{found} {nearest}");
            }
        }
        prop_assert_eq!(gutter, places.gutter);
    }
}

#[test]
fn charts_that_overlap_are_refused_with_the_texel_and_the_faces() {
    let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0], [0.4, 0.4]];
    let refused = flat(&corners, &[[0, 1, 2], [0, 2, 3], [4, 2, 1]]).places(4, 4).unwrap_err().to_string();
    assert_eq!(refused, "chart: texel 3, 0 of 4 x 4: expected charts that do not overlap, found faces 0 and 2");
    // Mirrored halves on one chart.
    assert!(flat(&corners, &[[0, 1, 2], [2, 1, 0]]).places(4, 4).is_err());
    // Two charts that meet on centres of texels: what both have of each other is rounding up to a hundredth of a texel.
    let meeting = |overlap: f32| {
        let (left, right) = (0.5 - overlap, 0.5 + overlap);
        let corners = [0.0, right, left, 1.0].map(|x| [[x, 0.0], [x, 1.0]]).concat();
        flat(&corners, &[[0, 2, 3], [0, 3, 1], [4, 6, 7], [4, 7, 5]]).places(5, 5)
    };
    assert!(meeting(1e-3).unwrap().places.iter().all(Option::is_some));
    assert!(meeting(3e-3).unwrap_err().to_string().contains("texel 2, 0"));
}

#[test]
fn faces_without_area_are_refused_where_they_have_texels_and_passed_over_where_they_have_none() {
    let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    let mut charted = flat(&corners, &[[0, 2, 3], [0, 1, 2], [0, 1, 1]]);
    assert_eq!(charted.places(4, 4).unwrap().flat, 1);
    // The second face is a line in space; it also has the centres on the diagonal, which are the first's.
    charted.mesh.positions[1] = Vec3::new(0.5, 0.5, 0.0);
    let refused = charted.places(4, 4).unwrap_err().to_string();
    assert_eq!(refused, "chart: face 1, texel 1, 0 of 4 x 4: expected triangles with an area, found none");
    charted.mesh.faces.swap(0, 1);
    assert!(charted.places(4, 4).unwrap_err().to_string().contains("face 0, texel 1, 0"));
    // Only the diagonal: no texel of its own.
    assert!(charted.places(1, 1).unwrap().places[0].is_some_and(|place| place.face == 1));
}

#[test]
fn charts_without_texels_and_grids_without_end_are_refused() {
    let small = flat(&[[0.0, 0.0], [0.1, 0.0], [0.0, 0.1]], &[[0, 1, 2], [0, 0, 1]]);
    let refused = small.places(2, 2).unwrap_err().to_string();
    let expected = "chart of 2 x 2 texels: expected the centre of a texel in a face, found none in 2 faces, 1 of them without \
                    area in the chart";
    assert_eq!(refused, expected);
    assert_eq!(small.places(20, 20).unwrap().flat, 1);
    for sides in [[0, 4], [4, 0], [MAX_SIDE + 1, 1]] {
        assert!(small.places(sides[0], sides[1]).unwrap_err().to_string().contains("from 1 to 32768"));
    }
    let broken = Charted { uv: vec![Vec2::NAN; 3], ..small };
    assert!(broken.places(2, 2).unwrap_err().to_string().contains("vertex 0"));
}

#[test]
fn the_gutter_of_a_chart_in_the_middle_is_one_texel_wide() {
    // Two by two of six by six texels.
    let (low, high) = (1.0 / 3.0, 2.0 / 3.0);
    let chart = flat(&[[low, low], [high, low], [high, high], [low, high]], &[[0, 1, 2], [0, 2, 3]]);
    let places = chart.places(6, 6).unwrap();
    assert_eq!((places.gutter, places.places.iter().flatten().count()), (12, 16));
    // The nearest place of a corner is the chart's.
    let corner = places.places[7].unwrap();
    assert!(chart.uv_at(corner.face, corner.u, corner.v).distance(Vec2::splat(low)) < 1e-6);
}
