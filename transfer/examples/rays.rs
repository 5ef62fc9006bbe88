//! Occlusion rays per second, from every vertex of a mesh to the directions of a cubemap.
//!
//!     cargo run --release --features scene --example rays [MESH.ply] [RESOLUTION SUPERSAMPLING]
//!
//! Without a mesh: a bumpy sphere. `benches/peers/visibility_embree.py` traces the same rays with Embree.

// A program may print.
#![allow(clippy::print_stdout)]

use glam::Vec3;
use prt_transfer::mesh::Mesh;
use prt_transfer::scene::bvh::Occluders;
use prt_transfer::scene::directions::Directions;
use std::error::Error;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};
use std::time::Instant;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let mesh = match arguments.first() {
        Some(path) => read_ply(path)?,
        None => bumpy_sphere(96),
    };
    let number = |place: usize, otherwise| arguments.get(place).map_or(Ok(otherwise), |text| text.parse());
    let directions = Directions::cubemap(number(1, 32)?, number(2, 2)?)?;

    let start = Instant::now();
    let occluders = Occluders::new(&mesh)?;
    let build = start.elapsed();
    println!(
        "{} vertices, {} faces, {} directions, origins lifted by {:e}",
        mesh.positions.len(),
        occluders.faces(),
        directions.count(),
        occluders.offset()
    );
    println!("build {:.1} ms", build.as_secs_f64() * 1e3);

    let points: Vec<(Vec3, Vec3)> = mesh.positions.iter().copied().zip(mesh.normals.iter().copied()).collect();
    for threads in [1, 0] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build()?;
        let mut rates = Vec::new();
        let (mut rays, mut visible) = (0, 0);
        for _ in 0..7 {
            let seen = AtomicU64::new(0);
            let start = Instant::now();
            rays = pool.install(|| {
                occluders.visible_from(&points, &directions, |_, masks| {
                    seen.fetch_add(masks.iter().map(|mask| u64::from(mask.count_ones())).sum(), Relaxed);
                })
            })?;
            rates.push(rays as f64 / start.elapsed().as_secs_f64());
            visible = seen.into_inner();
        }
        rates.sort_by(f64::total_cmp);
        println!(
            "{} threads: {:.1} M rays/s (median of 7, {:.1} to {:.1}); {rays} rays, {visible} visible",
            pool.current_num_threads(),
            rates[3] / 1e6,
            rates[0] / 1e6,
            rates[6] / 1e6
        );
    }
    Ok(())
}

/// A closed, concave surface of 4·n² triangles.
fn bumpy_sphere(n: usize) -> Mesh {
    let (rings, around) = (n, 2 * n);
    let mut mesh = Mesh::default();
    for k in 0..(rings + 1) * around {
        let theta = std::f32::consts::PI * (k / around) as f32 / rings as f32;
        let phi = std::f32::consts::TAU * (k % around) as f32 / around as f32;
        let d = Vec3::new(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos());
        mesh.positions.push(d * (1.0 + 0.15 * (7.0 * d.x).sin() * (7.0 * d.y).sin() * (7.0 * d.z).sin()));
    }
    for k in 0..rings * around {
        let (row, right) = (k / around * around, (k + 1) % around);
        let [a, b] = [k, row + right].map(|i| i as u32);
        let down = around as u32;
        mesh.faces.extend([[a, a + down, b + down], [a, b + down, b]]);
    }
    mesh.normals = vec![Vec3::ZERO; mesh.positions.len()];
    for face in &mesh.faces {
        let [a, b, c] = face.map(|i| mesh.positions[i as usize]);
        face.iter().for_each(|&i| mesh.normals[i as usize] += (b - a).cross(c - a));
    }
    mesh.normals.iter_mut().for_each(|n| *n = n.normalize_or(Vec3::Z));
    mesh
}

/// Binary little-endian PLY with x y z nx ny nz and triangles.
fn read_ply(path: &str) -> Result<Mesh, Box<dyn Error>> {
    let bytes = std::fs::read(path)?;
    let end = bytes.windows(11).position(|w| w == b"end_header\n").ok_or("no end_header")? + 11;
    let header = std::str::from_utf8(&bytes[..end])?;
    let count = |name: &str| -> Result<usize, Box<dyn Error>> {
        let line = header.lines().find_map(|line| line.strip_prefix(name)).ok_or("an element is missing")?;
        Ok(line.trim().parse()?)
    };
    let (vertices, faces) = (count("element vertex")?, count("element face")?);
    let body = &bytes[end..];
    if body.len() != vertices * 24 + faces * 13 {
        return Err("vertices must be x y z nx ny nz, faces triangles".into());
    }
    let (vertex, face) = body.split_at(vertices * 24);
    let vector =
        |b: &[u8]| Vec3::from_array([0, 4, 8].map(|i| f32::from_le_bytes([b[i], b[i + 1], b[i + 2], b[i + 3]])));
    Ok(Mesh {
        positions: vertex.chunks_exact(24).map(vector).collect(),
        normals: vertex.chunks_exact(24).map(|b| vector(&b[12..])).collect(),
        faces: face
            .chunks_exact(13)
            .map(|b| [1, 5, 9].map(|i| u32::from_le_bytes([b[i], b[i + 1], b[i + 2], b[i + 3]])))
            .collect(),
    })
}
