//! The sums that relighting spends its time in: each sample's weights times the columns of its clusters, then the view basis.

use crate::layout::Place;
use ndarray::{Array2, ArrayView2};
use prt_transfer::Count;
use pulp::{Simd, WithSimd};

/// Vectors whose sums are kept in registers together.
const TOGETHER: usize = 4;

/// R of every cluster: each column channels x views numbers.
pub(crate) struct Columns {
    values: Vec<f32>,
    /// The first column of each cluster, and how many.
    clusters: Vec<[usize; 2]>,
    views: usize,
    channels: usize,
    /// Whether the view basis has been applied.
    seen: bool,
}

impl Columns {
    /// Of `rows`, for each column of each cluster views x channels.
    pub(crate) fn new(places: &[Place], rows: ArrayView2<f32>, views: usize) -> Columns {
        let channels = rows.ncols();
        let mut values = Vec::with_capacity(rows.len());
        for first in (0..rows.nrows()).step_by(views.max(1)) {
            values
                .extend((0..channels).flat_map(|channel| (first..first + views).map(move |row| rows[[row, channel]])));
        }
        let clusters = places.iter().map(|place| [place.sample, place.sample_rank]).collect();
        Columns { values, clusters, views, channels, seen: false }
    }

    /// With a view basis (responses x views) applied: columns of channels x responses.
    pub(crate) fn through(self, view: ArrayView2<f32>) -> Columns {
        let products = self.values.chunks_exact(self.views.max(1)).flat_map(|column| {
            view.outer_iter().map(|row| row.iter().zip(column).map(|(a, b)| a * b).sum::<f32>()).collect::<Vec<_>>()
        });
        Columns { values: products.collect(), views: view.nrows(), seen: true, ..self }
    }

    pub(crate) fn seen(&self) -> bool {
        self.seen
    }

    pub(crate) fn channels(&self) -> usize {
        self.channels
    }

    fn width(&self) -> usize {
        self.views * self.channels
    }

    fn of_cluster(&self, cluster: u32) -> &[f32] {
        let [first, count] = self.clusters[cluster as usize];
        &self.values[first * self.width()..(first + count) * self.width()]
    }
}

/// What samples are added up with.
pub(crate) struct Gather<'a> {
    columns: &'a Columns,
    /// views x responses, where a view basis is left to be applied.
    view: Option<Array2<f32>>,
    responses: usize,
}

impl<'a> Gather<'a> {
    /// `view` is responses x views.
    pub(crate) fn new(columns: &'a Columns, view: Option<ArrayView2<f32>>, responses: usize) -> Gather<'a> {
        Gather { columns, view: view.map(|v| v.t().as_standard_layout().into_owned()), responses }
    }

    /// `out` (samples x responses x channels) for samples with `memberships` clusters each and their weights, one after the other.
    pub(crate) fn run<C: Count>(
        &self,
        clusters: &[u32],
        memberships: usize,
        weights: &[f32],
        out: &mut [f32],
        count: &mut C,
    ) {
        self.count(clusters.len() / memberships, weights, count);
        pulp::Arch::new().dispatch(Run { gather: self, clusters, memberships, weights, out });
    }

    fn count<C: Count>(&self, samples: usize, weights: &[f32], count: &mut C) {
        let width = self.columns.width();
        count.multiply_add(weights.len() * width);
        count.factors(weights.iter().flat_map(|&w| std::iter::repeat_n(w, width)));
        if let Some(view) = &self.view {
            count.multiply_add(samples * view.len() * self.columns.channels);
            count.factors((0..samples * self.columns.channels).flat_map(|_| view.iter().copied()));
        }
    }
}

struct Run<'a> {
    gather: &'a Gather<'a>,
    clusters: &'a [u32],
    memberships: usize,
    weights: &'a [f32],
    out: &'a mut [f32],
}

impl WithSimd for Run<'_> {
    type Output = ();
    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Run { gather, clusters, memberships, weights, out } = self;
        let (columns, responses) = (gather.columns, gather.responses);
        let (channels, width) = (columns.channels, columns.width());
        let (mut sums, mut seen) = (vec![0f32; width], vec![0f32; responses * channels]);
        let mut rest = weights;
        for (own, out) in clusters.chunks_exact(memberships).zip(out.chunks_exact_mut(responses * channels)) {
            sums.fill(0.0);
            for &cluster in own {
                let of_cluster = columns.of_cluster(cluster);
                let rank = of_cluster.len() / width;
                add_products(simd, &rest[..rank], of_cluster, &mut sums);
                rest = &rest[rank..];
            }
            let planes = match &gather.view {
                None => &sums,
                Some(view) => {
                    seen.fill(0.0);
                    let view = view.as_slice().unwrap_or_default();
                    for (sums, seen) in sums.chunks_exact(columns.views).zip(seen.chunks_exact_mut(responses)) {
                        add_products(simd, sums, view, seen);
                    }
                    &seen
                }
            };
            for (channel, plane) in planes.chunks_exact(responses).enumerate() {
                out[channel..].iter_mut().step_by(channels).zip(plane).for_each(|(y, v)| *y = *v);
            }
        }
    }
}

