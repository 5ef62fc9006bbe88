//! Whether borders of clusters show: second differences of radiance along the texture, across borders and inside of clusters.

use super::{WORLD, field, world};
use crate::charts::curves::{Curves, Dot, Plane};
use crate::figures::stage::Stage;
use crate::figures::{Drawing, Figure};
use crate::interrupt::Unseen;
use crate::light_field::as_slf;
use crate::machine::Machine;
use crate::number::short;
use crate::table::aligned;
use anyhow::Context;
use prt_slf::EncodedSlf;
use prt_transfer::scene::light_field::FieldParams;
use prt_transfer::{Encoded, TransferMatrix};
use rayon::prelude::*;

pub(super) const FIGURE: Figure = Figure { name: "seams", table: None, draw };

const SHAPE: &str = "blue-sphere";
const COMPONENTS: [usize; 3] = [2, 8, 16];
const CLUSTERS: [usize; 7] = [4, 8, 16, 32, 64, 128, 256];

/// Root mean squares of second differences over the mean radiance: of the field and of what is decoded.
#[derive(Clone, Copy)]
struct Jumps {
    exact: f64,
    decoded: f64,
}

struct Outcome {
    components: usize,
    clusters: usize,
    /// Share of the triples of texels that a border runs through.
    borders: f64,
    across: Jumps,
    inside: Jumps,
}

fn draw(stage: &Stage) -> anyhow::Result<Drawing> {
    let (world, side) = (world()?, if stage.is_paper_sized() { 128 } else { 48 });
    let params = FieldParams { width: side, height: side, around: 64, down: 32, ..FieldParams::default() };
    stage.steps.more(1 + COMPONENTS.len() * CLUSTERS.len());
    let matrix = field(stage, &world, SHAPE, &params, 0)?;
    let mut outcomes = Vec::new();
    for components in COMPONENTS {
        for clusters in CLUSTERS {
            outcomes.push(at(stage, &matrix, side, components, clusters)?);
            stage.steps.done(1);
        }
    }
    let chart = chart(&params, &outcomes);
    Ok(Drawing {
        text: table(&outcomes),
        tables: vec![("", csv(&outcomes, &stage.machine)?)],
        chart: Some(chart),
        measured: true,
        ..Drawing::default()
    })
}

fn at(
    stage: &Stage,
    matrix: &TransferMatrix,
    width: usize,
    components: usize,
    clusters: usize,
) -> anyhow::Result<Outcome> {
    let label = format!("slf:clusters={clusters}:components={components}");
    stage.steps.show(&label);
    let method = stage.bench.registry.method(&label.parse()?)?;
    let compressed = stage.bench.pools.everywhere(|| method.encode(matrix, &Unseen))?;
    let slf = as_slf(&compressed)?.context("what slf makes is slf")?;
    let sums = stage.bench.pools.everywhere(|| second_differences(matrix, &slf, width));
    let mean = {
        let (mut sum, mut count) = (0f64, 0u64);
        for row in 0..matrix.rows() {
            for (_, value) in matrix.row(row).non_zeros() {
                sum += f64::from(value);
            }
            count += matrix.lights() as u64;
        }
        sum / count as f64
    };
    let jumps = |[exact, decoded]: [f64; 2], count: f64| {
        let root = |sum: f64| (sum / count.max(1.0)).sqrt() / mean;
        Jumps { exact: root(exact), decoded: root(decoded) }
    };
    let [across, inside] = sums;
    Ok(Outcome {
        components,
        clusters,
        borders: across.count / (across.count + inside.count),
        across: jumps(across.squares, across.count),
        inside: jumps(inside.squares, inside.count),
    })
}

#[derive(Clone, Copy, Default)]
struct Sums {
    /// Of the field and of what is decoded.
    squares: [f64; 2],
    count: f64,
}

/// Sums of (F_a − 2 F_b + F_c)² over neighbours a, b, c in a row of the texture, all directions and channels: where a border of clusters
/// runs through them, and where none does.
fn second_differences(matrix: &TransferMatrix, slf: &EncodedSlf, width: usize) -> [Sums; 2] {
    let shape = matrix.shape();
    let of_row = |y: usize| {
        let mut sums = [Sums::default(); 2];
        for channel in 0..shape.responses {
            // Rows of the three texels, exact and decoded.
            let mut window: [[Vec<f32>; 2]; 3] =
                std::array::from_fn(|_| std::array::from_fn(|_| vec![0.0; shape.lights]));
            for x in 0..width {
                window.rotate_left(1);
                let row = (y * width + x) * shape.responses + channel;
                matrix.gather(row, &mut window[2][0]);
                slf.row_into(row, &mut window[2][1]);
                if x < 2 {
                    continue;
                }
                let cluster = |back: usize| slf.cluster_of(y * width + x - back, channel);
                let border = cluster(0) != cluster(1) || cluster(1) != cluster(2);
                let sums = &mut sums[usize::from(!border)];
                for (kind, square) in sums.squares.iter_mut().enumerate() {
                    let [a, b, c] = window.each_ref().map(|texel| &texel[kind]);
                    let second =
                        a.iter().zip(b).zip(c).map(|((a, b), c)| f64::from(*a) - 2.0 * f64::from(*b) + f64::from(*c));
                    *square += second.map(|d| d * d).sum::<f64>();
                }
                sums.count += shape.lights as f64;
            }
        }
        sums
    };
    let rows: Vec<[Sums; 2]> = (0..shape.samples / width).into_par_iter().map(of_row).collect();
    let add = |a: Sums, b: Sums| Sums {
        squares: [a.squares[0] + b.squares[0], a.squares[1] + b.squares[1]],
        count: a.count + b.count,
    };
    rows.into_iter().fold([Sums::default(); 2], |all, row| [add(all[0], row[0]), add(all[1], row[1])])
}

