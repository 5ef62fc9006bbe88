//! Relighting in the paper's order (Tsai and Shih 2006, §6): the light meets the bases of each cluster, samples add up their cluster's
//! columns.

use crate::encoded::EncodedCta;
use crate::kernel::{Columns, Gather};
use crate::layout::BLOCK;
use ndarray::{Array2, ArrayView2, ArrayViewMut2, Axis, s};
use prt_transfer::matrix::check_apply;
use prt_transfer::numbers::Numbers;
use prt_transfer::{Count, Flops, NoCount, Result, Shape, Tally};
use rayon::prelude::*;

/// Samples given to a thread at a time, a multiple of [`BLOCK`].
const TASK: usize = 8 * BLOCK;

/// `out` (rows x channels) = T̃ · `lights` (lights x channels).
pub(crate) fn apply(encoded: &EncodedCta, lights: ArrayView2<f32>, mut out: ArrayViewMut2<f32>) -> Result<()> {
    check_apply(encoded.shape, &lights, &out)?;
    if out.is_empty() {
        return Ok(());
    }
    let columns = columns(encoded, lights, &mut NoCount)?;
    let (channels, responses) = (lights.ncols(), encoded.shape.responses);
    let tasks = out.axis_chunks_iter_mut(Axis(0), TASK * responses).into_par_iter().enumerate();
    tasks.for_each_init(Scratch::default, |scratch, (task, mut rows)| match rows.as_slice_mut() {
        Some(rows) => gather(encoded, &columns, task * TASK, rows, scratch, &mut NoCount),
        // An output with gaps: by way of one without.
        None => {
            let mut whole = Array2::zeros((rows.nrows(), channels));
            let slice = whole.as_slice_mut().expect("a fresh array is contiguous");
            gather(encoded, &columns, task * TASK, slice, scratch, &mut NoCount);
            rows.assign(&whole);
        }
    });
    Ok(())
}

/// Operations of relighting with one channel.
pub(crate) fn flops(encoded: &EncodedCta, light: &[f32]) -> Flops {
    let mut tally = Tally::default();
    let light = ArrayView2::from_shape((light.len(), 1), light).expect("a slice is a column");
    if let Ok(columns) = columns(encoded, light, &mut tally) {
        let mut out = vec![0f32; encoded.shape.rows()];
        gather(encoded, &columns, 0, &mut out, &mut Scratch::default(), &mut tally);
    }
    tally.0
}

/// Whether the view basis meets the columns of clusters and not what samples add up: where this takes fewer multiplications.
fn views_first(encoded: &EncodedCta) -> bool {
    let Some(view) = &encoded.view else { return false };
    let (responses, views) = view.dim();
    let places = encoded.layout.places();
    let weights = encoded.weights.len();
    let of_columns: usize = places.iter().map(|place| place.sample_rank).sum::<usize>() * responses * views;
    of_columns + weights * responses < weights * views + encoded.shape.samples * responses * views
}

/// Step 2: `R_c`, whose column j is uf⁻¹(V_j) U_lightᵀ l, for every cluster; times the scale of the weights that meet it.
fn columns<C: Count>(encoded: &EncodedCta, lights: ArrayView2<f32>, count: &mut C) -> Result<Columns> {
    let (layout, channels) = (&encoded.layout, lights.ncols());
    let in_bases = in_light_bases(encoded, lights, count)?;
    let mut rows = Array2::<f32>::zeros((layout.end().sample * layout.views, channels));
    for place in layout.places() {
        let shape = Shape { samples: place.sample_rank, responses: layout.views, lights: place.light_rank };
        let own = in_bases.slice(s![place.light..place.light + place.light_rank, ..]);
        let first = place.sample * layout.views;
        let out = rows.slice_mut(s![first..first + shape.rows(), ..]);
        encoded.dual.apply_stored(place.dual, shape, own, out)?;
    }
    count.multiply_add(encoded.dual.len());
    count.factors((0..encoded.dual.len()).map(|at| encoded.dual.stored(at) * encoded.dual.unit()));
    scale_columns(encoded, &mut rows, count);
    let columns = Columns::new(layout.places(), rows.view(), layout.views);
    Ok(match &encoded.view {
        Some(view) if views_first(encoded) => {
            let each = view.len() * layout.end().sample;
            count.multiply_add(each);
            count.factors((0..layout.end().sample).flat_map(|_| view.iter().copied()));
            columns.through(view.view())
        }
        _ => columns,
    })
}

