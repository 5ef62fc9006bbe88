//! Small files of every format, of which mutations are made.

use super::{Parts, REGISTRY};
use crate::{Case, cases, encode_where_defined, labels};
use exr::prelude::{
    AnyChannel, AnyChannels, Blocks, Compression, Encoding, FlatSamples, Layer, LayerAttributes, LineOrder, Vec2,
    WritableImage,
};
use prt_cpca::{Cluster, Model, d3dx};
use prt_harness::results::to_csv;
use prt_harness::row::Row;
use prt_transfer::image::Image;
use prt_transfer::io::image::{Precision, exr_bytes};
use prt_transfer::io::{npz as npz_files, prt};
use prt_transfer::{Label, LightBasis, Quiet, Shape, TransferMatrix};
use std::io::{Cursor, Write};
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipWriter};

fn sparse_matrix() -> TransferMatrix {
    let columns = vec![0, 3, 1, 2, 3, 5];
    let values = vec![0.5, 1.0, -2.0, 0.25, 3.0, 7.0];
    TransferMatrix::from_csr(vec![0, 2, 2, 5, 6], columns, values, 2, LightBasis::Cubemap { resolution: 1 })
        .expect("a valid matrix")
}

/// An array as NumPy writes it.
fn array(descr: &str, fortran: bool, shape: &str, data: &[u8]) -> Vec<u8> {
    let order = if fortran { "True" } else { "False" };
    let header = format!("{{'descr': '{descr}', 'fortran_order': {order}, 'shape': {shape}, }}\n");
    let length = (header.len() as u16).to_le_bytes();
    [b"\x93NUMPY\x01\x00", &length[..], header.as_bytes(), data].concat()
}

fn archive(method: CompressionMethod, entries: &[(&str, Vec<u8>)]) -> Vec<u8> {
    let mut archive = ZipWriter::new(Cursor::new(Vec::new()));
    let options = SimpleFileOptions::default().compression_method(method);
    for (name, bytes) in entries {
        archive.start_file(*name, options).and_then(|()| Ok(archive.write_all(bytes)?)).expect("memory takes it");
    }
    archive.finish().expect("memory takes it").into_inner()
}

fn bytes_of<const N: usize, T>(numbers: &[T], to_bytes: impl Fn(&T) -> [u8; N]) -> Vec<u8> {
    numbers.iter().flat_map(to_bytes).collect()
}

/// Ours with and without a basis, and csr, csc and coo as scipy writes them, of several types.
pub(super) fn npz() -> Vec<Vec<u8>> {
    let ours = npz_files::to_bytes(&sparse_matrix(), "a signal").expect("a valid matrix");
    let wide = |numbers: &[i64]| bytes_of(numbers, |n| n.to_le_bytes());
    let narrow = |numbers: &[i32]| bytes_of(numbers, |n| n.to_le_bytes());
    let shape = || ("shape.npy", array("<i8", false, "(2,)", &wide(&[4, 6])));
    let format = |name: &str| ("format.npy", array("|S3", false, "()", name.as_bytes()));
    let values = || bytes_of(&[0.5f64, 1.0, -2.0, 0.25, 3.0, 7.0], |v| v.to_le_bytes());
    let compressed = |name, offsets: &[i32], indices: &[i32], axis: &str| {
        vec![
            ("indices.npy", array("<i4", false, "(6,)", &narrow(indices))),
            ("indptr.npy", array("<i4", false, axis, &narrow(offsets))),
            format(name),
            shape(),
            ("data.npy", array("<f8", false, "(6,)", &values())),
        ]
    };
    let coordinates = vec![
        ("row.npy", array("<i4", false, "(6,)", &narrow(&[0, 0, 2, 2, 2, 3]))),
        ("col.npy", array("<i4", false, "(6,)", &narrow(&[0, 3, 1, 1, 3, 5]))),
        format("coo"),
        shape(),
        ("data.npy", array("|u1", false, "(6,)", &[1, 2, 3, 4, 5, 6])),
    ];
    let coords = vec![
        ("coords.npy", array(">i8", false, "(2, 2)", &bytes_of(&[0i64, 3, 1, 5], |n| n.to_be_bytes()))),
        ("format.npy", array("<U3", false, "()", &bytes_of(&['c', 'o', 'o'], |c| u32::from(*c).to_le_bytes()))),
        shape(),
        ("data.npy", array("<f2", false, "(2,)", &[0, 0x3c, 0, 0xc0])),
    ];
    let csr = compressed("csr", &[0, 2, 2, 5, 6], &[3, 0, 1, 2, 3, 5], "(5,)");
    let csc = compressed("csc", &[0, 1, 2, 3, 5, 5, 6], &[0, 2, 2, 0, 2, 3], "(7,)");
    vec![
        ours,
        archive(CompressionMethod::Deflated, &csr),
        archive(CompressionMethod::Stored, &csr),
        archive(CompressionMethod::Stored, &csc),
        archive(CompressionMethod::Stored, &coordinates),
        archive(CompressionMethod::Stored, &coords),
    ]
}

