//! The bases of a cluster, and their fit to its members (Tsai and Shih 2006, §5.2.3).

use super::products::{self, Leading};
use super::slabs::Slabs;
use ndarray::{Array2, ArrayView2};
use prt_transfer::Result;

/// Bases of a cluster, orthonormal in single precision.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Basis {
    /// U_lightᵀ: R_light x lights.
    pub(crate) light: Array2<f32>,
    /// V: R_vert x (views · R_light), row j being uf⁻¹ of a matrix of views x R_light.
    pub(crate) dual: Array2<f32>,
}

/// Ranks that a cluster's bases may have at most.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ranks {
    pub(crate) light: usize,
    pub(crate) sample: usize,
}

impl Basis {
    /// R_vert.
    pub(crate) fn rank(&self) -> usize {
        self.dual.nrows()
    }

    /// What samples are made of: R_vert orthonormal rows of views x lights numbers, uf⁻¹(V_j) · U_lightᵀ.
    pub(crate) fn whole(&self, views: usize) -> Array2<f32> {
        let (rank, light) = (self.rank(), self.light.nrows());
        if rank == 0 {
            return Array2::zeros((0, views * self.light.ncols()));
        }
        let dual = self.dual.view().into_shape_with_order((rank * views, light)).expect("rows of views x lights");
        let rows = products::times(dual, self.light.view());
        rows.into_shape_with_order((rank, views * self.light.ncols())).expect("rows of views x lights")
    }

    /// A cluster that holds nothing.
    pub(crate) fn nothing(lights: usize) -> Basis {
        Basis { light: Array2::zeros((0, lights)), dual: Array2::zeros((0, 0)) }
    }

    /// The projected weights of samples (Eq. 17), samples x R_vert.
    pub(crate) fn weights(&self, members: &Slabs) -> Array2<f32> {
        if self.rank() == 0 {
            return Array2::zeros((members.count, 0));
        }
        products::times_transposed(members.with_lights(self.light.view()).by_sample(), self.dual.view())
    }

    /// The Gram matrix of mode 1 of the members in the light basis and the vertex basis (Eq. 19), responses x responses. `reduced` are the
    /// members in the view basis that the dual basis belongs to.
    pub(crate) fn gram_of_views(&self, members: &Slabs, reduced: &Slabs) -> Array2<f64> {
        let weights = self.weights(reduced);
        if weights.is_empty() {
            return Array2::zeros((members.views, members.views));
        }
        let vertex = vertex_basis(weights);
        let rows = products::times(vertex.view(), members.by_sample());
        let values = rows.into_raw_vec_and_offset().0;
        let moved = Slabs::lent(&values, [vertex.nrows(), members.views, members.lights]);
        moved.with_lights(self.light.view()).gram_of_views()
    }
}

/// Bases for the `members` by alternating least squares (the optimal 3-mode SVD with the view basis given): `sweeps` of it from the light
/// basis `start`, or from that of the members alone; and the sum of squares that they keep, of which no sweep loses any.
///
/// The dual basis is updated last. Eq. 16 normalises the rows of uf_3(Z_c), which are orthogonal then only: with X = uf_3 of the members
/// in the light basis, X = U Σ Vᵀ, they are Σ Vᵀ cut to R_vert rows, and its polar factor is Vᵀ. Where the members are fewer than
/// R_vert, or span less, there are as few rows.
pub(crate) fn fit(
    members: &Slabs,
    start: Option<ArrayView2<f32>>,
    ranks: Ranks,
    sweeps: usize,
) -> Result<(Basis, f64)> {
    let all = ranks.light >= members.lights;
    let mut light = match start {
        _ if all => Array2::eye(members.lights),
        Some(start) => start.to_owned(),
        None => products::leading(members.by_light(), ranks.light)?.single(),
    };
    for _ in 0..if all { 0 } else { sweeps } {
        let projected = members.with_lights(light.view());
        let dual = products::leading(projected.by_sample(), ranks.sample)?;
        let moved = in_vertices(members, &projected, &dual);
        light = products::leading(moved.view(), ranks.light)?.single();
    }
    let projected = members.with_lights(light.view());
    let dual = products::leading(projected.by_sample(), ranks.sample)?;
    Ok((Basis { dual: dual.single(), light }, dual.squares.iter().sum()))
}

