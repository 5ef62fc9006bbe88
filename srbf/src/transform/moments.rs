//! Integrals of lobes over texels.

use super::lobes::Lobes;
use super::reach::{RULES, Reach};
use crate::lobe::dot;
use ndarray::Array2;
use prt_transfer::basis::Direction;
use prt_transfer::quadrature::{Texels, gauss_legendre};
use prt_transfer::transform::wrong_basis;
use prt_transfer::{Error, LightBasis, Result};
use rayon::prelude::*;

/// Texels: a cubemap of 6 x 836 x 836.
const MAX_TEXELS: u64 = 1 << 22;

/// Texels times lobes that are looked at.
const MAX_PAIRS: u64 = 1 << 26;

/// Moments that are held: 96 MiB.
const MAX_MOMENTS: u64 = 1 << 24;

/// Kernels that are evaluated: seconds.
const MAX_EVALUATIONS: u64 = 1 << 29;

/// B: `∫ G_j dω` over texel k in sr, for the lobes j that reach it.
pub(super) struct Moments {
    /// Those of texel k are at `offsets[k]..offsets[k + 1]`.
    offsets: Vec<u32>,
    /// Ascending within a texel.
    lobes: Vec<u16>,
    values: Vec<f32>,
}

impl Moments {
    /// Those of `lobes` on the texels of `basis`: in a test within 1e-6 of the lobe's largest. A Gaussian is left out where it is below
    /// 1e-8 of its peak on all of a texel; an Abel-Poisson kernel nowhere is.
    pub(super) fn new(lobes: &Lobes, basis: &LightBasis) -> Result<Moments> {
        let texels = Texels::of(basis).ok_or_else(|| wrong_basis("srbf", "texels: cubemap or latlong", basis))?;
        within(MAX_TEXELS, basis.lights() as u64, "texels", basis)?;
        within(MAX_PAIRS, basis.lights() as u64 * lobes.len() as u64, "texels x lobes", basis)?;
        let reach = Reach::new(lobes, texels)
            .ok_or_else(|| wrong_basis("srbf", "texels over which 256 nodes integrate the narrowest lobe", basis))?;
        let directions = basis.directions().unwrap_or_default();
        let counts: Vec<[u64; 2]> = directions.par_iter().map(|&texel| reach.count(texel)).collect();
        let [moments, evaluations] = counts.iter().fold([0; 2], |sum, c| [sum[0] + c[0], sum[1] + c[1]]);
        within(MAX_MOMENTS, moments, "moments", basis)?;
        within(MAX_EVALUATIONS, evaluations, "kernels to integrate", basis)?;
        let rules: Vec<Rule> = (0..RULES).map(|i| gauss_legendre(2 << i)).collect();
        let (mut offsets, mut all) = (Vec::with_capacity(counts.len() + 1), Vec::with_capacity(moments as usize));
        let lists: Vec<Vec<(u16, f32)>> = directions
            .par_iter()
            .enumerate()
            .map_init(Vec::new, |points, (k, &texel)| {
                points.clear();
                points.resize(RULES, Vec::new());
                let near = reach.near(texel);
                near.map(|(j, rule)| (j as u16, integral(lobes, j, points_of(points, rule, &rules, texels, k)) as f32))
                    .collect()
            })
            .collect();
        offsets.push(0);
        for list in lists {
            all.extend(list);
            offsets.push(all.len() as u32);
        }
        Ok(Moments {
            offsets,
            lobes: all.iter().map(|(lobe, _)| *lobe).collect(),
            values: all.iter().map(|(_, value)| *value).collect(),
        })
    }

    /// Lobes and moments of texel `k`.
    pub(super) fn of(&self, k: usize) -> (&[u16], &[f32]) {
        let range = self.offsets[k] as usize..self.offsets[k + 1] as usize;
        (&self.lobes[range.clone()], &self.values[range])
    }

    /// Memory of all.
    pub(super) fn bytes(&self) -> usize {
        size_of_val(&self.offsets[..]) + size_of_val(&self.lobes[..]) + size_of_val(&self.values[..])
    }