/// Two and three axes, C and Fortran order, integers, either order of bytes; a vector, which is a light.
pub(super) fn npy() -> Vec<Vec<u8>> {
    let singles: Vec<f32> = (0..12).map(|i| i as f32 * 0.5 - 1.0).collect();
    let little = bytes_of(&singles, |v| v.to_le_bytes());
    let big = bytes_of(&singles, |v| v.to_be_bytes());
    let doubles = bytes_of(&singles, |v| f64::from(*v).to_le_bytes());
    let shorts: Vec<u8> = bytes_of(&singles, |v| (*v as i16).to_be_bytes());
    vec![
        array("<f4", false, "(3, 4)", &little),
        array(">f4", true, "(2, 2, 3)", &big),
        array("<f8", true, "(4, 3)", &doubles),
        array(">i2", false, "(2, 6)", &shorts),
        array("|u1", false, "(1, 3, 4)", &little[..12]),
        array("<f4", false, "(12,)", &little),
        array("<i8", false, "(2, 0)", &[]),
        // Format version 3.
        [b"\x93NUMPY\x03\x00\x40\x00\x00\x00".as_slice(), &array("<f4", false, "(2, 1)", &little)[10..]].concat(),
    ]
}

/// Coordinates and arrays, of every field and symmetry.
pub(super) fn mtx() -> Vec<Vec<u8>> {
    let texts = [
        "%%MatrixMarket matrix coordinate real general\n% a comment\n4 6 5\n1 1 0.5\n1 4 1\n3 2 -2e-3\n3 2 1\n4 6 7.25\n",
        "%%MatrixMarket matrix coordinate real symmetric\n4 4 3\n1 1 0.5\n3 2 -1e3\n4 4 7.\n",
        "%%MatrixMarket matrix coordinate integer skew-symmetric\n3 3 2\n2 1 5\n3 1 -7\n",
        "%%MatrixMarket matrix coordinate pattern general\n3 5 3\n1 5\n2 2\n3 1\n",
        "%%MatrixMarket matrix array real general\n2 3\n1\n2.5\n-3\n4e2\n5\n6\n",
        "%%MatrixMarket matrix array integer symmetric\n3 3\n1\n2\n3\n4\n5\n6\n",
        "%%MatrixMarket matrix array real skew-symmetric\n3 3\n1\n2\n3\n",
    ];
    texts.map(|text| text.as_bytes().to_vec()).to_vec()
}

