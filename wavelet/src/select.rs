//! Run-time selection of light coefficients (Ng, Ramamoorthi and Hanrahan 2003, non-linear approximation of the lighting).

use crate::largest;
use crate::pyramid;
use prt_transfer::Count;

prt_transfer::choices! {
    /// What makes a light coefficient matter. Let the light be Σ w_k ψ_k in the orthonormal basis.
    pub enum LightSelect {
        /// |w_k|: the least squared error of the light.
        Plain = "plain",
        /// |w_k| √A_k, where A_k is the area of the support of ψ_k in texels of its face. In the basis of wavelets of
        /// height 1, where the light is Σ u_k (√A_k ψ_k), this is |u_k| A_k, coefficient times area: so the area-weighted
        /// selection of Ng et al. is read here. It favours wide light over small bright sources.
        Area = "area",
    }
}

/// Sets all but the `terms` coefficients that matter most to 0; of equal ones the earlier stays. `coefficients` are those of
/// whole faces of `resolution²`.
pub(crate) fn keep_light<C: Count>(
    coefficients: &mut [f32],
    resolution: usize,
    terms: usize,
    select: LightSelect,
    count: &mut C,
) {
    if terms >= coefficients.len() {
        return;
    }
    let plain = |(k, &w): (usize, &f32)| largest::key(w, k as u32);
    let mut keys: Vec<u64> = match select {
        LightSelect::Plain => coefficients.iter().enumerate().map(plain).collect(),
        LightSelect::Area => {
            // √A is the edge of the support.
            let edge = |k: usize| pyramid::support_edge(resolution, k % (resolution * resolution)) as f32;
            count.multiply(coefficients.len());
            coefficients.iter().enumerate().map(|(k, w)| plain((k, &(w * edge(k))))).collect()
        }
    };
    largest::keep_terms(&mut keys, terms);
    let kept: Vec<(usize, f32)> =
        keys.into_iter().map(|key| largest::place(key) as usize).map(|k| (k, coefficients[k])).collect();
    coefficients.fill(0.0);
    kept.into_iter().for_each(|(k, w)| coefficients[k] = w);
}
