use super::{folder, names};
use prt_transfer::csr::Csr;
use prt_transfer::io::prt::{self, Encoding, MAX_NAME, MAX_SECTIONS};
use prt_transfer::matrix::Layout;
use prt_transfer::method::Header;
use prt_transfer::transform::Identity;
use prt_transfer::{Compressed, LightBasis, Quiet, Registry, Section, TransferMatrix};

const GOLDEN: &[u8] = include_bytes!("../golden/csr-1.prt");

fn registry() -> Registry {
    Registry::new().transform::<Identity>().codec::<Csr>()
}

/// 60 samples x 2 responses over 24 texels: row r holds (r mod 5) / 4 in columns r, r + 7, r + 14 (mod 24), none in
/// every fifth row.
fn matrix() -> TransferMatrix {
    matrix_of(2)
}

/// The same with other numbers of responses, divisors of 120.
fn matrix_of(responses: usize) -> TransferMatrix {
    let (mut offsets, mut columns, mut values) = (vec![0], Vec::new(), Vec::new());
    for row in 0..120u32 {
        let mut own: Vec<u32> = (0..3).map(|k| (row + 7 * k) % 24).collect();
        own.sort_unstable();
        if row % 5 != 0 {
            columns.extend(own);
            values.extend([(row % 5) as f32 / 4.0; 3]);
        }
        offsets.push(columns.len());
    }
    TransferMatrix::from_csr(offsets, columns, values, responses, LightBasis::Cubemap { resolution: 2 }).unwrap()
}

fn compress(matrix: &TransferMatrix) -> Compressed {
    registry().method(&"csr".parse().unwrap()).unwrap().encode(matrix, &Quiet).unwrap()
}

fn rows(compressed: &Compressed) -> Vec<Vec<f32>> {
    let shape = compressed.shape();
    let row = |r| {
        let mut out = vec![0.0; shape.lights];
        compressed.row_into(r, &mut out);
        out
    };
    (0..shape.rows()).map(row).collect()
}

/// The promise to old files: version 1 as it was first written reads to the very same matrix, for ever.
#[test]
fn the_golden_file_of_version_1_still_reads() {
    let read = prt::from_bytes(GOLDEN, &registry()).unwrap();
    let matrix = matrix();
    assert_eq!(read.header(), compress(&matrix).header());
    let mut expected = vec![0.0; 24];
    for (row, found) in rows(&read).iter().enumerate() {
        matrix.gather(row, &mut expected);
        assert_eq!(*found, expected, "row {row}");
    }
}