fn chart(params: &FieldParams, outcomes: &[Outcome]) -> Curves {
    let names = ["borders, decoded", "borders, field", "inside, decoded", "inside, field"];
    let figure = |o: &Outcome, i: usize| [o.across.decoded, o.across.exact, o.inside.decoded, o.inside.exact][i];
    let curve = |components: usize, i: usize| {
        let of = outcomes.iter().filter(|o| o.components == components);
        of.map(|o| Dot { x: o.clusters as f64, y: figure(o, i), label: String::new() }).collect()
    };
    let plane = |components: usize| Plane {
        upwards: format!("k = {components}: second difference / mean radiance"),
        across: "clusters η".into(),
        curves: (0..names.len()).map(|i| curve(components, i)).collect(),
        references: Vec::new(),
    };
    let FieldParams { width, height, around, down, .. } = params;
    Curves {
        title: "Seams: second differences along the texture".into(),
        subject: format!("{WORLD} · {SHAPE} · {width} x {height} texels · {around} x {down} directions"),
        remark: None,
        names: names.map(String::from).into(),
        apart: false,
        planes: COMPONENTS.iter().map(|&k| plane(k)).collect(),
    }
}

fn table(outcomes: &[Outcome]) -> String {
    let titles =
        ["k", "η", "borders", "field there", "decoded there", "ratio", "field inside", "decoded inside", "ratio"];
    let lines = outcomes.iter().map(|o| {
        let Outcome { components, clusters, borders, across, inside } = o;
        let figures = [*borders, across.exact, across.decoded, across.decoded / across.exact];
        let more = [inside.exact, inside.decoded, inside.decoded / inside.exact];
        let head = [components.to_string(), clusters.to_string()];
        head.into_iter().chain(figures.into_iter().chain(more).map(short)).collect()
    });
    format!(
        "\nSeams: second differences over mean radiance, across borders of clusters and inside\n{}",
        aligned(&titles, lines)
    )
}

fn csv(outcomes: &[Outcome], machine: &Machine) -> anyhow::Result<Vec<u8>> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record([
        "components",
        "clusters",
        "border_share",
        "border_field",
        "border_decoded",
        "inside_field",
        "inside_decoded",
        "machine",
    ])?;
    for o in outcomes {
        let figures =
            [o.borders, o.across.exact, o.across.decoded, o.inside.exact, o.inside.decoded].map(|f| f.to_string());
        let head = [o.components.to_string(), o.clusters.to_string()];
        writer.write_record(head.into_iter().chain(figures).chain([machine.line()]))?;
    }
    Ok(writer.into_inner()?)
}

#[cfg(test)]
mod tests {
    use super::*;
    use prt_slf::{Slf, SlfParams};
    use prt_transfer::Quiet;
    use prt_transfer::responses::Directions;
    use prt_transfer::texels::{Border, Texels};
    use prt_transfer::{Codec, Configure, LightBasis, ResponseBasis};

    /// Texels in a row whose radiance is `value` of column and direction, in three channels.
    fn row(width: usize, value: impl Fn(usize, usize) -> f32) -> TransferMatrix {
        let texels = Texels { width, height: 1, border: Border::Clamp };
        let values = (0..width * 3 * 8).map(|i| value(i / 24, i % 8)).collect();
        let matrix =
            TransferMatrix::from_dense(values, 3 * width, 3, LightBasis::LatLong { width: 4, height: 2 }).unwrap();
        matrix.with_responses(ResponseBasis::Radiance { texels, directions: Directions::World }).unwrap()
    }

    fn sums(matrix: &TransferMatrix, clusters: usize, components: usize) -> [Sums; 2] {
        let params = SlfParams { clusters: prt_slf::Clusters::Number(clusters), components, ..SlfParams::default() };
        let slf = Slf::new(params).unwrap().encode(matrix, &Quiet).unwrap();
        second_differences(matrix, &slf, matrix.shape().samples)
    }

    #[test]
    fn second_differences_are_those_of_a_parabola_and_vanish_on_a_line() {
        let parabola = row(10, |x, d| (x * x) as f32 * (1.0 + (d % 2) as f32));
        let [across, inside] = sums(&parabola, 1, 8);
        assert_eq!((across.count, inside.count), (0.0, 8.0 * 3.0 * 8.0));
        // x² has the second difference 2, and 2x² has 4: half of the directions each.
        assert!((inside.squares[0] / inside.count - 10.0).abs() < 1e-6, "{:?}", inside.squares);
        assert!((inside.squares[1] / inside.squares[0] - 1.0).abs() < 1e-3, "a field of full rank is decoded as it is");
        let [_, line] = sums(&row(10, |x, d| (x * d) as f32), 1, 8);
        assert!(line.squares[0] == 0.0 && line.squares[1] < 1e-6, "{:?}", line.squares);
    }

    #[test]
    fn a_border_of_clusters_lies_where_the_field_jumps() {
        let jump = row(12, |x, d| if x < 6 { d as f32 } else { (7 - d) as f32 });
        let [across, inside] = sums(&jump, 2, 1);
        // Two triples of texels hold the border, ten in all.
        assert_eq!((across.count, inside.count), (2.0 * 3.0 * 8.0, 8.0 * 3.0 * 8.0));
        assert!(across.squares[0] > 0.0 && inside.squares[0] == 0.0);
    }
}
