//! Occlusion rays per second, from every vertex of a mesh to the directions of a cubemap.
//!
//!     cargo run --release -p prt-transfer --features scene,io --example rays -- [MESH.ply] [RESOLUTION SUPERSAMPLING]
//!
//! Without a mesh: the built-in bumpy sphere. `benches/peers/visibility_embree.py` traces the same rays with Embree.

// A program may print.
#![allow(clippy::print_stdout)]

use glam::Vec3;
use prt_transfer::io;
use prt_transfer::scene::bvh::Occluders;
use prt_transfer::scene::directions::Directions;
use prt_transfer::scene::repair::repair;
use prt_transfer::scene::shapes;
use std::error::Error;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};
use std::time::Instant;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let mesh = match arguments.first() {
        Some(path) => repair(io::mesh::read(path)?)?.0,
        None => shapes::find("bumpy-sphere")?.build(18_000)?,
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