/// What is written today has the golden file's header fields and raw sections. Stored bytes may differ where zstd's
/// version does. To make the file anew after a deliberate change of version: `PRT_WRITE_GOLDEN=1 cargo test golden`.
#[test]
fn what_is_written_agrees_with_the_golden_file() {
    let bytes = prt::to_bytes(&compress(&matrix()), &Quiet).unwrap();
    if std::env::var_os("PRT_WRITE_GOLDEN").is_some() {
        std::fs::write(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/golden/csr-1.prt"), &bytes).unwrap();
    }
    assert_eq!(prt::unpack(&bytes).unwrap(), prt::unpack(GOLDEN).unwrap());
    let raw = |bytes| {
        let sections = prt::inspect(bytes).unwrap().sections;
        sections.into_iter().map(|s| (s.name, s.raw, s.crc)).collect::<Vec<_>>()
    };
    assert_eq!(raw(&bytes), raw(GOLDEN));
}

/// What version 1 cannot say makes a version 2; everything else stays a version 1.
#[test]
fn the_meaning_of_responses_comes_back_and_is_what_raises_the_version() {
    let version = |bytes: &[u8]| u32::from_le_bytes(bytes[8..12].try_into().unwrap());
    assert_eq!(version(&prt::to_bytes(&compress(&matrix()), &Quiet).unwrap()), 1);
    for text in ["exit-orthonormal:3", "terms:3:lambert:albedo=0.5"] {
        let known = matrix_of(3).with_responses(text.parse().unwrap()).unwrap();
        let bytes = prt::to_bytes(&compress(&known), &Quiet).unwrap();
        assert_eq!(version(&bytes), 2);
        let read = prt::from_bytes(&bytes, &registry()).unwrap();
        assert_eq!(read.responses().to_string(), text);
        assert_eq!(read.header(), compress(&known).header());
    }
}

/// The layout of docs/format.md, followed by hand.
#[test]
fn the_documented_offsets_hold() {
    let u16_at = |at: usize| u16::from_le_bytes(GOLDEN[at..at + 2].try_into().unwrap()) as usize;
    let u32_at = |at: usize| u32::from_le_bytes(GOLDEN[at..at + 4].try_into().unwrap());
    let u64_at = |at: usize| u64::from_le_bytes(GOLDEN[at..at + 8].try_into().unwrap());
    assert_eq!(GOLDEN[..8], *b"\x89PRT\r\n\x1a\n");
    assert_eq!(u32_at(8), 1);
    let end = 16 + u32_at(12) as usize;
    assert_eq!(u32_at(end - 4), crc32fast::hash(&GOLDEN[..end - 4]));
    let mut at = 16;
    let mut text = || {
        let length = u16_at(at);
        at += 2 + length;
        std::str::from_utf8(&GOLDEN[at - length..at]).unwrap()
    };
    assert_eq!((text(), text()), ("csr", "csr.1"));
    assert_eq!([u64_at(at), u64_at(at + 8), u64_at(at + 16)], [60, 2, 24]);
    at += 24;
    let length = u16_at(at);
    assert_eq!(GOLDEN[at + 2..at + 2 + length], *b"cubemap:2");
    at += 2 + length;
    assert_eq!((GOLDEN[at], u16_at(at + 1)), (0, 3));
    at += 3;
    let mut payload = end;
    for (name, raw) in [("index/offsets", 8 * 121), ("index/columns", 4 * 288), ("weights/values", 4 * 288)] {
        let length = GOLDEN[at] as usize;
        assert_eq!(GOLDEN[at + 1..at + 1 + length], *name.as_bytes());
        at += 1 + length;
        let (encoding, stored) = (GOLDEN[at], u64_at(at + 9) as usize);
        assert_eq!((encoding, u64_at(at + 1)), (1, raw));
        let bytes = zstd::bulk::decompress(&GOLDEN[payload..payload + stored], raw as usize).unwrap();
        assert_eq!(u32_at(at + 17), crc32fast::hash(&bytes));
        at += 21;
        payload += stored;
    }
    assert_eq!((at, payload), (end - 4, GOLDEN.len()));
}

#[test]
fn sizes_come_from_the_file_and_saving_again_gives_the_same_bytes() {
    let folder = folder();
    let (first, second) = (folder.path().join("a.prt"), folder.path().join("b.prt"));
    let sizes = prt::write(&first, &compress(&matrix()), &Quiet).unwrap();
    let read = prt::read(&first, &registry()).unwrap();
    assert_eq!(prt::write(&second, &read, &Quiet).unwrap(), sizes);
    let bytes = std::fs::read(&first).unwrap();
    assert_eq!(bytes, std::fs::read(&second).unwrap());
    assert_eq!(sizes.file, bytes.len() as u64);
    assert_eq!(sizes.raw, read.sections().resident_bytes() as u64);
    let stored: u64 = prt::inspect(&bytes).unwrap().sections.iter().map(|s| s.stored).sum();
    assert_eq!(sizes.file, sizes.header + stored);
    names(prt::read(folder.path().join("c.prt"), &registry()), "c.prt");
}

#[test]
fn the_file_is_the_same_on_any_number_of_threads() {
    let compressed = compress(&matrix());
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| prt::to_bytes(&compressed, &Quiet).unwrap())
    };
    assert_eq!(on(1), on(2));
}

fn header() -> Header {
    compress(&matrix()).header()
}