/// U_vertᵀ · members, mode 2 unfolded: R_vert · views rows of lights.
fn in_vertices(members: &Slabs, projected: &Slabs, dual: &Leading) -> Array2<f32> {
    let vertex = vertex_basis(products::times_transposed(projected.by_sample(), dual.single().view()));
    let rows = products::times(vertex.view(), members.by_sample());
    let shape = (rows.nrows() * members.views, members.lights);
    rows.into_shape_with_order(shape).expect("rows of views x lights")
}

/// U_vertᵀ = Σ⁻¹ (X Vᵀ)ᵀ of weights X Vᵀ (members x R_vert), whose columns are orthogonal.
fn vertex_basis(weights: Array2<f32>) -> Array2<f32> {
    let mut rows = weights.t().as_standard_layout().into_owned();
    for mut row in rows.outer_iter_mut() {
        let norm = row.iter().map(|v| f64::from(*v).powi(2)).sum::<f64>().sqrt();
        row.mapv_inplace(|v| if norm > 0.0 { (f64::from(v) / norm) as f32 } else { 0.0 });
    }
    rows
}

#[cfg(test)]
mod tests {
    use super::*;
    use prt_transfer::random::Random;

    fn noise(count: usize, views: usize, lights: usize) -> Vec<f32> {
        let mut random = Random(3);
        (0..count * views * lights).map(|_| random.normal() as f32).collect()
    }

    fn kept(members: &Slabs, basis: &Basis) -> f64 {
        let weights = products::times_transposed(members.by_sample(), basis.whole(3).view());
        weights.iter().map(|w| f64::from(*w).powi(2)).sum()
    }

    #[test]
    fn bases_are_orthonormal_and_no_sweep_loses_anything() {
        let (values, ranks) = (noise(40, 3, 20), Ranks { light: 6, sample: 5 });
        let members = Slabs::lent(&values, [40, 3, 20]);
        let mut before = 0.0;
        for sweeps in 0..5 {
            let (basis, told) = fit(&members, None, ranks, sweeps).unwrap();
            assert!((told - kept(&members, &basis)).abs() < 1e-5 * told);
            let whole = basis.whole(3);
            assert!((whole.dot(&whole.t()) - Array2::<f32>::eye(5)).iter().all(|d| d.abs() < 1e-5));
            assert!((basis.light.dot(&basis.light.t()) - Array2::<f32>::eye(6)).iter().all(|d| d.abs() < 1e-5));
            let now = kept(&members, &basis);
            assert!(now >= before * (1.0 - 1e-6), "{now} after {before}");
            before = now;
        }
        let (one, of_one) = fit(&members, None, ranks, 1).unwrap();
        let (_, of_two) = fit(&members, Some(one.light.view()), ranks, 1).unwrap();
        assert!(of_two >= of_one * (1.0 - 1e-6));
    }

    #[test]
    fn ranks_above_what_members_have_hold_everything_in_fewer_rows() {
        let values = noise(4, 3, 20);
        let members = Slabs::lent(&values, [4, 3, 20]);
        let square: f64 = members.squares().iter().sum();
        for light in [20, 99, 12] {
            let (basis, _) = fit(&members, None, Ranks { light, sample: 24 }, 2).unwrap();
            assert_eq!(basis.rank(), 4);
            assert!((kept(&members, &basis) - square).abs() < 1e-5 * square, "{light}");
        }
        let zeros = vec![0.0; 60];
        let (basis, _) = fit(&Slabs::lent(&zeros, [1, 3, 20]), None, Ranks { light: 5, sample: 5 }, 2).unwrap();
        assert_eq!((basis.rank(), basis.whole(3).dim()), (0, (0, 60)));
    }
}
