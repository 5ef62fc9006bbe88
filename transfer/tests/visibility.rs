//! What `visibility` promises: every bit of the matrices that it takes, and a reason for those that it refuses.
#![cfg(feature = "scene")]

use ndarray::Array2;
use proptest::prelude::*;
use prt_transfer::compact::Compact;
use prt_transfer::hemisphere::local_directions;
use prt_transfer::random::Random;
use prt_transfer::scene::biscale::biscale;
use prt_transfer::scene::bvh::Occluders;
use prt_transfer::scene::frames;
use prt_transfer::scene::shapes;
use prt_transfer::scene::signal::{Sampling, Surface};
use prt_transfer::visibility::{EncodedVisibility, Visibility};
use prt_transfer::{Codec, Configure, Encoded, LightBasis, Quiet, Restore, Section, Sink, Source, TransferMatrix};

fn encode(matrix: &TransferMatrix) -> prt_transfer::Result<EncodedVisibility> {
    Visibility::new(Default::default()).unwrap().encode(matrix, &Quiet)
}

fn sections(encoded: &dyn Encoded) -> Vec<Section> {
    let mut sink = Sink::new();
    encoded.write(&mut sink);
    sink.into_sections()
}

fn bytes(encoded: &dyn Encoded) -> usize {
    sections(encoded).iter().map(|s| s.bytes.len()).sum()
}

/// Exceptions of an encoded matrix.
fn exceptions(encoded: &EncodedVisibility) -> usize {
    sections(encoded).iter().find(|s| s.name == "index/exceptions").unwrap().bytes.len() / 12
}

/// Every row through a file's sections, and relighting of it.
fn assert_exact(matrix: &TransferMatrix) -> EncodedVisibility {
    let encoded = encode(matrix).unwrap();
    let mut source = Source::new(sections(&encoded)).unwrap();
    let read = EncodedVisibility::read(matrix.shape(), &mut source).unwrap();
    source.finish().unwrap();
    let lights = Array2::from_shape_fn((matrix.lights(), 2), |(k, c)| ((k * 31 + c * 17) % 97) as f32 / 64.0);
    let (mut row, mut expected) = (vec![0f32; matrix.lights()], vec![0f32; matrix.lights()]);
    let mut out = Array2::zeros((matrix.rows(), 2));
    read.apply_into(lights.view(), out.view_mut()).unwrap();
    for r in 0..matrix.rows() {
        read.row_into(r, &mut row);
        matrix.gather(r, &mut expected);
        assert_eq!(row, expected, "row {r}");
        for (c, &y) in out.row(r).iter().enumerate() {
            let terms = expected.iter().zip(lights.column(c)).map(|(&v, &x)| f64::from(v) * f64::from(x));
            let (sum, size) = terms.fold((0.0, 0.0), |(s, a), t| (s + t, a + t.abs()));
            assert!((f64::from(y) - sum).abs() <= 1e-7 * size, "row {r}: {y} for {sum}");
        }
    }
    read
}

fn surface(scene: &str, vertices: usize, sampling: &Sampling, edge: usize) -> TransferMatrix {
    let mesh = shapes::find(scene).unwrap().build(vertices).unwrap();
    let (occluders, frames) = (Occluders::new(&mesh).unwrap(), frames::vertex_frames(&mesh).unwrap());
    let surface = Surface { occluders: &occluders, points: &mesh.positions, frames: &frames };
    biscale(&surface, sampling, edge, &Quiet).unwrap().0
}

/// Samples with unit quaternions as frames; `value` says what texel and local direction have.
fn matrix(
    frames: &[[f64; 4]],
    resolution: usize,
    edge: usize,
    value: impl Fn(usize, usize, [f64; 3]) -> f32,
) -> TransferMatrix {
    let basis = LightBasis::Cubemap { resolution };
    let (directions, centres) = (local_directions(edge), basis.directions().unwrap());
    let mut values = vec![0f32; frames.len() * edge * edge * centres.len()];
    for (sample, q) in frames.iter().enumerate() {
        for (texel, &centre) in centres.iter().enumerate() {
            let local = rotated(*q, centre);
            let flat = [local[0], local[1], local[2].max(0.0)];
            let cosine = |d: &[f32; 3]| d.iter().zip(flat).map(|(&a, b)| f64::from(a) * b).sum::<f64>();
            let nearest =
                (0..edge * edge).max_by(|&a, &b| cosine(&directions[a]).total_cmp(&cosine(&directions[b]))).unwrap();
            values[(sample * edge * edge + nearest) * centres.len() + texel] = value(sample, texel, local);
        }
    }
    TransferMatrix::from_dense(values, frames.len() * edge * edge, edge * edge, basis).unwrap()
}

/// q v q*, by the formula v + 2w (r × v) + 2 r × (r × v): not the matrix that the codec makes.
fn rotated([w, x, y, z]: [f64; 4], v: [f64; 3]) -> [f64; 3] {
    let cross = |b: [f64; 3]| [y * b[2] - z * b[1], z * b[0] - x * b[2], x * b[1] - y * b[0]];
    let (once, twice) = (cross(v), cross(cross(v)));
    std::array::from_fn(|i| v[i] + 2.0 * w * once[i] + 2.0 * twice[i])
}