fn section(name: &str, bytes: Vec<u8>) -> Section {
    Section { name: name.into(), bytes }
}

#[test]
fn a_section_is_stored_in_the_smaller_form_and_reads_back() {
    let noise: Vec<u8> = (0..5000u32).map(|i| (i.wrapping_mul(2654435761) >> 13) as u8 ^ (i * i) as u8).collect();
    let sections = vec![
        section("index/empty", vec![]),
        section("weights/noise", noise[..300].to_vec()),
        section("weights/same", vec![7; 3 << 20]),
    ];
    let bytes = prt::pack(&header(), sections.clone(), &Quiet).unwrap();
    let infos = prt::inspect(&bytes).unwrap().sections;
    let encodings: Vec<Encoding> = infos.iter().map(|s| s.encoding).collect();
    assert_eq!(encodings, [Encoding::Raw, Encoding::Raw, Encoding::Zstd]);
    // Three megabytes of one value need a hundred bytes, but a file must be worth a thousandth of what it claims.
    assert!(infos[2].stored >= infos[2].raw / 1000 - 66 && infos[2].stored <= infos[2].raw / 1000 + 8);
    let (header_read, read) = prt::unpack(&bytes).unwrap();
    assert_eq!((header_read, read), (header(), sections));
}

#[test]
fn limits_of_the_format_are_said_when_writing() {
    let many = |n: usize| (0..n).map(|i| section(&i.to_string(), vec![])).collect::<Vec<_>>();
    assert!(prt::pack(&header(), many(MAX_SECTIONS), &Quiet).is_ok());
    names(prt::pack(&header(), many(MAX_SECTIONS + 1), &Quiet), "sections");
    assert!(prt::pack(&header(), vec![section(&"x".repeat(MAX_NAME), vec![])], &Quiet).is_ok());
    names(prt::pack(&header(), vec![section(&"x".repeat(MAX_NAME + 1), vec![])], &Quiet), "name");
}

#[test]
fn every_layout_and_basis_survives() {
    for layout in [Layout::Sparse, Layout::Rows, Layout::Samples] {
        for basis in ["cubemap:2", "latlong:6x4", "plain:24"] {
            let header = Header { layout, basis: basis.parse().unwrap(), ..header() };
            assert_eq!(prt::inspect(&prt::pack(&header, Vec::new(), &Quiet).unwrap()).unwrap().header, header);
        }
    }
}

/// A file with one byte of the header changed and the checksum made good: only the meaning is wrong.
fn forged(at: usize, value: u8) -> Vec<u8> {
    let mut bytes = GOLDEN.to_vec();
    bytes[at] = value;
    let end = 16 + u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
    let crc = crc32fast::hash(&bytes[..end - 4]);
    bytes[end - 4..end].copy_from_slice(&crc.to_le_bytes());
    bytes
}

#[test]
fn damage_is_told_by_its_place() {
    let read = |bytes: &[u8]| prt::from_bytes(bytes, &registry());
    let flipped = |at: usize| {
        let mut bytes = GOLDEN.to_vec();
        bytes[at] ^= 0x20;
        bytes
    };
    let end = 16 + u32::from_le_bytes(GOLDEN[12..16].try_into().unwrap()) as usize;
    names(read(&flipped(0)), "byte 0");
    names(read(&flipped(20)), "header checksum");
    names(read(&flipped(end + 30)), "section 'index/offsets'");
    names(read(&flipped(GOLDEN.len() - 3)), "section 'weights/values'");
    names(read(&forged(8, 3)), "version 3");
    names(read(&[GOLDEN, b"x"].concat()), "end of the file");
    names(read(&GOLDEN[..GOLDEN.len() - 1]), "end of the file");
    // The tag csr.1 becomes csr.9; the layout becomes 7.
    let tag = GOLDEN.windows(5).position(|w| w == b"csr.1").unwrap();
    names(read(&forged(tag + 4, b'9')), "csr.9");
    names(read(&forged(tag + 5 + 24 + 2 + 9, 7)), "layout 0, 1 or 2");
}
