//! Bidirectional reflectance distribution functions (BRDFs): how a surface scatters light, in 1/sr.
//!
//! They are grey: one number for a pair of directions. Directions are unit vectors in local coordinates, z along the
//! normal, and both point away from the surface: `light` to where light comes from, `view` to where it goes. Every
//! model is reciprocal (`light` and `view` may be exchanged, bit for bit), 0 where either direction is at the horizon
//! or below, and unchanged when both directions are mirrored in x, or in y. Every model has a diffuse part (albedo/π),
//! and its diffuse and specular weights add up to at most 1: none reflects more than it receives ([`Brdf::albedo`] ≤
//! 1).
//!
//! ```
//! use prt_transfer::scene::brdf::Brdf;
//! let brdf: Brdf = "cook-torrance:roughness=0.2".parse()?;
//! assert_eq!(brdf.to_string(), "cook-torrance:roughness=0.2");
//! # Ok::<(), prt_transfer::Error>(())
//! ```

mod cook_torrance;
mod half_vector;
mod lambert;
mod phong;
mod sample;
#[cfg(test)]
mod tests;
mod ward;

pub use cook_torrance::{CookTorrance, CookTorranceParams};
pub use lambert::{Lambert, LambertParams};
pub use phong::{Phong, PhongParams};
pub(super) use sample::cosine_hemisphere;
pub use ward::{Ward, WardParams};

use crate::codec::Configure;
use crate::error::{Error, Result};
use crate::label::Stage;
use crate::method::{About, about};
use crate::params::Params;
use glam::DVec3;
use std::f64::consts::FRAC_1_PI;
use std::fmt;
use std::str::FromStr;

/// A direction whose cosine with the normal is no greater is at the horizon: lobes that grow without bound towards it
/// stay finite.
const HORIZON: f64 = 1e-12;

/// A reflectance model with its parameters, named by a stage such as `ward:alpha_x=0.1:alpha_y=0.3`.
#[derive(Clone, Debug, PartialEq)]
pub enum Brdf {
    /// `lambert`
    Lambert(Lambert),
    /// `phong`
    Phong(Phong),
    /// `cook-torrance`
    CookTorrance(CookTorrance),
    /// `ward`
    Ward(Ward),
}

impl Brdf {
    /// Every model with its parameters.
    pub fn all() -> Vec<About> {
        vec![about::<LambertParams>(), about::<PhongParams>(), about::<CookTorranceParams>(), about::<WardParams>()]
    }

    /// The reflectance in 1/sr; symmetric in its arguments (see the module). They must be unit vectors: nothing checks
    /// it.
    #[inline]
    pub fn evaluate(&self, view: DVec3, light: DVec3) -> f64 {
        if view.z <= HORIZON || light.z <= HORIZON {
            return 0.0;
        }
        match self {
            Brdf::Lambert(model) => model.evaluate(),
            Brdf::Phong(model) => model.evaluate(view, light),
            Brdf::CookTorrance(model) => model.evaluate(view, light),
            Brdf::Ward(model) => model.evaluate(view, light),
        }
    }

    /// The reflectance without its diffuse part, in 1/sr.
    #[inline]
    pub fn lobe(&self, view: DVec3, light: DVec3) -> f64 {
        if view.z <= HORIZON || light.z <= HORIZON {
            return 0.0;
        }
        match self {
            Brdf::Lambert(_) => 0.0,
            Brdf::Phong(model) => model.lobe(view, light),
            Brdf::CookTorrance(model) => model.lobe(view, light),
            Brdf::Ward(model) => model.lobe(view, light),
        }
    }

    /// The directional albedo ∫ ρ(`view`, ω) cos θ dω over the hemisphere, the part of the light from `view` that is
    /// reflected. Diffuse parts are exact; lobes are integrated in coordinates in which they are smooth, to 2e-3 of
    /// their weight, and to rounding where the horizon does not cut them. 0 at the horizon and below.
    pub fn albedo(&self, view: DVec3) -> f64 {
        if view.z <= HORIZON {
            return 0.0;
        }
        match self {
            Brdf::Lambert(model) => model.params().albedo,
            Brdf::Phong(model) => model.albedo(view),
            Brdf::CookTorrance(model) => model.albedo(view),
            Brdf::Ward(model) => model.albedo(view),
        }
    }

    /// Its name with every parameter, also those at their defaults: what a file may hold for ever.
    pub fn in_full(&self) -> String {
        match self {
            Brdf::Lambert(model) => in_full(model.params()),
            Brdf::Phong(model) => in_full(model.params()),
            Brdf::CookTorrance(model) => in_full(model.params()),
            Brdf::Ward(model) => in_full(model.params()),
        }
    }