/// `sums` += Σ_j `factors`_j · row j of `rows`.
#[inline(always)]
fn add_products<S: Simd>(simd: S, factors: &[f32], rows: &[f32], sums: &mut [f32]) {
    let width = sums.len();
    let (many, one) = (TOGETHER * S::F32_LANES, S::F32_LANES);
    let mut at = 0;
    while at + many <= width {
        block::<S, TOGETHER>(simd, factors, rows, at, sums);
        at += many;
    }
    while at + one <= width {
        block::<S, 1>(simd, factors, rows, at, sums);
        at += one;
    }
    if at < width {
        let mut sum = simd.partial_load_f32s(&sums[at..]);
        for (&factor, row) in factors.iter().zip(rows.chunks_exact(width)) {
            sum = simd.mul_add_e_f32s(simd.splat_f32s(factor), simd.partial_load_f32s(&row[at..]), sum);
        }
        simd.partial_store_f32s(&mut sums[at..], sum);
    }
}

/// As [`add_products`] for `N` vectors from `at` on.
#[inline(always)]
fn block<S: Simd, const N: usize>(simd: S, factors: &[f32], rows: &[f32], at: usize, sums: &mut [f32]) {
    let width = sums.len();
    let range = at..at + N * S::F32_LANES;
    let mut vectors = [simd.splat_f32s(0.0); N];
    let (loaded, _) = S::as_simd_f32s(&sums[range.clone()]);
    vectors.copy_from_slice(loaded);
    for (&factor, row) in factors.iter().zip(rows.chunks_exact(width)) {
        let (row, _) = S::as_simd_f32s(&row[range.clone()]);
        let factor = simd.splat_f32s(factor);
        for i in 0..N {
            vectors[i] = simd.mul_add_e_f32s(factor, row[i], vectors[i]);
        }
    }
    S::as_mut_simd_f32s(&mut sums[range]).0.copy_from_slice(&vectors);
}

#[cfg(test)]
mod tests {
    use super::*;
    use prt_transfer::Tally;

    #[test]
    fn sums_are_those_of_the_definition_for_every_width() {
        let number = |i: usize| ((i * 37 + i * i * 11) % 101) as f32 / 50.0 - 1.0;
        for (views, channels, responses) in
            [(1, 1, 1), (3, 1, 3), (4, 3, 4), (8, 3, 16), (5, 2, 7), (4, 4, 4), (33, 3, 40)]
        {
            let ranks = [3, 0, 24];
            let mut sample = 0;
            let places = ranks.map(|sample_rank| {
                let place = Place { sample, sample_rank, ..Place::default() };
                sample += sample_rank;
                place
            });
            let rows = Array2::from_shape_fn((sample * views, channels), |(i, c)| number(3 * i + c));
            let view = (channels > 1).then(|| Array2::from_shape_fn((responses, views), |(k, v)| number(k + 5 * v)));
            let columns = Columns::new(&places, rows.view(), views);
            let clusters = [0, 2, 2, 1, 2, 0, 1, 1];
            let weights: Vec<f32> =
                (0..clusters.iter().map(|&k| ranks[k as usize]).sum()).map(|i: usize| number(i + 7)).collect();
            let mut out = vec![f32::NAN; 4 * responses * channels];
            let mut tally = Tally::default();
            Gather::new(&columns, view.as_ref().map(|v| v.view()), responses)
                .run(&clusters, 2, &weights, &mut out, &mut tally);
            let through = view.as_ref().map(|v| Columns::new(&places, rows.view(), views).through(v.view()));
            let mut again = vec![f32::NAN; out.len()];
            if let Some(through) = &through {
                Gather::new(through, None, responses).run(&clusters, 2, &weights, &mut again, &mut Tally::default());
            }
            let mut own = weights.iter();
            for sample in 0..4 {
                let mut sums = Array2::<f64>::zeros((views, channels));
                for &k in &clusters[2 * sample..2 * sample + 2] {
                    let place = places[k as usize];
                    for (j, &w) in
                        (place.sample..place.sample + place.sample_rank).zip(own.by_ref().take(place.sample_rank))
                    {
                        for ((v, c), sum) in sums.indexed_iter_mut() {
                            *sum += f64::from(w) * f64::from(rows[[j * views + v, c]]);
                        }
                    }
                }
                let expected = view.as_ref().map_or(sums.clone(), |view| view.mapv(f64::from).dot(&sums));
                for ((k, c), y) in expected.indexed_iter() {
                    let at = (sample * responses + k) * channels + c;
                    assert!((f64::from(out[at]) - y).abs() < 1e-3, "{views} {channels}: {} for {y}", out[at]);
                    assert!(through.is_none() || (f64::from(again[at]) - y).abs() < 1e-3);
                }
            }
            let of_views = view.as_ref().map_or(0, |v| 4 * v.len() * channels);
            assert_eq!(tally.0.total(), 2 * (weights.len() * views * channels + of_views) as u64);
        }
    }
}