    /// B D⁻¹ Bᵀ of `n` lobes.
    pub(super) fn gram(&self, inverse_angles: &[f64], n: usize) -> Array2<f64> {
        let mut by_lobe: Vec<Vec<(usize, f64)>> = vec![Vec::new(); n];
        for (k, inverse_angle) in inverse_angles.iter().enumerate() {
            let (lobes, values) = self.of(k);
            lobes.iter().zip(values).for_each(|(&j, &b)| by_lobe[j as usize].push((k, f64::from(b) * inverse_angle)));
        }
        let mut gram = Array2::zeros((n, n));
        let rows: Vec<&mut [f64]> = gram.outer_iter_mut().filter_map(|row| row.into_slice()).collect();
        rows.into_par_iter().zip(&by_lobe).for_each(|(row, texels)| {
            for &(k, factor) in texels {
                let (lobes, values) = self.of(k);
                lobes.iter().zip(values).for_each(|(&j, &b)| row[j as usize] += factor * f64::from(b));
            }
        });
        gram
    }
}

fn within(limit: u64, found: u64, what: &str, basis: &LightBasis) -> Result<()> {
    if found <= limit {
        Ok(())
    } else {
        Err(Error::TooLarge { what: format!("{what} of srbf on {basis}"), limit, found })
    }
}

/// Nodes and weights of a rule.
type Rule = Vec<(f64, f64)>;

/// Directions and solid angles that integrate over texel `k` by a rule, made where they are not there yet.
fn points_of<'a>(
    made: &'a mut [Vec<(Direction, f64)>],
    rule: usize,
    rules: &[Rule],
    texels: Texels,
    k: usize,
) -> &'a [(Direction, f64)] {
    if made[rule].is_empty() {
        let nodes = &rules[rule];
        let point = |&(s, s_weight): &(f64, f64), &(t, t_weight): &(f64, f64)| {
            let (direction, density) = texels.point(k, 0.5 + 0.5 * s, 0.5 + 0.5 * t);
            (direction, 0.25 * s_weight * t_weight * density)
        };
        made[rule] = nodes.iter().flat_map(|t| nodes.iter().map(move |s| point(s, t))).collect();
    }
    &made[rule]
}

