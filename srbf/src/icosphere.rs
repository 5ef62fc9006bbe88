//! Directions spread evenly: the vertices of a subdivided icosahedron.

use prt_transfer::basis::Direction;
use std::collections::HashMap;
use std::f64::consts::PI;

/// The numbers of vertices that are offered: 10·4^k + 2 after k subdivisions.
pub const COUNTS: [usize; 5] = [12, 42, 162, 642, 2562];

/// The unit vertices of the icosahedron whose edges have been halved, and the halves put onto the sphere, until there are
/// `count`; `None` where that is not one of [`COUNTS`].
///
/// The vertices of a coarser one come first, in the same order. With each vertex its antipode is one too.
pub fn centers(count: usize) -> Option<Vec<Direction>> {
    if !COUNTS.contains(&count) {
        return None;
    }
    let mut vertices = icosahedron();
    let mut faces = faces(&vertices);
    while vertices.len() < count {
        faces = subdivide(&mut vertices, &faces);
    }
    Some(vertices)
}

/// The least angle in rad between two of these unit directions; π where there are fewer than two.
pub fn least_angle(directions: &[Direction]) -> f64 {
    let chord = |a: &Direction, b: &Direction| (0..3).map(|i| (a[i] - b[i]).powi(2)).sum::<f64>();
    let pairs = directions.iter().enumerate().flat_map(|(i, a)| directions[..i].iter().map(move |b| chord(a, b)));
    let least = pairs.fold(4.0, f64::min);
    if least == 4.0 { PI } else { 2.0 * (0.5 * least.sqrt()).asin() }
}

/// The twelve cyclic permutations of (0, ±1, ±φ), φ the golden ratio.
fn icosahedron() -> Vec<Direction> {
    let golden = 0.5 * (1.0 + 5f64.sqrt());
    let corners = [(1.0, golden), (1.0, -golden), (-1.0, golden), (-1.0, -golden)];
    let turned = |i: usize| {
        corners.map(|(a, b)| {
            let mut vertex = [0.0; 3];
            (vertex[(i + 1) % 3], vertex[(i + 2) % 3]) = (a, b);
            unit(vertex)
        })
    };
    (0..3).flat_map(turned).collect()
}

/// Triples of vertices that are neighbours of each other, ascending.
fn faces(vertices: &[Direction]) -> Vec<[usize; 3]> {
    // Neighbours have the cosine 1/√5, the next ones -1/√5.
    let near = |i: usize, j: usize| vertices[i].iter().zip(vertices[j]).map(|(a, b)| a * b).sum::<f64>() > 0.0;
    let n = vertices.len();
    let triples = (0..n).flat_map(|i| (i + 1..n).flat_map(move |j| (j + 1..n).map(move |k| [i, j, k])));
    triples.filter(|&[i, j, k]| near(i, j) && near(j, k) && near(i, k)).collect()
}

/// Four faces of each, the middle of every edge a new vertex.
fn subdivide(vertices: &mut Vec<Direction>, faces: &[[usize; 3]]) -> Vec<[usize; 3]> {
    let mut middles = HashMap::new();
    let mut middle = |i: usize, j: usize| {
        *middles.entry([i.min(j), i.max(j)]).or_insert_with(|| {
            vertices.push(unit(std::array::from_fn(|c| vertices[i][c] + vertices[j][c])));
            vertices.len() - 1
        })
    };
    let quarters = |&[i, j, k]: &[usize; 3]| {
        let [a, b, c] = [middle(i, j), middle(j, k), middle(k, i)];
        [[i, a, c], [j, b, a], [k, c, b], [a, b, c]]
    };
    faces.iter().flat_map(quarters).collect()
}

fn unit(v: Direction) -> Direction {
    let norm = v.iter().map(|c| c * c).sum::<f64>().sqrt();
    v.map(|c| c / norm)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn centers_are_distinct_unit_directions_and_each_has_its_antipode() {
        for count in COUNTS {
            let centers = centers(count).unwrap();
            assert_eq!(centers.len(), count);
            assert!(centers.iter().all(|c| (c.iter().map(|x| x * x).sum::<f64>() - 1.0).abs() < 1e-15));
            assert!(centers.iter().all(|c| centers.contains(&c.map(|x| -x))));
        }
    }

    #[test]
    fn a_finer_set_begins_with_the_coarser_one() {
        let finest = centers(2562).unwrap();
        for count in COUNTS {
            assert_eq!(centers(count).unwrap(), finest[..count]);
        }
    }

    #[test]
    fn edges_are_of_similar_length_and_halve_from_level_to_level() {
        // Of the icosahedron they are atan 2.
        assert!((least_angle(&centers(12).unwrap()) - 2f64.atan()).abs() < 1e-12);
        for pair in COUNTS.windows(2) {
            let [coarse, fine] = [pair[0], pair[1]].map(|count| least_angle(&centers(count).unwrap()));
            assert!((0.48..0.52).contains(&(fine / coarse)), "{pair:?}: {}", fine / coarse);
        }
        for count in COUNTS {
            // A triangular lattice of n points has the spacing (8π/√3n)^½, at most.
            let even = (8.0 * PI / (3f64.sqrt() * count as f64)).sqrt();
            let share = least_angle(&centers(count).unwrap()) / even;
            assert!((0.85..=1.02).contains(&share), "{count}: {share}");
        }
    }

    #[test]
    fn their_second_moments_are_those_of_the_sphere() {
        for count in COUNTS {
            let centers = centers(count).unwrap();
            for (i, j) in [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)] {
                let mean = centers.iter().map(|c| c[i] * c[j]).sum::<f64>() / count as f64;
                assert!((mean - if i == j { 1.0 / 3.0 } else { 0.0 }).abs() < 1e-12, "{count}");
            }
        }
    }

    #[test]
    fn other_numbers_have_no_centers_and_few_directions_no_least_angle() {
        for count in [0, 1, 11, 13, 641, 10_242, usize::MAX] {
            assert_eq!(centers(count), None);
        }
        assert_eq!((least_angle(&[]), least_angle(&[[0.0, 0.0, 1.0]])), (PI, PI));
        assert_eq!(least_angle(&[[0.0, 0.0, 1.0]; 2]), 0.0);
    }
}
