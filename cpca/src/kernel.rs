//! The sums that relighting spends its time in: each sample's weights times the products of its cluster.
//!
//! The same code is compiled twice, once for processors with AVX2 and FMA. Its loops are over arrays of a constant number of floats, which a
//! compiler turns into vectors.

use crate::layout::Layout;
use prt_transfer::Count;

/// Floats of a product that are summed up together where it is longer.
const LANES: usize = 24;

/// R of every cluster: for its mean and each of its components responses x channels floats.
pub(crate) struct Products<'a> {
    layout: &'a Layout,
    values: Vec<f32>,
    /// Responses x channels.
    width: usize,
    /// Floats from one product to the next: more than the width where that makes whole vectors of them.
    stride: usize,
}

impl<'a> Products<'a> {
    /// Of `values`, products one after the other.
    pub(crate) fn new(values: Vec<f32>, width: usize, layout: &'a Layout) -> Products<'a> {
        let stride = match width {
            2..=4 => 4,
            5..=7 => 8,
            width => width,
        };
        if stride == width {
            return Products { layout, values, width, stride };
        }
        let mut padded = vec![0f32; layout.vectors() * stride];
        let pairs = padded.chunks_exact_mut(stride).zip(values.chunks_exact(width));
        pairs.for_each(|(to, from)| to[..width].copy_from_slice(from));
        Products { layout, values: padded, width, stride }
    }

    pub(crate) fn width(&self) -> usize {
        self.width
    }

    /// Weights of samples in these clusters.
    pub(crate) fn weights_of(&self, clusters: &[u32]) -> usize {
        clusters.iter().map(|&k| self.layout.components(k as usize)).sum()
    }

    #[inline(always)]
    fn of(&self, cluster: usize, components: usize) -> &[f32] {
        let first = self.layout.first_vector(cluster) * self.stride;
        &self.values[first..first + (1 + components) * self.stride]
    }
}

/// `out` (samples x width) = R_0 + Σ_j w_j R_j of each sample's cluster; `weights` are those of all samples, one after the other.
pub(crate) fn combine<C: Count>(
    products: &Products,
    clusters: &[u32],
    weights: &[f32],
    out: &mut [f32],
    count: &mut C,
) {
    #[cfg(target_arch = "x86_64")]
    if is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma") {
        // SAFETY: the processor has the features.
        return unsafe { combine_avx2(products, clusters, weights, out, count) };
    }
    by_width::<false, C>(products, clusters, weights, out, count);
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma")]
fn combine_avx2<C: Count>(products: &Products, clusters: &[u32], weights: &[f32], out: &mut [f32], count: &mut C) {
    by_width::<true, C>(products, clusters, weights, out, count);
}

/// Chooses how a sample is added up, once for all samples.
#[inline(always)]
fn by_width<const FMA: bool, C: Count>(p: &Products, k: &[u32], w: &[f32], out: &mut [f32], count: &mut C) {
    match p.width {
        1 => each(p, k, w, out, count, |w, r, y: &mut [f32; 1]| *y = [dot::<FMA>(w, r)]),
        2 => each(p, k, w, out, count, |w, r, y: &mut [f32; 2]| *y = first(narrow::<4, FMA>(w, r))),
        3 => each(p, k, w, out, count, |w, r, y: &mut [f32; 3]| *y = first(narrow::<4, FMA>(w, r))),
        4 => each(p, k, w, out, count, |w, r, y: &mut [f32; 4]| *y = narrow::<4, FMA>(w, r)),
        5 => each(p, k, w, out, count, |w, r, y: &mut [f32; 5]| *y = first(narrow::<8, FMA>(w, r))),
        6 => each(p, k, w, out, count, |w, r, y: &mut [f32; 6]| *y = first(narrow::<8, FMA>(w, r))),
        7 => each(p, k, w, out, count, |w, r, y: &mut [f32; 7]| *y = first(narrow::<8, FMA>(w, r))),
        _ => each_sample(p, k, w, out.chunks_exact_mut(p.width), count, wide::<FMA>),
    }
}

#[inline(always)]
fn each<const W: usize, C: Count>(
    products: &Products,
    clusters: &[u32],
    weights: &[f32],
    out: &mut [f32],
    count: &mut C,
    sum: impl Fn(&[f32], &[f32], &mut [f32; W]),
) {
    each_sample(products, clusters, weights, out.as_chunks_mut::<W>().0.iter_mut(), count, sum);
}

/// Hands `sum` the weights of each sample, the products of its cluster and its output.
#[inline(always)]
fn each_sample<'y, Y: ?Sized + 'y, C: Count>(
    products: &Products,
    clusters: &[u32],
    weights: &[f32],
    out: impl Iterator<Item = &'y mut Y>,
    count: &mut C,
    sum: impl Fn(&[f32], &[f32], &mut Y),
) {
    let mut rest = weights;
    for (&cluster, y) in clusters.iter().zip(out) {
        let components = products.layout.components(cluster as usize);
        let (own, after) = rest.split_at(components);
        rest = after;
        count.multiply_add(components * products.width);
        count.factors(own.iter().flat_map(|&w| std::iter::repeat_n(w, products.width)));
        sum(own, products.of(cluster as usize, components), y);
    }
}

/// `sums` += `weight` · `product`. A loop and not a closure: what is not inlined would not be compiled for the processor at hand.
#[inline(always)]
fn add<const L: usize, const FMA: bool>(sums: &mut [f32; L], weight: f32, product: &[f32; L]) {
    for i in 0..L {
        // Where there is no instruction for it, `mul_add` is a call.
        sums[i] = if FMA { weight.mul_add(product[i], sums[i]) } else { weight * product[i] + sums[i] };
    }
}

#[inline(always)]
fn first<const W: usize, const L: usize>(lanes: [f32; L]) -> [f32; W] {
    let mut first = [0.0; W];
    first.copy_from_slice(&lanes[..W]);
    first
}

/// One float a product: eight components at a time.
#[inline(always)]
fn dot<const FMA: bool>(weights: &[f32], products: &[f32]) -> f32 {
    let (mean, products) = (products[0], &products[1..]);
    let (eights, tail) = weights.as_chunks::<8>();
    let (of_eights, of_tail) = products.as_chunks::<8>();
    let mut sums = [0f32; 8];
    for (w, r) in eights.iter().zip(of_eights) {
        for i in 0..8 {
            sums[i] = if FMA { w[i].mul_add(r[i], sums[i]) } else { w[i] * r[i] + sums[i] };
        }
    }
    let mut four = [0f32; 4];
    for i in 0..4 {
        four[i] = sums[i] + sums[i + 4];
    }
    let mut sum = [(four[0] + four[2]) + (four[1] + four[3]) + mean];
    for (&w, &r) in tail.iter().zip(of_tail) {
        add::<1, FMA>(&mut sum, w, &[r]);
    }
    sum[0]
}

/// As many floats a product as a vector has.
#[inline(always)]
fn narrow<const L: usize, const FMA: bool>(weights: &[f32], products: &[f32]) -> [f32; L] {
    let (products, _) = products.as_chunks::<L>();
    let mut sums = products[0];
    for (&w, r) in weights.iter().zip(&products[1..]) {
        add::<L, FMA>(&mut sums, w, r);
    }
    sums
}

/// Eight floats a product or more.
#[inline(always)]
fn wide<const FMA: bool>(weights: &[f32], products: &[f32], out: &mut [f32]) {
    let (width, mut at) = (out.len(), 0);
    while width - at >= LANES {
        part::<LANES, FMA>(weights, products, at, out);
        at += LANES;
    }
    while at < width {
        // The last eight may be some that are there already: they come out the same.
        let from = at.min(width - 8);
        part::<8, FMA>(weights, products, from, out);
        at = from + 8;
    }
}

/// `L` floats of each product, from `at` on.
#[inline(always)]
fn part<const L: usize, const FMA: bool>(weights: &[f32], products: &[f32], at: usize, out: &mut [f32]) {
    let width = out.len();
    let mut sums = [0f32; L];
    sums.copy_from_slice(&products[at..at + L]);
    let mut from = at;
    for &w in weights {
        from += width;
        add::<L, FMA>(&mut sums, w, &products[from..from + L].as_chunks::<L>().0[0]);
    }
    out[at..at + L].copy_from_slice(&sums);
}
