//! Hostile files: whatever the bytes, a reader returns, and takes no more memory than the bytes can justify.
#![cfg(feature = "io")]

use prt_transfer::csr::Csr;
use prt_transfer::image::Image;
use prt_transfer::io::image::{Precision, exr_bytes, read_exr, read_hdr};
use prt_transfer::io::matrix::Description;
use prt_transfer::io::mesh::{read_charted_obj, read_charted_ply, read_obj, read_ply};
use prt_transfer::io::{mtx, npy, npz, prt};
use prt_transfer::transform::Identity;
use prt_transfer::{LightBasis, Quiet, Registry, Result, TransferMatrix};
use std::alloc::{GlobalAlloc, Layout, System};
use std::io::{Cursor, Write};
use std::sync::atomic::{AtomicUsize, Ordering::SeqCst};
use std::sync::{Mutex, MutexGuard, PoisonError};
use zip::write::SimpleFileOptions;

struct Counting;
static NOW: AtomicUsize = AtomicUsize::new(0);
static PEAK: AtomicUsize = AtomicUsize::new(0);
static ONE_AT_A_TIME: Mutex<()> = Mutex::new(());

// SAFETY: every call goes to the system's allocator unchanged.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        PEAK.fetch_max(NOW.fetch_add(layout.size(), SeqCst) + layout.size(), SeqCst);
        // SAFETY: the caller's promises are passed on.
        unsafe { System.alloc(layout) }
    }
    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        PEAK.fetch_max(NOW.fetch_add(layout.size(), SeqCst) + layout.size(), SeqCst);
        // SAFETY: as above; without this, images of zeros would really be filled.
        unsafe { System.alloc_zeroed(layout) }
    }
    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        NOW.fetch_sub(layout.size(), SeqCst);
        // SAFETY: as above.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

const KIB: usize = 1 << 10;
const MIB: usize = 1 << 20;
/// What an image may take whatever the length of its file: the pixels three times over.
const IMAGE: usize = 3 * 64 * MIB;

/// Held by each test from its first line on: the count is the whole process's.
fn alone() -> MutexGuard<'static, ()> {
    ONE_AT_A_TIME.lock().unwrap_or_else(PoisonError::into_inner)
}

/// What `read` returned; its memory must stay below `limit`.
fn within<T>(limit: usize, read: impl FnOnce() -> Result<T>) -> Result<T> {
    let before = NOW.load(SeqCst);
    PEAK.store(before, SeqCst);
    let result = read();
    let peak = PEAK.load(SeqCst).saturating_sub(before);
    assert!(peak <= limit, "{peak} bytes for at most {limit}");
    result
}

/// Every truncation and every flip of one bit; truncations must fail unless `short` says that they may not.
fn torture<T>(file: &[u8], limit: usize, short_is_fine: fn(&[u8]) -> bool, read: impl Fn(&[u8]) -> Result<T>) {
    assert!(within(limit, || read(file)).is_ok());
    for length in 0..file.len() {
        let result = within(limit, || read(&file[..length]));
        assert!(result.is_err() || short_is_fine(&file[length..]), "cut at {length} of {}", file.len());
    }
    let mut bytes = file.to_vec();
    for bit in 0..8 * file.len() {
        bytes[bit / 8] ^= 1 << (bit % 8);
        let _ = within(limit, || read(&bytes));
        bytes[bit / 8] ^= 1 << (bit % 8);
    }
}

fn never(_: &[u8]) -> bool {
    false
}
fn blank(rest: &[u8]) -> bool {
    rest.iter().all(u8::is_ascii_whitespace)
}

fn matrix() -> TransferMatrix {
    let columns = vec![0, 3, 1, 2, 3, 5];
    let values = vec![0.5, 1.0, -2.0, 0.25, 3.0, 7.0];
    TransferMatrix::from_csr(vec![0, 2, 2, 5, 6], columns, values, 2, LightBasis::Cubemap { resolution: 1 }).unwrap()
}

fn registry() -> Registry {
    Registry::new().transform::<Identity>().codec::<Csr>()
}

fn read_npz(bytes: &[u8]) -> Result<()> {
    npz::read_from(Cursor::new(bytes), &Description::default()).map(drop)
}
fn read_npy(bytes: &[u8]) -> Result<()> {
    npy::read_from(Cursor::new(bytes), &Description::default()).map(drop)
}
fn read_mtx(bytes: &[u8]) -> Result<()> {
    mtx::read_from(bytes, &Description::default()).map(drop)
}

#[test]
fn npz() {
    let _alone = alone();
    torture(&npz::to_bytes(&matrix(), "test").unwrap(), 300 * KIB, never, read_npz);
}

#[test]
fn npy() {
    let _alone = alone();
    let header = "{'descr': '<f8', 'fortran_order': True, 'shape': (2, 2, 3), }\n";
    let mut file = b"\x93NUMPY\x01\x00".to_vec();
    file.extend((header.len() as u16).to_le_bytes());
    file.extend(header.as_bytes());
    (0..12).for_each(|i| file.extend(f64::from(i).to_le_bytes()));
    torture(&file, 200 * KIB, never, read_npy);
}

