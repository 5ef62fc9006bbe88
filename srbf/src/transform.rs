//! `srbf`: the light transform onto spherical radial basis functions.

mod bound;
mod lobes;
mod lower;
mod moments;
mod params;
mod reach;
mod ridge;

pub use bound::BoundSrbf;
pub use params::{Centers, Coordinates, Ridge, SrbfParams};

use lobes::Lobes;
use prt_transfer::basis::Direction;
use prt_transfer::{Configure, LightBasis, Result, Source, Transform};

/// The light transform from texels to lobes (Tsai and Shih 2006, section 4: uniform representation of transfer).
///
/// A row holds the moments T_k = ∫ f dω over texels. It is replaced by those of the nearest sum of lobes: T̃_k = Σ_j c_j B_jk with the
/// moments `B_jk` = ∫ G_j dω of the lobes, and c minimising the error over the sphere Σ_k (T_k - T̃_k)²/dω_k:
///
/// ```text
/// c = (G + ridge)⁻¹ B D⁻¹ T,   G = B D⁻¹ Bᵀ,   D = diag(dω)
/// ```
///
/// G is the Gram matrix of the lobes averaged over texels, G + ridge = L Lᵀ. With `coordinates=lobes` a row of C is c and a light's
/// coefficients are B x. With `coordinates=orthonormal` a row of C is Lᵀc = L⁻¹ B D⁻¹ T and a light's coefficients are L⁻¹ B x: T̃ is the
/// same, and (without a ridge) a squared error of a row of C is the same error over the sphere, however nearly dependent the lobes are.
///
/// Without a ridge T̃ projects onto itself and no other sum of lobes is nearer. `ridge=auto` adds none where the condition of G is below
/// 1e8, which it is at the default bandwidth wherever there are several texels to a lobe; [`BoundSrbf::ridge`] says what was added.
pub struct Srbf {
    params: SrbfParams,
    /// Those of [`Centers::Given`].
    given: Option<Lobes>,
}

impl Srbf {
    /// Lobes of `params.kernel` at `centers`, with a bandwidth of each. `params.centers` becomes [`Centers::Given`]: files list the
    /// lobes. Lobes that coincide are told apart by the ridge alone.
    ///
    /// # Errors
    /// No centre or more than 4096; numbers of centres and bandwidths that differ; a centre that is not of length 1 within 1e-6;
    /// bandwidths outside [`crate::Kernel::bandwidths`]; `params.bandwidth` other than none.
    pub fn with_centers(params: SrbfParams, centers: Vec<Direction>, bandwidths: Vec<f64>) -> Result<Srbf> {
        let given = Lobes::new(params.kernel, centers, bandwidths)?;
        let srbf = Srbf::new(SrbfParams { centers: Centers::Given, ..params })?;
        Ok(Srbf { given: Some(given), ..srbf })
    }
}

impl Configure for Srbf {
    type Params = SrbfParams;
    fn new(params: SrbfParams) -> Result<Srbf> {
        params::check(&params)?;
        Ok(Srbf { params, given: None })
    }
    fn params(&self) -> &SrbfParams {
        &self.params
    }
}

impl Transform for Srbf {
    type Bound = BoundSrbf;

    fn bind(&self, basis: &LightBasis) -> Result<BoundSrbf> {
        let lobes = self.given.clone().map_or_else(|| Lobes::of(&self.params), Ok)?;
        BoundSrbf::new(&self.params, lobes, self.params.ridge, basis)
    }

    fn restore(&self, basis: &LightBasis, source: &mut Source) -> Result<BoundSrbf> {
        let lobes = match self.params.centers {
            Centers::Count(_) => Lobes::of(&self.params)?,
            Centers::Given => Lobes::read(self.params.kernel, source)?,
        };
        BoundSrbf::new(&self.params, lobes, bound::read_ridge(&self.params, source)?, basis)
    }
}