/// Text and both orders of bytes; with normals, texture coordinates and elements that are passed over.
pub(super) fn ply() -> Vec<Vec<u8>> {
    let xyz = "property float x\nproperty float y\nproperty float z\n";
    let ascii = format!(
        "ply\nformat ascii 1.0\ncomment made by hand\nelement vertex 4\n{xyz}element face 2\n\
         property list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n1 1 0\n0 1 0.5\n3 0 1 2\n4 0 1 2 3\n"
    );
    let charted = format!(
        "ply\nformat ascii 1.0\nelement vertex 3\n{xyz}property float nx\nproperty float ny\nproperty float nz\n\
         property float s\nproperty float t\nelement edge 1\nproperty int vertex1\nproperty int vertex2\nelement face 1\n\
         property uchar red\nproperty list uint8 int32 vertex_index\nend_header\n\
         0 0 0 0 0 1 0 0\n1 0 0 0 0 2 1 0\n0 1 0 0 0 1 0 1\n0 1\n255 3 0 1 2\n"
    );
    let binary = |format: &str, big: bool| {
        let mut bytes = format!(
            "ply\nformat {format} 1.0\nelement vertex 3\nproperty double x\nproperty float y\nproperty short z\n\
             property list uchar float extra\nelement face 2\nproperty list ushort uint vertex_indices\nend_header\n"
        )
        .into_bytes();
        let mut put = |little: &[u8]| {
            if big {
                bytes.extend(little.iter().rev());
            } else {
                bytes.extend(little);
            }
        };
        for (x, y, z) in [(0f64, 0f32, 0i16), (1.0, 0.0, 3), (0.5, 2.0, -1)] {
            put(&x.to_le_bytes());
            put(&y.to_le_bytes());
            put(&z.to_le_bytes());
            put(&[1]);
            put(&y.to_le_bytes());
        }
        for face in [[0u32, 1, 2], [2, 1, 0]] {
            put(&3u16.to_le_bytes());
            face.iter().for_each(|v| put(&v.to_le_bytes()));
        }
        bytes
    };
    vec![
        ascii.into_bytes(),
        charted.into_bytes(),
        binary("binary_little_endian", false),
        binary("binary_big_endian", true),
    ]
}

/// Polygons, normals, texture coordinates, indices from the end, lines that go on.
pub(super) fn obj() -> Vec<Vec<u8>> {
    let texts = [
        "# made by hand\no thing\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0.5\nf 1 2 3 4\nf 1 3 4\n",
        "v 0 0 0\nv 1 0 0\nv 1 1 0\nvn 0 0 1\nvn 0 1 0\ng part\nf 1//1 2//1 -1//2\nusemtl red\nf 3//1 2//2 1//1\n",
        "v 0 0 0\nv 1 0 0\nv 1 1 0\nvn 0 0 1\nvt 0 0\nvt 1 0\nvt .5 1\nf 1/1/1 2/2/1 \\\n-1/-1/1\nf 1/1/1 2/3/1 3/2/1\n",
        "v 0 0 0 1 0.5 0.25\nv 1e0 0 0 1 1 1\nv 1 1 0 0 0 0\nvt 0 0\nvt 1 0\nvt 0.5 1\nf 1/1 2/2 3/3 # a comment\nl 1 2\np 1\n",
    ];
    texts.map(|text| text.as_bytes().to_vec()).to_vec()
}

/// Flat, old and new run lengths, turned and exposed.
pub(super) fn hdr() -> Vec<Vec<u8>> {
    let picture = |header: &str, size: &str, body: &[u8]| {
        [format!("#?RADIANCE\n{header}FORMAT=32-bit_rle_rgbe\n\n{size}\n").as_bytes(), body].concat()
    };
    let line = [2, 2, 0, 8, 136, 5, 8, 1, 2, 3, 4, 5, 6, 7, 8, 136, 9, 136, 130];
    let mixed = [2, 2, 0, 8, 135, 128, 1, 1, 135, 64, 129, 0, 7, 32, 32, 32, 32, 32, 32, 32, 1, 0, 135, 129, 1, 136];
    let flat: Vec<u8> = (0..12u8).flat_map(|i| [10 * i, 128, 255 - i, 120 + i]).collect();
    vec![
        picture("", "-Y 3 +X 8", &[line, line, line].concat()),
        picture("EXPOSURE=2\nEXPOSURE=4.0\nCOLORCORR=1 2 4\n", "-Y 1 +X 8", &mixed),
        picture("SOFTWARE=by hand\n", "+X 4 -Y 3", &flat),
        picture("", "+Y 2 -X 16", &[[128, 64, 32, 129, 1, 1, 1, 15], [9, 9, 9, 136, 1, 1, 1, 15]].concat()),
    ]
}