fn frame() -> impl Strategy<Value = [f64; 4]> {
    prop::array::uniform4(-1f64..1.0).prop_filter_map("a rotation", |q| {
        let length = q.iter().map(|c| c * c).sum::<f64>().sqrt();
        (length > 0.1).then(|| q.map(|c| c / length))
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]

    #[test]
    fn any_frames_and_any_values_come_back_bit_for_bit(
        frames in prop::collection::vec(frame(), 0..6), resolution in 1usize..10, edge in 1usize..=8, seed in any::<u32>(),
    ) {
        // Above and below the horizon, sparse and dense, few values and many.
        let random = |sample: usize, texel: usize| ((sample * 7919 + texel) as u32 | 1).wrapping_mul(seed | 1) >> 16;
        let matrix = matrix(&frames, resolution, edge, |sample, texel, local| match random(sample, texel) % 8 {
            _ if local[2] < -0.3 && seed % 2 == 0 => 0.0,
            0 => 0.0,
            1 => (random(sample, texel) as f32).sqrt() * if seed % 3 == 0 { 1.0 } else { 0.0 },
            k => (k as f32 - 4.5) / 4.0,
        });
        assert_exact(&matrix);
    }

    #[test]
    fn columns_in_other_rows_than_the_nearest_are_kept_there(q in frame(), moved in prop::collection::btree_set(0usize..384, 0..40)) {
        let matrix = matrix(&[q], 8, 3, |_, _, local| if local[2] > 0.0 { 0.5 } else { 0.0 });
        let mut values = vec![0f32; 9 * 384];
        for row in 0..9 {
            for (column, value) in matrix.row(row).non_zeros() {
                values[if moved.contains(&column) { (row + 4) % 9 } else { row } * 384 + column] = value;
            }
        }
        assert_exact(&TransferMatrix::from_dense(values, 9, 9, matrix.basis().clone()).unwrap());
    }
}

#[test]
fn few_columns_are_in_other_rows_than_a_fitted_frame_says() {
    // Frames keep 15 bits, and of few texels not every frame is found: a part of all columns, over frames in general position.
    let mut random = Random(7);
    let (mut columns, mut exceptional) = (0, 0);
    for resolution in 1..10 {
        for edge in 1..=8 {
            let frame = |random: &mut Random| {
                let q = [0; 4].map(|_| random.normal());
                let length = q.iter().map(|c| c * c).sum::<f64>().sqrt();
                q.map(|c| c / length)
            };
            let frames: Vec<[f64; 4]> = (0..8).map(|_| frame(&mut random)).collect();
            let matrix = matrix(&frames, resolution, edge, |_, _, local| if local[2] > -0.3 { 0.25 } else { 0.0 });
            columns += matrix.non_zeros();
            exceptional += exceptions(&assert_exact(&matrix));
        }
    }
    assert!(300 * exceptional < columns, "{exceptional} of {columns}");
}

#[test]
fn a_signal_takes_less_than_a_tenth_of_the_bytes_of_compact_and_few_exceptions() {
    // Values in sixteenths, and a resolution and directions that are not powers of two.
    for (scene, resolution, supersampling, edge) in [("chair", 16, 1, 8), ("blob", 12, 2, 5), ("bumpy-sphere", 9, 0, 3)]
    {
        let matrix = surface(scene, 300, &Sampling { resolution, supersampling }, edge);
        let encoded = assert_exact(&matrix);
        let compact = Compact::new(Default::default()).unwrap().encode(&matrix, &Quiet).unwrap();
        let (ours, theirs) = (bytes(&encoded), bytes(&compact));
        assert!(10 * ours < theirs, "{scene}: {ours}, compact {theirs}");
        assert!(500 * exceptions(&encoded) < matrix.non_zeros(), "{scene}: {} exceptions", exceptions(&encoded));
    }
}

#[test]
fn an_open_sky_is_told_by_the_frame_alone() {
    let normals = [[0.0, 0.0, 1.0], [0.48, -0.6, 0.64], [-1.0, 0.0, 0.0]].map(|n| glam::Vec3::from(n).normalize());
    let frames = normals.map(frames::Frame::by_axis);
    let occluders = Occluders::new(&Default::default()).unwrap();
    let surface = Surface { occluders: &occluders, points: &[glam::Vec3::ZERO; 3], frames: &frames };
    let (matrix, _) = biscale(&surface, &Sampling::default(), 8, &Quiet).unwrap();
    let sections = sections(&assert_exact(&matrix));
    // Runs of 256 columns that say "as predicted", but for texels whose samples lie on the horizon to the last bit.
    let runs = sections.iter().find(|s| s.name == "index/lengths").unwrap().bytes.len();
    assert!(runs < 3 * (6144 / 256 + 60), "{runs} runs");
}

#[test]
fn what_has_another_structure_is_refused_with_the_reason() {
    let refusal = |values: Vec<f32>, rows: usize, responses: usize, basis: LightBasis| {
        let matrix = TransferMatrix::from_dense(values, rows, responses, basis).unwrap();
        encode(&matrix).err().expect("a refusal").to_string()
    };
    let cubemap = |resolution| LightBasis::Cubemap { resolution };
    let message = refusal(vec![1.0; 9], 1, 1, LightBasis::SphericalHarmonics { order: 3 });
    assert!(message.contains("light basis") && message.contains("sh:3"), "{message}");
    let message = refusal(vec![0.0; 6 * 6], 6, 6, cubemap(1));
    assert!(message.contains("responses") && message.contains("found 6"), "{message}");
    let message = refusal(vec![1.0; 4 * 6], 4, 4, cubemap(1));
    assert!(message.contains("column 0 of sample 0") && message.contains("responses 0 and 1"), "{message}");
    let message = refusal((0..6 * 900).map(|i| i as f32).collect(), 1, 1, cubemap(30));
    assert!(message.contains("distinct values") && message.contains("4096"), "{message}");
    // Rows that have nothing to do with directions.
    let scattered = (0..4 * 1536).map(|i| if i % 1536 * 7 / 3 % 4 == i / 1536 { 1.0 } else { 0.0 }).collect();
    let message = refusal(scattered, 4, 4, cubemap(16));
    assert!(message.contains("frame") && message.contains("elsewhere"), "{message}");
}