/// L' of every cluster, one below the other: rows of light bases x channels.
fn in_light_bases<C: Count>(encoded: &EncodedCta, lights: ArrayView2<f32>, count: &mut C) -> Result<Array2<f32>> {
    let (numbers, rows) = (&encoded.light, encoded.layout.end().light);
    let mut out = Array2::zeros((rows, lights.ncols()));
    let shape = Shape { samples: rows, responses: 1, lights: encoded.shape.lights };
    numbers.apply_stored(0, shape, lights, out.view_mut())?;
    count.multiply_add(numbers.len());
    count.factors((0..numbers.len()).map(|at| numbers.stored(at) * numbers.unit()));
    if let Some(scales) = numbers.scales() {
        for (mut row, scale) in out.outer_iter_mut().zip(scales) {
            let factor = f64::from(*scale) / f64::from(numbers.unit());
            scale_row(&mut row, factor, count);
        }
    }
    Ok(out)
}

fn scale_row<C: Count>(row: &mut ndarray::ArrayViewMut1<f32>, factor: f64, count: &mut C) {
    count.multiply(row.len());
    count.factors(std::iter::repeat_n(factor as f32, row.len()));
    row.iter_mut().for_each(|v| *v = (f64::from(*v) * factor) as f32);
}

/// Gives columns the scales that the numbers of dual bases and the weights were stored without.
fn scale_columns<C: Count>(encoded: &EncodedCta, rows: &mut Array2<f32>, count: &mut C) {
    let (Some(of_dual), Some(of_weights)) = (encoded.dual.scales(), encoded.weights.scales()) else { return };
    let unit = f64::from(encoded.dual.unit());
    for (j, (dual, weight)) in of_dual.iter().zip(of_weights).enumerate() {
        // In double precision: a product of two scales may leave the range of f32 where a column does not.
        let factor = f64::from(*dual) / unit * f64::from(*weight);
        count.multiply(1);
        count.factors(std::iter::once(*weight));
        for v in 0..encoded.layout.views {
            scale_row(&mut rows.row_mut(j * encoded.layout.views + v), factor, count);
        }
    }
}

/// Room that a thread uses again.
#[derive(Default)]
struct Scratch {
    weights: Vec<f32>,
    clusters: Vec<u32>,
}

/// Steps 3 and 4 but for the view direction: `R_c W_x` for the samples from `first` on, a multiple of [`BLOCK`], and the view basis; `out` is
/// samples x responses x channels.
fn gather<C: Count>(
    encoded: &EncodedCta,
    columns: &Columns,
    first: usize,
    out: &mut [f32],
    scratch: &mut Scratch,
    count: &mut C,
) {
    let EncodedCta { layout, ids, shape, weights, .. } = encoded;
    let view = encoded.view.as_ref().filter(|_| !columns.seen());
    let gather = Gather::new(columns, view.map(|view| view.view()), shape.responses);
    let (mut at, memberships) = (layout.first_weight(first, ids), layout.memberships);
    let of_sample = shape.responses * columns.channels();
    if of_sample == 0 {
        return;
    }
    for (block, out) in out.chunks_mut(BLOCK * of_sample).enumerate() {
        let samples = out.len() / of_sample;
        scratch.clusters.resize(samples * memberships, 0);
        ids.fill((first + block * BLOCK) * memberships, &mut scratch.clusters);
        let end = at + scratch.clusters.iter().map(|&k| layout.place(k as usize).sample_rank).sum::<usize>();
        let unpacked = Numbers::unpack(weights, at..end, 0, &mut scratch.weights);
        gather.run(&scratch.clusters, memberships, unpacked, out, count);
        at = end;
    }
}