#[test]
fn mtx() {
    let _alone = alone();
    let text = "%%MatrixMarket matrix coordinate real symmetric\n% c\n4 4 3\n1 1 0.5\n3 2 -1e3\n4 4 7.\n";
    // Cutting digits off the last number leaves another number.
    torture(text.as_bytes(), 20 * MIB, |rest| rest.len() <= 2, read_mtx);
    let text = "%%MatrixMarket matrix array integer general\n2 2\n1\n2\n3\n4\n";
    torture(text.as_bytes(), 20 * MIB, blank, read_mtx);
}

#[test]
fn prt() {
    let _alone = alone();
    let method = registry().method(&"csr".parse().unwrap()).unwrap();
    let file = prt::to_bytes(&method.encode(&matrix(), &Quiet).unwrap(), &Quiet).unwrap();
    torture(&file, MIB, never, |bytes| prt::from_bytes(bytes, &registry()));
    torture(include_bytes!("golden/csr-1.prt"), 4 * MIB, never, |bytes| prt::from_bytes(bytes, &registry()));
}

#[test]
fn ply() {
    let _alone = alone();
    let elements = "element vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement face 1\n\
                    property list uchar int vertex_indices\nend_header\n";
    let ascii = format!("ply\nformat ascii 1.0\n{elements}0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n");
    torture(ascii.as_bytes(), 64 * KIB, blank, read_ply);
    let mut binary = format!("ply\nformat binary_big_endian 1.0\n{elements}").into_bytes();
    [0f32, 0., 0., 1., 0., 0., 0., 1., 0.].iter().for_each(|v| binary.extend(v.to_be_bytes()));
    binary.push(3);
    [0i32, 1, 2].iter().for_each(|v| binary.extend(v.to_be_bytes()));
    torture(&binary, 64 * KIB, never, read_ply);
}

#[test]
fn obj() {
    let _alone = alone();
    let text = "v 0 0 0\nv 1 0 0\nv 1 1 0\nvn 0 0 1\nf 1//1 2//1 -1//1\n";
    // Nothing says how long an .obj is: a cut may leave fewer statements, or other numbers.
    torture(text.as_bytes(), 64 * KIB, |_| true, read_obj);
}

#[test]
fn charts() {
    let _alone = alone();
    let text = "v 0 0 0\nv 1 0 0\nv 1 1 0\nvn 0 0 1\nvt 0 0\nvt 1 0\nvt .5 1\nf 1/1/1 2/2/1 -1/-1/1\n";
    torture(text.as_bytes(), 64 * KIB, |_| true, read_charted_obj);
    let text = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
                property float s\nproperty float t\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n\
                0 0 0 0 0\n1 0 0 1 0\n0 1 0 0 1\n3 0 1 2\n";
    torture(text.as_bytes(), 64 * KIB, blank, read_charted_ply);
}