/// Every compression in scan lines and in tiles, half and single precision, grey.
pub(super) fn exr() -> Vec<Vec<u8>> {
    use Compression::{B44, B44A, DWAA, DWAB, PIZ, PXR24, RLE, Uncompressed, ZIP1, ZIP16};
    let (width, height) = (9, 18);
    let image = Image { width, height, pixels: (0..width * height).map(|i| [i as f32, 0.5, 1.0]).collect() };
    let mut files =
        [Precision::Half, Precision::Single].map(|p| exr_bytes(&image, p).expect("an image can be written")).to_vec();
    let compressions = [Uncompressed, RLE, ZIP1, ZIP16, PIZ, PXR24, B44, B44A, DWAA(None), DWAB(None)];
    for (i, compression) in compressions.into_iter().enumerate() {
        let blocks = if i % 2 == 0 { Blocks::ScanLines } else { Blocks::Tiles(Vec2(8, 8)) };
        let half = !matches!(compression, PXR24 | PIZ);
        let samples = |phase: usize| {
            let values = (0..width * height).map(|k| 2.0 + ((k + phase) as f32 * 0.2).sin());
            let halves = || values.clone().map(half::f16::from_f32).collect();
            if half { FlatSamples::F16(halves()) } else { FlatSamples::F32(values.clone().collect()) }
        };
        let names: &[&str] = if compression == RLE { &["Y"] } else { &["R", "G", "B"] };
        let channels = names.iter().enumerate().map(|(c, name)| AnyChannel::new(*name, samples(c))).collect();
        let encoding = Encoding { compression, blocks, line_order: LineOrder::Increasing };
        let layer = Layer::new((width, height), LayerAttributes::default(), encoding, AnyChannels::sort(channels));
        let mut file = Cursor::new(Vec::new());
        exr::prelude::Image::from_layer(layer).write().to_buffered(&mut file).expect("an image can be written");
        files.push(file.into_inner());
    }
    files
}

/// One and several clusters, with and without components, as D3DX writes them.
pub(super) fn pca() -> Vec<Vec<u8>> {
    let file = |samples: usize, responses: usize, lights: usize, clusters: usize, components: usize| {
        let n = responses * lights;
        let numbers =
            |count: usize, from: usize| (0..count).map(|i| (i + from) as f32 * 0.5 - 3.0).collect::<Vec<f32>>();
        let cluster = |k| Cluster { mean: numbers(n, k), components: numbers(components * n, k + 7) };
        let model = Model {
            shape: Shape { samples, responses, lights },
            clusters: (0..clusters).map(cluster).collect(),
            members: (0..samples).map(|s| (s % clusters) as u32).collect(),
            weights: numbers(samples * components, 2),
        };
        d3dx::to_d3dx(&model).expect("a valid model")
    };
    vec![file(5, 1, 4, 2, 2), file(4, 3, 9, 3, 1), file(6, 1, 4, 1, 0), file(7, 3, 4, 1, 2), file(4, 1, 16, 2, 0)]
}

