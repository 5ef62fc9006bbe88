//! The sums that relighting spends its time in: each sample's weights times the products of its cluster.
//!
//! The same code is compiled twice, once for processors with AVX2 and FMA. Its loops are over arrays of a constant
//! number of floats, which a compiler turns into vectors. Products of few floats take several components at a time:
//! those of a cluster are filled up with zeros to a multiple of it, and meet weights of the next sample there, so that
//! clusters of different numbers of components rarely differ in the number of rounds, which a processor would
//! mispredict.

use crate::layout::Layout;
use prt_transfer::Count;
use pulp::{Simd, WithSimd};

/// Floats of a product from which on they fill vectors by themselves.
const MANY: usize = 8;

/// Components at a time where a product is a single float, and where it is up to seven.
const OF_ONE: usize = 8;
const OF_FEW: usize = 4;

/// Weights that [`combine`] may read behind the last one.
pub(crate) const SPARE: usize = OF_ONE - 1;

/// R of every cluster: for its mean and each of its components responses x channels floats.
pub(crate) struct Products {
    values: Vec<f32>,
    clusters: Vec<Place>,
    /// Responses x channels.
    width: usize,
    /// Components of every cluster and those of whole rounds, where all have as many.
    even: Option<[usize; 2]>,
}

/// Of a cluster.
struct Place {
    /// Its first float; components, of which the last may be zeros, follow the mean.
    first: usize,
    floats: usize,
    components: usize,
    /// Components of whole rounds.
    taken: usize,
}

impl Products {
    /// Of `values`, products of `width` floats one after the other.
    pub(crate) fn new(values: Vec<f32>, width: usize, layout: &Layout) -> Products {
        // Floats of a product are whole vectors.
        let (round, stride) = match width {
            1 => (OF_ONE, 1),
            2..=4 => (OF_FEW, 4),
            5..=7 => (OF_FEW, 8),
            _ => (1, width),
        };
        let mut first = 0;
        let place = |cluster| {
            let components = layout.components(cluster);
            let taken = components.next_multiple_of(round);
            let floats = (1 + taken) * stride;
            let place = Place { first, floats, components, taken };
            first += floats;
            place
        };
        let clusters: Vec<Place> = (0..layout.clusters()).map(place).collect();
        let even = layout.even().map(|components| [components, components.next_multiple_of(round)]);
        if first == values.len() {
            return Products { values, clusters, width, even };
        }
        let mut padded = vec![0f32; first];
        let mut from = values.chunks_exact(width);
        for place in &clusters {
            let own = padded[place.first..].chunks_exact_mut(stride);
            own.zip(from.by_ref().take(1 + place.components)).for_each(|(to, from)| to[..width].copy_from_slice(from));
        }
        Products { values: padded, clusters, width, even }
    }

    pub(crate) fn width(&self) -> usize {
        self.width
    }

    /// Weights of samples in these clusters.
    pub(crate) fn weights_of(&self, clusters: &[u32]) -> usize {
        match self.even {
            Some([components, _]) => clusters.len() * components,
            None => clusters.iter().map(|&k| self.clusters[k as usize].components).sum(),
        }
    }
}

