//! Blends of a compressed light field. Texels of one cluster share what they see of its view map:
//! `Σ_t w_t Σ_d w_d F[t, d] = Σ_t w_t μ_t Σ_d w_d + Σ_c (Σ_t∈c w_t U_t) · (Σ_d w_d V_c[d])`.

use super::RadianceField;
use crate::EncodedSlf;
use prt_transfer::numbers::Numbers;

/// Components that are added up together.
const LANES: usize = 8;
/// Texels whose clusters are compared.
const TEXELS: usize = 8;

impl RadianceField for EncodedSlf {
    fn texels(&self) -> usize {
        self.layout.shape.samples
    }
    fn directions(&self) -> usize {
        self.layout.shape.lights
    }
    fn blend(&self, texels: &[(u32, f32)], directions: &[(u32, f32)]) -> [f32; 3] {
        let shape = self.layout.shape;
        assert!(directions.iter().all(|&(d, _)| (d as usize) < shape.lights), "directions of the field");
        let (fields, channels) = (self.layout.fields(), shape.responses.min(3));
        let directions = (directions, directions.iter().map(|d| d.1).sum::<f32>());
        let mut sums = [0f32; 3];
        for texels in texels.chunks(TEXELS) {
            // All channels have the clusters of one field, or each its own.
            for first in 0..fields.min(channels) {
                let own = if fields == 1 { 0..channels } else { first..first + 1 };
                self.by_cluster(texels, first, |cluster, members| {
                    for (place, channel) in own.clone().enumerate() {
                        sums[channel] += self.of_cluster(cluster, (channel, place), members, directions);
                    }
                });
            }
        }
        // A grey field is so in all channels.
        (channels..3).for_each(|channel| sums[channel] = sums[channels - 1]);
        sums
    }
}

impl EncodedSlf {
    /// Hands over each cluster that some of at most [`TEXELS`] texels are in, with those.
    #[inline(always)]
    fn by_cluster(&self, texels: &[(u32, f32)], channel: usize, mut hand: impl FnMut(usize, &[(u32, f32)])) {
        let mut clusters = [0; TEXELS];
        for (cluster, &(texel, _)) in clusters.iter_mut().zip(texels) {
            *cluster = self.layout.cluster(&self.ids, texel as usize, channel).0;
        }
        for (i, &cluster) in clusters[..texels.len()].iter().enumerate() {
            if clusters[..i].contains(&cluster) {
                continue;
            }
            let (mut members, mut count) = ([(0, 0.0); TEXELS], 0);
            for (texel, _) in texels[i..].iter().zip(&clusters[i..]).filter(|(_, other)| **other == cluster) {
                members[count] = *texel;
                count += 1;
            }
            hand(cluster, &members[..count]);
        }
    }

    /// `Σ_t w_t μ_t Σ_d w_d + (Σ_t w_t U_t) · (Σ_d w_d V[d])` for texels of one cluster; `whole` is Σ_d w_d.
    #[inline(always)]
    fn of_cluster(
        &self,
        cluster: usize,
        (channel, place): (usize, usize),
        texels: &[(u32, f32)],
        (directions, whole): (&[(u32, f32)], f32),
    ) -> f32 {
        let (layout, channels) = (&self.layout, self.layout.shape.responses);
        let mut mean = 0.0;
        for &(texel, weight) in texels {
            mean += weight * self.means.stored(texel as usize * channels + channel);
        }
        let mut sum = whole * mean * self.means.scale(cluster * layout.channels() + place);
        for first in (0..layout.components).step_by(LANES) {
            let count = LANES.min(layout.components - first);
            let (mut weights, mut view) = ([0f32; LANES], [0f32; LANES]);
            for &(texel, weight) in texels {
                add(&mut weights, weight, &self.surface, layout.weight(texel as usize, channel) + first, count);
            }
            for &(direction, weight) in directions {
                let at = layout.view(cluster, direction as usize) + place * layout.components + first;
                add(&mut view, weight, &self.views, at, count);
            }
            if self.surface.scales().is_some() || self.views.scales().is_some() {
                self.scale(&mut view[..count], (cluster, place), first);
            }
            sum += dot(&weights, &view);
        }
        sum
    }

    /// What is seen of view maps, times the scales of both maps.
    #[inline(never)]
    fn scale(&self, view: &mut [f32], (cluster, place): (usize, usize), first: usize) {
        for (j, view) in view.iter_mut().enumerate() {
            let [of_weight, of_view] = self.scales(cluster, place, first + j);
            // In double precision: a product with one scale may leave the range of `f32`.
            *view = (f64::from(*view) * of_view * of_weight) as f32;
        }
    }
}

/// Σ a_i b_i, in pairs: each addition waits for few others.
#[inline(always)]
fn dot(a: &[f32; LANES], b: &[f32; LANES]) -> f32 {
    let mut terms = [0f32; LANES];
    for i in 0..LANES {
        terms[i] = a[i] * b[i];
    }
    let mut four = [0f32; LANES / 2];
    for i in 0..LANES / 2 {
        four[i] = terms[i] + terms[i + LANES / 2];
    }
    (four[0] + four[2]) + (four[1] + four[3])
}

/// `sums` += `weight` times what is stored from `at` on.
#[inline(always)]
fn add(sums: &mut [f32; LANES], weight: f32, numbers: &Numbers, at: usize, count: usize) {
    if let Numbers::F32(values) = numbers
        && let Some(eight) = values[at..at + count].first_chunk::<LANES>()
    {
        for i in 0..LANES {
            sums[i] += weight * eight[i];
        }
    } else {
        add_each(sums, weight, numbers, at, count);
    }
}

/// As [`add`], for fewer numbers or narrow ones.
#[inline(never)]
fn add_each(sums: &mut [f32; LANES], weight: f32, numbers: &Numbers, at: usize, count: usize) {
    sums[..count].iter_mut().enumerate().for_each(|(i, sum)| *sum += weight * numbers.stored(at + i));
}
