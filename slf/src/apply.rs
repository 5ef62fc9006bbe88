//! Relighting in two stages: view maps meet the light, then rows their cluster's products.

use crate::encoded::EncodedSlf;
use crate::kernel;
use ndarray::{Array2, ArrayView2, ArrayViewMut2, Axis};
use prt_transfer::matrix::check_apply;
use prt_transfer::{Count, Flops, NoCount, Result, Tally};
use rayon::prelude::*;

/// Texels given to a thread at a time.
const TASK: usize = 512;

/// What rows are added up from: for each cluster and light `V_cᵀ l`, channels x k, and for each cluster, light and channel `Σ_d l_d`; both
/// times the scales of what they will meet.
struct Products {
    views: Vec<f32>,
    means: Vec<f32>,
}

/// `out` (rows x lights) = T̃ · `lights` (directions x lights).
pub(crate) fn apply(encoded: &EncodedSlf, lights: ArrayView2<f32>, mut out: ArrayViewMut2<f32>) -> Result<()> {
    let shape = encoded.layout.shape;
    check_apply(shape, &lights, &out)?;
    if out.is_empty() {
        return Ok(());
    }
    let products = products(encoded, lights, &mut NoCount);
    let tasks = out.axis_chunks_iter_mut(Axis(0), TASK * shape.responses).into_par_iter().enumerate();
    tasks.for_each_init(Vec::new, |buffer, (task, mut rows)| {
        let channels = rows.ncols();
        match rows.as_slice_mut() {
            Some(rows) => combine(encoded, &products, channels, task * TASK, rows, buffer, &mut NoCount),
            // An output with gaps: by way of one without.
            None => {
                let mut whole = Array2::zeros(rows.dim());
                let slice = whole.as_slice_mut().expect("a fresh array is contiguous");
                combine(encoded, &products, channels, task * TASK, slice, buffer, &mut NoCount);
                rows.assign(&whole);
            }
        }
    });
    Ok(())
}

/// Operations of relighting with one light.
pub(crate) fn flops(encoded: &EncodedSlf, light: &[f32]) -> Flops {
    let mut tally = Tally::default();
    let light = ArrayView2::from_shape((light.len(), 1), light).expect("a slice is a column");
    let products = products(encoded, light, &mut tally);
    let mut out = vec![0f32; encoded.layout.shape.rows()];
    combine(encoded, &products, 1, 0, &mut out, &mut Vec::new(), &mut tally);
    tally.0
}

/// Stage 1.
fn products<C: Count>(encoded: &EncodedSlf, lights: ArrayView2<f32>, count: &mut C) -> Products {
    let (layout, numbers) = (&encoded.layout, &encoded.views);
    let (run, columns, unit) = (layout.run(), lights.ncols(), numbers.unit());
    // One light after the other, times what 16-bit numbers are multiplied by.
    let planes: Vec<f32> = lights.columns().into_iter().flat_map(|l| l.into_iter().map(|x| x * unit)).collect();
    let tile = layout.shape.lights * run;
    let mut views = vec![0f32; layout.clusters() * columns * run];
    count.multiply_add(numbers.len());
    count.factors((0..numbers.len()).map(|at| numbers.stored(at) * unit));
    views.par_chunks_mut((columns * run).max(1)).enumerate().for_each_init(Vec::new, |buffer, (cluster, out)| {
        let own = numbers.unpack(cluster * tile..(cluster + 1) * tile, 0, buffer);
        let mut sums = vec![0f64; out.len()];
        kernel::project(own, run, &planes, &mut sums);
        for (i, (y, sum)) in out.iter_mut().zip(sums).enumerate() {
            let (place, j) = (i % run / layout.components, i % layout.components);
            let [weight, view] = encoded.scales(cluster, place, j);
            // In double precision: a product of two scales may leave the range of f32 where the result does not.
            *y = (sum * weight * (view / f64::from(unit))) as f32;
        }
    });
    count_scales(encoded, count);
    Products { views, means: sums_of_lights(encoded, lights, count) }
}

/// Multiplications by scales, one light: by those of the view maps and of the weights, which are multiplied first where there are both.
fn count_scales<C: Count>(encoded: &EncodedSlf, count: &mut C) {
    let (layout, unit) = (&encoded.layout, f64::from(encoded.views.unit()));
    let [of_surface, of_views] = [&encoded.surface, &encoded.views].map(|numbers| numbers.scales().is_some());
    if !of_views && !of_surface {
        return;
    }
    for cluster in 0..layout.clusters() {
        for i in 0..layout.run() {
            let [weight, view] = encoded.scales(cluster, i / layout.components, i % layout.components);
            if of_views && of_surface {
                count.multiply(1);
                count.factors(std::iter::once(weight as f32));
            }
            count.multiply(1);
            count.factors(std::iter::once((weight * (view / unit)) as f32));
        }
    }
}

/// Σ_d l_d for each cluster, light and channel, times the scale of the means.
fn sums_of_lights<C: Count>(encoded: &EncodedSlf, lights: ArrayView2<f32>, count: &mut C) -> Vec<f32> {
    let sum = |column: ndarray::ArrayView1<f32>| column.iter().map(|x| f64::from(*x)).sum::<f64>();
    let sums: Vec<f64> = lights.columns().into_iter().map(sum).collect();
    count.add(lights.nrows());
    let layout = &encoded.layout;
    let mut means = Vec::with_capacity(layout.mean_vectors() * sums.len());
    for cluster in 0..layout.clusters() {
        for sum in &sums {
            let of_channel = |place: usize| encoded.means.scale(cluster * layout.channels() + place);
            means.extend((0..layout.channels()).map(|place| (sum * f64::from(of_channel(place))) as f32));
        }
    }
    if let Some(scales) = encoded.means.scales() {
        count.multiply(scales.len());
        count.factors(scales.iter().copied());
    }
    means
}

/// Stage 2: the texels from `first` on; `out` is texels x channels x lights.
fn combine<C: Count>(
    encoded: &EncodedSlf,
    products: &Products,
    lights: usize,
    first: usize,
    out: &mut [f32],
    buffer: &mut Vec<f32>,
    count: &mut C,
) {
    let (layout, k) = (&encoded.layout, encoded.layout.components);
    let (channels, run) = (layout.shape.responses, layout.run());
    let texels = out.len() / (channels * lights);
    let weights = encoded.surface.unpack(layout.weight(first, 0)..layout.weight(first + texels, 0), 0, buffer);
    for (i, out) in out.chunks_exact_mut(channels * lights).enumerate() {
        for (channel, out) in out.chunks_exact_mut(lights).enumerate() {
            let (cluster, place) = layout.cluster(&encoded.ids, first + i, channel);
            let own = &weights[layout.weight(i, channel)..][..k];
            let mean = encoded.means.stored((first + i) * channels + channel);
            count.multiply_add(1 + k);
            count.factors(std::iter::once(mean).chain(own.iter().copied()));
            for (light, y) in out.iter_mut().enumerate() {
                let at = cluster * lights + light;
                let sum = mean * products.means[at * layout.channels() + place];
                *y = sum + kernel::dot(own, &products.views[at * run + place * k..][..k]);
            }
        }
    }
}