/// Both kernels, with and without how they were fitted.
pub(super) fn lobes() -> Vec<Vec<u8>> {
    let texts = [
        r#"{"kernel":"gaussian","lobes":[{"centre":[0.6,0.0,0.8],"bandwidth":9.5,"radiance":[1.0,-0.5,2e-3]},
            {"centre":[0,0,-1],"bandwidth":200,"radiance":[3,4,5]}],"fit":{"label":"lobes=2","source":"sky","basis":"cubemap:8",
            "relative_squared_error":0.01,"flux_error":[0,0.1,-0.1],"history":[{"stage":"start","texels":384,"lobes":1,
            "relative_squared_error":0.5}]}}"#,
        r#"{"kernel": "abel-poisson", "lobes": [{"centre": [1, 0, 0], "bandwidth": 0.5, "radiance": [1, 1, 1]}]}"#,
        r#"{"kernel":"gaussian","lobes":[]}"#,
    ];
    texts.map(|text| text.as_bytes().to_vec()).to_vec()
}

/// None, one and several rows.
pub(super) fn results() -> Vec<Vec<u8>> {
    let row = |method: &str| Row {
        scene: "a, \"b\"\nc".into(),
        method: method.into(),
        samples: 12,
        error: Some(0.125),
        file_bytes: Some(99),
        ..Row::default()
    };
    let file = |rows: &[Row]| to_csv(rows).expect("rows can be written");
    vec![file(&[row("csr")]), file(&[row("csr"), row("pca:components=2"), Row::default()])]
}

/// Whole files of all codecs at their defaults.
pub(super) fn container() -> Vec<Vec<u8>> {
    let mut files = vec![include_bytes!("../../../transfer/tests/golden/csr-1.prt").to_vec()];
    let cases = chosen(&["smooth", "turned hemispheres"]);
    for label in labels(&REGISTRY).iter().filter(|l| l.codec.params.is_empty() && l.transform.params.is_empty()) {
        for case in &cases {
            if let Some((_, compressed)) = encode_where_defined(&REGISTRY, label, case) {
                files.push(prt::to_bytes(&compressed, &Quiet).expect("what was encoded can be written"));
            }
        }
    }
    files
}

/// Compressed matrices of every label with one of these codecs or transforms, taken apart: at their defaults of every small case, sparse and
/// dense, otherwise of two.
pub(super) fn parts(stages: &[&str]) -> Vec<Vec<u8>> {
    // Many lobes take long, and no other code.
    let few = |label: &Label| label.transform.name != "srbf" || label.to_string().contains("centers");
    let named = |label: &Label| stages.iter().any(|s| *s == label.codec.name || *s == label.transform.name);
    let defaults = |label: &Label| label.codec.params.is_empty() && label.transform.params.is_empty();
    let plain = |label: &Label| stages.contains(&label.transform.name.as_str()) || label.transform.name == "identity";
    let (two, all) = (chosen(&["visibility", "smooth"]), cases());
    let small = |case: &&Case| case.matrix.rows() * case.matrix.lights() <= 1 << 13;
    let (hemispheres, small) = (chosen(&["turned hemispheres"]), all.iter().filter(small).collect::<Vec<_>>());
    let mut made = Vec::new();
    for label in labels(&REGISTRY).iter().filter(|label| named(label) && plain(label) && few(label)) {
        let two = two.iter().collect();
        let cases = match (label.codec.name.as_str(), defaults(label)) {
            ("visibility", _) => hemispheres.iter().chain(&all[2..6]).collect(),
            (_, true) => small.clone(),
            (_, false) => two,
        };
        for case in cases {
            if let Some((_, compressed)) = encode_where_defined(&REGISTRY, label, case) {
                made.push(Parts::of(&compressed).to_bytes());
            }
        }
    }
    made.sort();
    made.dedup();
    made
}

/// The first case of each of these names.
fn chosen(names: &[&str]) -> Vec<Case> {
    let mut found: Vec<Case> = Vec::new();
    for case in cases() {
        if names.contains(&case.name) && found.iter().all(|other| other.name != case.name) {
            found.push(case);
        }
    }
    found
}
