//! Writes the seeds of a reader, each to a file of a folder: `seeds READER FOLDER`.

use prt_tests::hostile::reader;
use std::path::PathBuf;

fn main() -> std::io::Result<()> {
    let [name, folder] = [1, 2].map(|i| std::env::args().nth(i).expect("seeds READER FOLDER"));
    let folder = PathBuf::from(folder);
    std::fs::create_dir_all(&folder)?;
    let seeds = (reader(&name).seeds)();
    seeds.iter().enumerate().try_for_each(|(i, seed)| std::fs::write(folder.join(format!("seed-{i}")), seed))
}