#[test]
fn hdr() {
    let _alone = alone();
    let line = [2, 2, 0, 8, 136, 5, 8, 1, 2, 3, 4, 5, 6, 7, 8, 136, 9, 136, 130];
    let file = [b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2 +X 8\n".as_slice(), &line, &line].concat();
    torture(&file, IMAGE, never, read_hdr);
}

#[test]
fn exr() {
    let _alone = alone();
    let pixel = |i: usize| [i as f32, 0.5, (i * i) as f32];
    let image = Image { width: 5, height: 18, pixels: (0..90).map(pixel).collect() };
    for precision in [Precision::Half, Precision::Single] {
        torture(&exr_bytes(&image, precision).unwrap(), IMAGE, never, read_exr);
    }
}

/// An archive whose arrays have the given header and data.
fn archive(arrays: &[(&str, &str, &str, Vec<u8>)]) -> Vec<u8> {
    let mut archive = zip::ZipWriter::new(Cursor::new(Vec::new()));
    let options = SimpleFileOptions::default().compression_method(zip::CompressionMethod::Deflated);
    for (name, descr, shape, data) in arrays {
        let header = format!("{{'descr': '{descr}', 'fortran_order': False, 'shape': {shape}}}\n");
        archive.start_file(*name, options).unwrap();
        archive.write_all(b"\x93NUMPY\x01\x00").unwrap();
        archive.write_all(&(header.len() as u16).to_le_bytes()).unwrap();
        archive.write_all(header.as_bytes()).unwrap();
        archive.write_all(data).unwrap();
    }
    archive.finish().unwrap().into_inner()
}

#[test]
fn sizes_that_the_bytes_do_not_earn_are_refused() {
    let _alone = alone();
    let refused = |limit: usize, result: &dyn Fn() -> Result<()>| assert!(within(limit, result).is_err());

    // .npy: 2^60 rows, a product that wraps, a header of 4 GiB, a billion rows of nothing.
    let npy = |shape: &str| {
        let header = format!("{{'descr': '<f4', 'fortran_order': False, 'shape': {shape}}}\n");
        [b"\x93NUMPY\x01\x00", &(header.len() as u16).to_le_bytes()[..], header.as_bytes(), &[0; 64]].concat()
    };
    for shape in ["(1152921504606846976, 4)", "(4294967296, 4294967296)", "(1000000000, 16)", "(1000000000000, 0)"] {
        refused(200 * KIB, &|| read_npy(&npy(shape)));
    }
    refused(64 * KIB, &|| read_npy(b"\x93NUMPY\x02\x00\xff\xff\xff\xff{"));

    // .npz: rows and elements that are claimed, and a megabyte of zeros where a thousand times as many are announced.
    let entries = |rows: &str, elements: &str, data: Vec<u8>| {
        let shape = [4i64, 6].iter().flat_map(|n| n.to_le_bytes()).collect();
        archive(&[
            ("format.npy", "|S3", "()", b"csr".to_vec()),
            ("shape.npy", "<i8", "(2,)", shape),
            ("indptr.npy", "<i4", rows, vec![0; 20]),
            ("indices.npy", "<i4", elements, data.clone()),
            ("data.npy", "<f4", elements, data),
        ])
    };
    for (limit, file) in [
        (300 * KIB, entries("(1152921504606846976,)", "(0,)", vec![])),
        (300 * KIB, entries("(5,)", "(1152921504606846976,)", vec![])),
        (4 * MIB, entries("(5,)", "(268435456,)", vec![0; MIB])),
    ] {
        refused(limit, &|| read_npz(&file));
    }

    // .npz coordinates: a table of 2^60 empty rows for one element.
    let wide: Vec<u8> = [1i64 << 60, 6].iter().flat_map(|n| n.to_le_bytes()).collect();
    let coordinates = archive(&[
        ("format.npy", "|S3", "()", b"coo".to_vec()),
        ("shape.npy", "<i8", "(2,)", wide),
        ("row.npy", "<i4", "(1,)", vec![0; 4]),
        ("col.npy", "<i4", "(1,)", vec![0; 4]),
        ("data.npy", "<f4", "(1,)", vec![0; 4]),
    ]);
    refused(300 * KIB, &|| read_npz(&coordinates));

    // .mtx: elements, rows and columns without end.
    for sizes in ["4 4 1000000000000000000\n1 1 1", "1000000000000000000 4 1\n1 1 1", "4 1000000000000000000 1\n1 1 1"]
    {
        refused(64 * KIB, &|| read_mtx(format!("%%MatrixMarket matrix coordinate real general\n{sizes}\n").as_bytes()));
    }
    refused(64 * KIB, &|| read_mtx(b"%%MatrixMarket matrix array real general\n1000000000 1000\n1\n"));

    // .ply: vertices, corners of one face, and elements without properties, which take no bytes at all.
    let ply = |vertices: &str, body: &str| {
        format!(
            "ply\nformat ascii 1.0\nelement vertex {vertices}\nproperty float x\nproperty float y\nproperty float z\n\
             element nothing 18446744073709551615\nelement face 1\nproperty list uint int vertex_indices\nend_header\n{body}"
        )
    };
    for text in [ply("4000000000", "0 0 0\n"), ply("1", "0 0 0\n4000000000 0 0 0\n")] {
        refused(64 * KIB, &|| read_ply(text.as_bytes()).map(drop));
    }

    // .hdr: a scan line of 2^31 pixels from one repeat, sides whose product wraps.
    for size in ["-Y 1 +X 2147483648", "-Y 4294967296 +X 4294967297", "-Y 100000 +X 100000"] {
        let text = format!("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n{size}\n");
        let file = [text.as_bytes(), &[9, 9, 9, 128, 1, 1, 1, 255, 1, 1, 1, 255, 1, 1, 1, 255]].concat();
        refused(64 * KIB, &|| read_hdr(&file).map(drop));
    }

    // .exr: a data window of 2^30 x 2^30.
    let image = Image { width: 2, height: 2, pixels: vec![[1.0; 3]; 4] };
    let mut exr = exr_bytes(&image, Precision::Single).unwrap();
    let at = exr.windows(10).position(|w| w == b"dataWindow").unwrap();
    let window = exr[at..].windows(5).position(|w| w == b"box2i").unwrap() + at + 6 + 4;
    for corner in [8, 12] {
        exr[window + corner..][..4].copy_from_slice(&(1i32 << 29).to_le_bytes());
    }
    refused(MIB, &|| read_exr(&exr).map(drop));
}

/// A section that claims more than a thousand times its bytes, in a header whose checksum is right.
#[test]
fn a_section_cannot_claim_what_its_bytes_do_not_earn() {
    let _alone = alone();
    let golden = include_bytes!("golden/csr-1.prt");
    let end = 16 + u32::from_le_bytes(golden[12..16].try_into().unwrap()) as usize;
    let at = golden.windows(13).position(|w| w == b"index/columns").unwrap() + 14;
    for claim in [u64::MAX, 1 << 60, 1 << 30, 1 << 20] {
        let mut bytes = golden.to_vec();
        bytes[at..at + 8].copy_from_slice(&claim.to_le_bytes());
        let crc = crc32fast::hash(&bytes[..end - 4]);
        bytes[end - 4..end].copy_from_slice(&crc.to_le_bytes());
        assert!(within(2 * MIB, || prt::from_bytes(&bytes, &registry())).is_err());
    }
}