/// `out` (samples x width) = R_0 + Σ_j w_j R_j of each sample's cluster. `weights` are those of all samples one after
/// the other, and [`SPARE`] finite numbers.
pub(crate) fn combine<C: Count>(
    products: &Products,
    clusters: &[u32],
    weights: &[f32],
    out: &mut [f32],
    count: &mut C,
) {
    if products.width >= MANY {
        let mut rest = weights;
        for &cluster in clusters {
            let components = products.clusters[cluster as usize].components;
            count.multiply_add(components * products.width);
            count.factors(rest[..components].iter().flat_map(|&w| std::iter::repeat_n(w, products.width)));
            rest = &rest[components..];
        }
        return pulp::Arch::new().dispatch(Many { products, clusters, weights, out });
    }
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

/// Chooses how a sample of less than [`MANY`] floats a product is added up, once for all samples.
#[inline(always)]
fn by_width<const FMA: bool, C: Count>(p: &Products, k: &[u32], w: &[f32], out: &mut [f32], count: &mut C) {
    match p.width {
        1 => often::<1, 1, C>(p, k, w, out, count, |w, r, y| *y = [dot::<FMA>(w, r)]),
        3 => often::<3, 4, C>(p, k, w, out, count, |w, r, y| *y = few::<3, 4, FMA>(w, r)),
        2 => each::<2, C>(p, k, w, out, count, |w, r, y| *y = few::<2, 4, FMA>(w, r)),
        4 => each::<4, C>(p, k, w, out, count, |w, r, y| *y = few::<4, 4, FMA>(w, r)),
        5 => each::<5, C>(p, k, w, out, count, |w, r, y| *y = few::<5, 8, FMA>(w, r)),
        6 => each::<6, C>(p, k, w, out, count, |w, r, y| *y = few::<6, 8, FMA>(w, r)),
        _ => each::<7, C>(p, k, w, out, count, |w, r, y| *y = few::<7, 8, FMA>(w, r)),
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

/// As [`each`] for one response or colour, `L` floats a product, whose usual numbers of components are known to the
/// compiler.
#[inline(always)]
fn often<const W: usize, const L: usize, C: Count>(
    products: &Products,
    clusters: &[u32],
    weights: &[f32],
    out: &mut [f32],
    count: &mut C,
    sum: impl Fn(&[f32], &[f32], &mut [f32; W]),
) {
    let (values, out) = (products.values.as_chunks::<L>().0, out.as_chunks_mut::<W>().0);
    match products.even {
        Some([n, 4]) => alike(values.as_chunks::<5>().0, n, clusters, weights, out, count, sum),
        Some([n, 8]) => alike(values.as_chunks::<9>().0, n, clusters, weights, out, count, sum),
        Some([n, 16]) => alike(values.as_chunks::<17>().0, n, clusters, weights, out, count, sum),
        _ => each_sample(products, clusters, weights, out.iter_mut(), count, sum),
    }
}

/// As [`each_sample`] for clusters of `n` components each, which with those that fill them up and the mean are `P`
/// products of `L` floats.
#[inline(always)]
fn alike<const W: usize, const L: usize, const P: usize, C: Count>(
    table: &[[[f32; L]; P]],
    n: usize,
    clusters: &[u32],
    weights: &[f32],
    out: &mut [[f32; W]],
    count: &mut C,
    sum: impl Fn(&[f32], &[f32], &mut [f32; W]),
) {
    for (i, (&cluster, y)) in clusters.iter().zip(out).enumerate() {
        let own = &weights[i * n..i * n + P - 1];
        count.multiply_add(n * W);
        count.factors(own[..n].iter().flat_map(|&w| std::iter::repeat_n(w, W)));
        sum(own, table[cluster as usize].as_flattened(), y);
    }
}

/// Hands `sum` the weights of each sample, those of whole rounds, the products of its cluster and its output.
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
        let Place { first, floats, components, taken } = products.clusters[cluster as usize];
        count.multiply_add(components * products.width);
        count.factors(rest[..components].iter().flat_map(|&w| std::iter::repeat_n(w, products.width)));
        sum(&rest[..taken], &products.values[first..first + floats], y);
        rest = &rest[components..];
    }
}

/// `a` · `b` + `c`.
#[inline(always)]
fn fused<const FMA: bool>(a: f32, b: f32, c: f32) -> f32 {
    // Where there is no instruction for it, `mul_add` is a call.
    if FMA { a.mul_add(b, c) } else { a * b + c }
}

/// `sums` += `weight` · `product`. A loop and not a closure: what is not inlined would not be compiled for the
/// processor at hand.
#[inline(always)]
fn add<const L: usize, const FMA: bool>(sums: &mut [f32; L], weight: f32, product: &[f32; L]) {
    for i in 0..L {
        sums[i] = fused::<FMA>(weight, product[i], sums[i]);
    }
}

/// One float a product.
#[inline(always)]
fn dot<const FMA: bool>(weights: &[f32], products: &[f32]) -> f32 {
    let (mean, products) = (products[0], &products[1..]);
    let mut sums = [0f32; OF_ONE];
    for (w, r) in weights.as_chunks::<OF_ONE>().0.iter().zip(products.as_chunks::<OF_ONE>().0) {
        for i in 0..OF_ONE {
            sums[i] = fused::<FMA>(w[i], r[i], sums[i]);
        }
    }
    let mut four = [0f32; 4];
    for i in 0..4 {
        four[i] = sums[i] + sums[i + 4];
    }
    (four[0] + four[2]) + (four[1] + four[3]) + mean
}

/// `W` floats a product, `L` with those that fill it up.
#[inline(always)]
fn few<const W: usize, const L: usize, const FMA: bool>(weights: &[f32], products: &[f32]) -> [f32; W] {
    let products = products.as_chunks::<L>().0;
    let (mut even, mut odd) = (products[0], [0f32; L]);
    for (w, r) in weights.as_chunks::<OF_FEW>().0.iter().zip(products[1..].as_chunks::<OF_FEW>().0) {
        add::<L, FMA>(&mut even, w[0], &r[0]);
        add::<L, FMA>(&mut odd, w[1], &r[1]);
        add::<L, FMA>(&mut even, w[2], &r[2]);
        add::<L, FMA>(&mut odd, w[3], &r[3]);
    }
    let mut sums = [0f32; W];
    for i in 0..W {
        sums[i] = even[i] + odd[i];
    }
    sums
}

/// Eight floats a product or more, for all samples: vectors of the processor's own width.
struct Many<'a> {
    products: &'a Products,
    clusters: &'a [u32],
    weights: &'a [f32],
    out: &'a mut [f32],
}

