//! FLIP of two images of linear radiance, developed alike, and how long that takes.
//!
//!     cargo run --release -p prt-transfer --features io --example flip -- REFERENCE.exr TEST.exr OUT [STOPS]
//!
//! Writes OUT/reference.png, OUT/test.png and OUT/map.npy, height x width, which `benches/peers/flip_reference.py` compares with the map of the
//! authors' implementation.

// A program may print.
#![allow(clippy::print_stdout)]

use ndarray::Array2;
use prt_transfer::image::flip::{PIXELS_PER_DEGREE, Perceived};
use prt_transfer::image::{Flip, Picture, Tone};
use prt_transfer::io;
use std::error::Error;
use std::path::Path;
use std::time::Instant;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [reference, test, out, stops @ ..] = &arguments[..] else {
        return Err("expected REFERENCE.exr TEST.exr OUT [STOPS]".into());
    };
    let reference = io::image::read(reference)?;
    let stops = stops.first().map_or_else(
        || reference.automatic_exposure(&vec![1.0; reference.pixels.len()]).map_err(Box::<dyn Error>::from),
        |s| Ok(s.parse()?),
    )?;
    let [reference, test] = [reference, io::image::read(test)?].map(|image| image.develop(stops, Tone::Clip));
    let flip = test.flip(&reference)?;
    for threads in [1, 0] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build()?;
        let time = |work: &(dyn Fn() -> prt_transfer::Result<Flip> + Sync)| -> Result<f64, Box<dyn Error>> {
            let mut times = Vec::new();
            for _ in 0..9 {
                let start = Instant::now();
                pool.install(work)?;
                times.push(start.elapsed().as_secs_f64() * 1e3);
            }
            times.sort_by(f64::total_cmp);
            Ok(times[4])
        };
        let perceived = Perceived::new(&reference, PIXELS_PER_DEGREE)?;
        let both = time(&|| test.flip(&reference))?;
        let one = time(&|| Perceived::new(&test, PIXELS_PER_DEGREE)?.flip(&perceived))?;
        let threads = pool.current_num_threads();
        println!(
            "{threads} threads: {both:.2} ms of two pictures, {one:.2} ms of one beside a known reference (medians of 9)"
        );
    }
    let Picture { width, height, .. } = reference;
    println!("{width} x {height}, mean {:.6}", flip.mean);
    let out = Path::new(out);
    std::fs::create_dir_all(out)?;
    io::image::write_png(out.join("reference.png"), &reference)?;
    io::image::write_png(out.join("test.png"), &test)?;
    io::npy::write_array(out.join("map.npy"), Array2::from_shape_vec((height, width), flip.map)?.view())?;
    Ok(())
}