/// ∫ G_j dω by these points.
fn integral(lobes: &Lobes, j: usize, points: &[(Direction, f64)]) -> f64 {
    let (center, bandwidth) = (lobes.centers[j], lobes.bandwidths[j]);
    let value = |direction: &Direction| lobes.kernel.value(dot(center, *direction), bandwidth);
    points.iter().map(|(direction, weight)| weight * value(direction)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernel::Kernel;

    /// The same integral over n x n parts of a texel, each by eight nodes along an edge.
    fn fine(lobes: &Lobes, j: usize, texels: Texels, k: usize, n: usize) -> f64 {
        let nodes = gauss_legendre(8);
        let mut sum = 0.0;
        for (a, b) in (0..n * n).map(|part| (part % n, part / n)) {
            for (s, s_weight) in &nodes {
                for (t, t_weight) in &nodes {
                    let place = |part: usize, node: f64| (part as f64 + 0.5 + 0.5 * node) / n as f64;
                    let (direction, density) = texels.point(k, place(a, *s), place(b, *t));
                    let mu = dot(lobes.centers[j], direction);
                    sum += 0.25 * s_weight * t_weight * density * lobes.kernel.value(mu, lobes.bandwidths[j]);
                }
            }
        }
        sum / (n * n) as f64
    }

    /// The largest error of a lobe's moments as a share of its largest moment.
    fn worst(kernel: Kernel, bandwidth: f64, basis: &LightBasis) -> f64 {
        // Off the centres of texels, on an edge, on a corner.
        let corner = (1.0f64 / 3.0).sqrt();
        let centers = vec![[0.48, 0.6, 0.64], [0.0, 0.6, 0.8], [corner; 3], [0.0, 0.0, 1.0]];
        let lobes = Lobes::new(kernel, centers, vec![bandwidth; 4]).unwrap();
        let (moments, texels) = (Moments::new(&lobes, basis).unwrap(), Texels::of(basis).unwrap());
        let width = match kernel {
            Kernel::Gaussian => 1.0 / bandwidth.sqrt(),
            Kernel::AbelPoisson => 1.0 - bandwidth,
        };
        let parts = 2 + (texels.edge() / width).ceil() as usize;
        let (mut errors, mut largest) = ([0f64; 4], [0f64; 4]);
        for k in 0..basis.lights() {
            let (near, values) = moments.of(k);
            for j in 0..4 {
                let exact = fine(&lobes, j, texels, k, parts);
                let value = near.iter().position(|&n| n as usize == j).map_or(0.0, |at| values[at]);
                errors[j] = errors[j].max((f64::from(value) - exact).abs());
                largest[j] = largest[j].max(exact);
            }
        }
        errors.iter().zip(largest).map(|(error, largest)| error / largest).fold(0.0, f64::max)
    }

    #[test]
    fn the_cheap_rule_agrees_with_fine_quadrature_for_every_width_of_lobe_against_texel() {
        let bandwidths = [
            (Kernel::Gaussian, [0.01, 1.0, 12.0, 163.0, 1500.0]),
            (Kernel::AbelPoisson, [0.01, 0.5, 0.8, 0.925, 0.96]),
        ];
        for basis in ["cubemap:1", "cubemap:5", "latlong:3x5"] {
            let basis: LightBasis = basis.parse().unwrap();
            for (kernel, bandwidths) in bandwidths {
                for bandwidth in bandwidths {
                    let worst = worst(kernel, bandwidth, &basis);
                    assert!(worst < 1e-6, "{kernel:?} {bandwidth} on {basis}: {worst:e}");
                }
            }
        }
    }

    #[test]
    fn moments_of_a_lobe_add_up_to_its_integral() {
        for (kernel, bandwidth) in [(Kernel::Gaussian, 163.0), (Kernel::Gaussian, 2e3), (Kernel::AbelPoisson, 0.95)] {
            let lobes = Lobes::new(kernel, vec![[0.48, 0.6, 0.64]], vec![bandwidth]).unwrap();
            for basis in ["cubemap:16", "latlong:32x16"] {
                let moments = Moments::new(&lobes, &basis.parse().unwrap()).unwrap();
                let sum: f64 = moments.values.iter().map(|v| f64::from(*v)).sum();
                let share = sum / kernel.integral(bandwidth);
                assert!((share - 1.0).abs() < 1e-6, "{kernel:?} {bandwidth} on {basis}: {share}");
                let everywhere = moments.values.len() == moments.offsets.len() - 1;
                assert_eq!(everywhere, kernel == Kernel::AbelPoisson, "a Gaussian ends");
            }
        }
    }

    #[test]
    fn what_would_take_too_much_memory_or_time_is_refused_before_it_does() {
        let refused = |kernel, bandwidth, count: usize, basis: &str| {
            let centers = crate::icosphere::centers(count).unwrap();
            let lobes = Lobes::new(kernel, centers, vec![bandwidth; count]).unwrap();
            Moments::new(&lobes, &basis.parse().unwrap()).err().unwrap().to_string()
        };
        assert!(refused(Kernel::Gaussian, 160.0, 12, "cubemap:2048").contains("texels of srbf"));
        assert!(refused(Kernel::Gaussian, 160.0, 642, "cubemap:256").contains("texels x lobes"));
        assert!(refused(Kernel::AbelPoisson, 0.5, 2562, "cubemap:64").contains("moments"));
        assert!(refused(Kernel::AbelPoisson, 0.9999, 12, "cubemap:2").starts_with("light basis for srbf"));
        assert!(refused(Kernel::Gaussian, 1e5, 12, "cubemap:1").contains("256 nodes"));
        assert!(refused(Kernel::Gaussian, 160.0, 12, "sh:3").starts_with("light basis for srbf"));
    }
}