    /// Whether only the difference of the azimuths matters.
    pub fn is_isotropic(&self) -> bool {
        match self {
            Brdf::Ward(model) => model.params().alpha_x == model.params().alpha_y,
            _ => true,
        }
    }

    /// The albedo of the diffuse part.
    pub(crate) fn diffuse(&self) -> f64 {
        match self {
            Brdf::Lambert(model) => model.params().albedo,
            Brdf::Phong(model) => model.params().diffuse,
            Brdf::CookTorrance(model) => model.params().diffuse,
            Brdf::Ward(model) => model.params().diffuse,
        }
    }

    /// The scale of the slopes of half vectors over which the lobe varies; 1 where there is no lobe.
    pub(crate) fn width(&self) -> f64 {
        match self {
            Brdf::Lambert(_) => 1.0,
            // cosⁿ α ≈ exp(-n α²/2), and the half vector turns by α/2.
            Brdf::Phong(model) => (2.0 * model.params().exponent).sqrt().recip(),
            Brdf::CookTorrance(model) => model.params().roughness,
            Brdf::Ward(model) => model.params().alpha_x.min(model.params().alpha_y),
        }
    }

    /// The scale of the azimuths about the mirror direction over which the lobe varies, for cosines `view` and `light`;
    /// at most π.
    pub(crate) fn azimuth_width(&self, view: f64, light: f64) -> f64 {
        // A lobe about the mirror direction is as broad everywhere; one of slopes H_xy/H_z narrows with H_z towards the
        // horizon.
        let width = match self {
            Brdf::Lambert(_) | Brdf::Phong(_) => 2.0 * self.width(),
            Brdf::CookTorrance(_) | Brdf::Ward(_) => self.width() * (view + light),
        };
        // A turn t of the azimuth moves directions by t sin θ.
        let sines = ((1.0 - view * view) * (1.0 - light * light)).max(0.0).powf(0.25);
        width / sines.max(width * FRAC_1_PI)
    }
}

impl FromStr for Brdf {
    type Err = Error;

    fn from_str(text: &str) -> Result<Brdf> {
        let stage: Stage = text.parse()?;
        Ok(match stage.name.as_str() {
            LambertParams::NAME => Brdf::Lambert(Lambert::new(Params::from_stage(&stage)?)?),
            PhongParams::NAME => Brdf::Phong(Phong::new(Params::from_stage(&stage)?)?),
            CookTorranceParams::NAME => Brdf::CookTorrance(CookTorrance::new(Params::from_stage(&stage)?)?),
            WardParams::NAME => Brdf::Ward(Ward::new(Params::from_stage(&stage)?)?),
            name => {
                let known = Brdf::all().iter().map(|a| a.name).collect::<Vec<_>>().join(", ");
                return Err(Error::Unknown { what: "BRDF", name: name.into(), known });
            }
        })
    }
}

impl fmt::Display for Brdf {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Brdf::Lambert(model) => model.params().to_stage().fmt(f),
            Brdf::Phong(model) => model.params().to_stage().fmt(f),
            Brdf::CookTorrance(model) => model.params().to_stage().fmt(f),
            Brdf::Ward(model) => model.params().to_stage().fmt(f),
        }
    }
}

fn in_full<P: Params>(params: &P) -> String {
    let pairs = P::fields().into_iter().zip(params.values());
    pairs.fold(P::NAME.to_string(), |text, (field, value)| format!("{text}:{}={value}", field.name))
}

/// Refuses a parameter outside `low..=high`.
fn check<P: Params>(name: &str, value: f64, low: f64, high: f64) -> Result<()> {
    if (low..=high).contains(&value) {
        return Ok(());
    }
    Err(P::refuse(name, value, format!("from {low} to {high}")))
}

/// Refuses weights below 0, and those that together reflect more than they receive.
fn check_weights<P: Params>(diffuse: f64, specular: f64) -> Result<()> {
    check::<P>("diffuse", diffuse, 0.0, 1.0)?;
    check::<P>("specular", specular, 0.0, 1.0)?;
    // Weights such as 0.7 and 0.3 may miss 1 by a rounding.
    if diffuse + specular > 1.0 + 1e-12 {
        return Err(P::refuse("specular", specular, format!("at most {}: 1 less diffuse={diffuse}", 1.0 - diffuse)));
    }
    Ok(())
}
