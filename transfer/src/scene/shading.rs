//! From responses to what is seen: radiance that leaves a point towards a view.

use crate::error::{Error, Result};
use crate::hemisphere::local_directions;
use crate::responses::{Coordinates, ResponseBasis};
use crate::scene::brdf::Brdf;
use crate::scene::frames::Frame;
use crate::scene::separable::{SeparableBrdf, Terms};
use crate::scene::terms::VIEWS;
use crate::sh::HemisphereSh;
use glam::{DVec3, Vec3};
use ndarray::ArrayView2;
use rayon::prelude::*;
use std::f64::consts::PI;

/// Sine of the elevation above the horizon to which the direction to the eye is raised.
const GRAZING: f32 = 0.01;

/// The weights `w_r(v)` of radiance towards a view v: `Σ_r w_r(v) y_r` for a sample's responses y.
pub struct Shading {
    responses: usize,
    weights: Weights,
}

enum Weights {
    /// Of irradiance.
    Irradiance { reflectance: f64 },
    /// Of light that arrives around each direction.
    Local { directions: Vec<DVec3>, brdf: Brdf },
    /// Of exit radiance.
    Exit { sh: HemisphereSh, coordinates: Coordinates },
    /// Of the terms of a BRDF.
    Terms(Box<SeparableBrdf>),
}

impl Shading {
    /// What `responses` make of a view. `brdf` is that of the surface, where responses leave it open: any for local
    /// directions, Lambert for irradiance; a white Lambert surface where none is given.
    ///
    /// # Errors
    /// Responses of which nothing is known but their number, and a BRDF where the responses have theirs already.
    pub fn new(responses: &ResponseBasis, brdf: Option<&Brdf>) -> Result<Shading> {
        let refuse = |expected: &str, found: String| Error::Unsupported {
            what: format!("shading of responses {responses}"),
            expected: expected.into(),
            found,
        };
        let white = || "lambert".parse::<Brdf>();
        let weights = match responses {
            ResponseBasis::Plain { .. } => {
                let known = "a known meaning: irradiance, local:EDGE, exit:N or terms:N:BRDF";
                return Err(refuse(known, "numbers alone".into()));
            }
            ResponseBasis::Radiance { .. } => {
                return Err(refuse("responses of vertices", "radiance of texels, a surface light field".into()));
            }
            ResponseBasis::Irradiance { brdf: Some(_) } | ResponseBasis::Exit { .. } | ResponseBasis::Terms { .. }
                if brdf.is_some() =>
            {
                let found = brdf.map(ToString::to_string).unwrap_or_default();
                return Err(refuse("no other BRDF than the one in the matrix", found));
            }
            ResponseBasis::Irradiance { brdf: own } => {
                let given = || brdf.cloned().map_or_else(white, Ok);
                match own.as_ref().map_or_else(given, |own| own.parse())? {
                    lambert @ Brdf::Lambert(_) => Weights::Irradiance { reflectance: lambert.albedo(DVec3::Z) / PI },
                    other => return Err(refuse("lambert, which irradiance is enough for", other.to_string())),
                }
            }
            ResponseBasis::LocalDirections { edge } => Weights::Local {
                directions: local_directions(*edge).into_iter().map(|d| Vec3::from(d).as_dvec3()).collect(),
                brdf: brdf.cloned().map_or_else(white, Ok)?,
            },
            ResponseBasis::Exit { coefficients, coordinates } => {
                Weights::Exit { sh: HemisphereSh::new(*coefficients)?, coordinates: *coordinates }
            }
            ResponseBasis::Terms { terms, brdf } => {
                Weights::Terms(Box::new(SeparableBrdf::new(&brdf.parse()?, Terms::Count(*terms), VIEWS)?))
            }
        };
        Ok(Shading { responses: responses.responses(), weights })
    }

    /// Responses of a sample.
    pub fn responses(&self) -> usize {
        self.responses
    }

    /// w_r of a local view direction, unit and above the horizon (see [`towards`]).
    ///
    /// # Panics
    /// Where `out` has not one place for each response.
    pub fn weights(&self, view: DVec3, out: &mut [f64]) {
        assert_eq!(out.len(), self.responses, "one weight for each response");
        match &self.weights {
            Weights::Irradiance { reflectance } => out[0] = *reflectance,
            Weights::Local { directions, brdf } => {
                out.iter_mut().zip(directions).for_each(|(w, d)| *w = brdf.evaluate(view, *d) * d.z);
            }
            Weights::Exit { sh, coordinates: Coordinates::Harmonics } => sh.evaluate(view.to_array(), out),
            Weights::Exit { sh, coordinates: Coordinates::Orthonormal } => {
                sh.evaluate_orthonormal(view.to_array(), out)
            }
            Weights::Terms(separable) => separable.view(view.as_vec3(), out),
        }
    }

    /// RGB radiance of every point towards `eye`, from `output`, (points · responses) x 3.
    ///
    /// # Errors
    /// Arrays that do not fit.
    pub fn colours(
        &self,
        points: &[Vec3],
        frames: &[Frame],
        eye: Vec3,
        output: ArrayView2<f32>,
    ) -> Result<Vec<[f32; 3]>> {
        Error::expect_size("frames beside points", points.len(), frames.len())?;
        Error::expect_size("rows of relit output", points.len() * self.responses, output.nrows())?;
        Error::expect_size("channels of relit output", 3, output.ncols())?;
        let colour = |weights: &mut Vec<f64>, point: usize| {
            self.weights(towards(&frames[point], eye - points[point]).as_dvec3(), weights);
            let mut sum = [0f64; 3];
            for (row, weight) in (point * self.responses..).zip(weights.iter()) {
                sum.iter_mut().zip(output.row(row)).for_each(|(sum, y)| *sum += weight * f64::from(*y));
            }
            sum.map(|c| c as f32)
        };
        let weights = || vec![0f64; self.responses];
        Ok((0..points.len()).into_par_iter().map_init(weights, colour).collect())
    }
}

/// The unit local direction to an eye in the direction `world` (of any length but 0), for a BRDF. At a silhouette an
/// interpolated normal leans away from an eye that sees its face: such directions are raised to just above the horizon,
/// where BRDFs are defined, so that no dark rim appears.
pub fn towards(frame: &Frame, world: Vec3) -> Vec3 {
    let local = frame.to_local(world.normalize_or(frame.normal));
    local.with_z(local.z.max(GRAZING)).normalize()
}