impl WithSimd for Many<'_> {
    type Output = ();
    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let (width, mut rest) = (self.products.width, self.weights);
        for (&cluster, out) in self.clusters.iter().zip(self.out.chunks_exact_mut(width)) {
            let Place { first, floats, components, .. } = self.products.clusters[cluster as usize];
            let (mean, products) = self.products.values[first..first + floats].split_at(width);
            let whole = width / S::F32_LANES * S::F32_LANES;
            for at in (0..whole).step_by(S::F32_LANES) {
                let vector = |floats: &[f32]| S::as_simd_f32s(&floats[at..at + S::F32_LANES]).0[0];
                let mut sum = vector(mean);
                for (&w, product) in rest[..components].iter().zip(products.chunks_exact(width)) {
                    sum = simd.mul_add_e_f32s(simd.splat_f32s(w), vector(product), sum);
                }
                S::as_mut_simd_f32s(&mut out[at..at + S::F32_LANES]).0[0] = sum;
            }
            if whole < width {
                let (at, end) = (whole, width);
                let mut sum = simd.partial_load_f32s(&mean[at..end]);
                for (&w, product) in rest[..components].iter().zip(products.chunks_exact(width)) {
                    sum = simd.mul_add_e_f32s(simd.splat_f32s(w), simd.partial_load_f32s(&product[at..end]), sum);
                }
                simd.partial_store_f32s(&mut out[at..end], sum);
            }
            rest = &rest[components..];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use prt_transfer::ids::Ids;
    use prt_transfer::{NoCount, Tally};

    #[test]
    fn vector_and_portable_sums_agree_for_every_width_and_number_of_components() {
        let number = |i: usize| ((i * 37 + i * i * 11) % 101) as f32 / 50.0 - 1.0;
        let members: Vec<u32> = (0..40).map(|p| p * 7 % 3).collect();
        for components in [[0, 0, 0], [4; 3], [7; 3], [8; 3], [13; 3], [16; 3], [17; 3], [0, 9, 3], [30, 1, 8]] {
            let layout = Layout::of(&components, members.len(), &Ids::pack(&members, 3));
            for width in [1, 2, 3, 4, 5, 6, 7, 8, 9, 15, 24, 33, 72] {
                let values: Vec<f32> = (0..layout.vectors() * width).map(number).collect();
                let products = Products::new(values.clone(), width, &layout);
                let count = products.weights_of(&members);
                let weights: Vec<f32> = (0..count + SPARE).map(|i| number(i + 5)).collect();
                let (mut fast, mut plain) = (vec![9.0; 40 * width], vec![9.0; 40 * width]);
                let mut tally = Tally::default();
                combine(&products, &members, &weights, &mut fast, &mut tally);
                // From MANY floats on there is one form only.
                let portable = width < MANY;
                if portable {
                    by_width::<false, _>(&products, &members, &weights, &mut plain, &mut NoCount);
                }
                assert_eq!(tally.0.total(), (2 * count * width) as u64);
                let mut own = weights.iter();
                for (p, &k) in members.iter().enumerate() {
                    let (first, n) = (layout.first_vector(k as usize), layout.components(k as usize));
                    let own: Vec<f64> = own.by_ref().take(n).map(|&w| w.into()).collect();
                    for c in 0..width {
                        let r = |j: usize| f64::from(values[(first + j) * width + c]);
                        let sum = own.iter().enumerate().fold(r(0), |sum, (j, w)| sum + w * r(1 + j));
                        let found = [Some(fast[p * width + c]), portable.then(|| plain[p * width + c])];
                        for y in found.into_iter().flatten() {
                            assert!((f64::from(y) - sum).abs() < 1e-5, "{components:?}, width {width}: {y} for {sum}");
                        }
                    }
                }
            }
        }
    }
}
