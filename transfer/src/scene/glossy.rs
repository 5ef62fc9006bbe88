//! `glossy`: exit radiance of every vertex in harmonics on its hemisphere, linear in distant light in harmonics (Sloan,
//! Hall, Hart and Snyder 2003, §3 and appendix):
//!
//! ```text
//! M_p = A⁻¹ B A⁻¹ R_p T_p                                                        (1)
//! ```
//!
//! `T_p` takes the light to the radiance that arrives, `R_p` turns it into the vertex's frame, `A⁻¹` projects what was
//! integrated over the hemisphere onto its harmonics by least squares (A is their Gram matrix there), `B_ij = ∫∫ y_i(v)
//! y_j(s) ρ(v,s) s_z ds dv` reflects it, and `A⁻¹` projects what leaves. `A` is nearly singular (condition 1.5e5 at
//! order 5, 3.5e9 at order 8), so that nothing here inverts it: with `A = L Lᵀ` and the orthonormal functions `q = L⁻¹
//! y` the same matrix is
//!
//! ```text
//! M_p = L⁻ᵀ Q L⁻¹ R_p T_p,   Q_ij = ∫∫ q_i(v) q_j(s) ρ(v,s) s_z ds dv
//! ```
//!
//! where no step amplifies an error by more than √cond A, and without the first `L⁻ᵀ` it is the one in orthonormal
//! coordinates.

use crate::basis::LightBasis;
use crate::error::{Error, Result};
use crate::params::Params;
use crate::responses::{Coordinates, ResponseBasis};
use crate::scene::bounce::{Arrival, Interreflecting};
use crate::scene::brdf::Brdf;
use crate::scene::dense::DenseSignal;
use crate::scene::frames::Frame;
use crate::scene::moments::VisibilityMoments;
use crate::scene::reflection::reflection;
use crate::scene::shading::towards;
use crate::scene::signal::{Samples, Sampling, Surface, Visible};
use crate::sh::{HemisphereSh, Products, Rotation};
use glam::DVec3;

crate::params! {
    /// How exit radiance is represented.
    pub struct GlossyParams: "glossy" {
        /// Harmonics of exit radiance: n², or n² - 1 without l = 1, m = 0; n from 1 to 10.
        coefficients: usize = 24,
        /// Bands in which arriving radiance is projected before it is reflected, 1 to 10.
        incident: usize = 6,
        /// Bands of the light, 1 to 10.
        light: usize = 5,
    }
}

/// Exit-radiance transfer of one BRDF.
pub struct Glossy {
    params: GlossyParams,
    coordinates: Coordinates,
    samples: Samples,
    moments: VisibilityMoments,
    products: Products,
    /// Copied for each point, its factors being the same.
    rotation: Rotation,
    incident: HemisphereSh,
    exit: HemisphereSh,
    /// Q, exit x incident.
    reflection: Vec<f64>,
}

impl Glossy {
    /// Of a surface of one BRDF everywhere.
    ///
    /// # Errors
    /// Parameters out of range.
    pub fn new(params: GlossyParams, coordinates: Coordinates, brdf: &Brdf, sampling: &Sampling) -> Result<Glossy> {
        for (name, value) in [("incident", params.incident), ("light", params.light)] {
            if !(1..=HemisphereSh::MAX_ORDER).contains(&value) {
                return Err(GlossyParams::refuse(name, value, format!("from 1 to {}", HemisphereSh::MAX_ORDER)));
            }
        }
        let exit = HemisphereSh::new(params.coefficients)?;
        let incident = HemisphereSh::new(params.incident * params.incident)?;
        let samples = sampling.samples()?;
        let identity = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        Ok(Glossy {
            moments: VisibilityMoments::new(&samples, Products::bands(params.incident, params.light))?,
            products: Products::new(params.incident, params.light)?,
            rotation: Rotation::new(params.incident, identity)?,
            reflection: reflection(brdf, &exit, &incident),
            params,
            coordinates,
            samples,
            incident,
            exit,
        })
    }

    /// The functions of exit radiance towards a local direction.
    fn exit_functions(&self, view: DVec3, out: &mut [f64]) {
        match self.coordinates {
            Coordinates::Harmonics => self.exit.evaluate(view.to_array(), out),
            Coordinates::Orthonormal => self.exit.evaluate_orthonormal(view.to_array(), out),
        }
    }

    /// Reflects: moments of arriving radiance in the vertex's frame (∫ over the hemisphere, incident coefficients x
    /// lights) become exit radiance (exit coefficients x lights), which is added to `out`.
    ///
    /// # Errors
    /// A matrix of another size.
    fn reflect(&self, mut arriving: Vec<f64>, out: &mut [f32]) -> Result<()> {
        let lights = self.params.light * self.params.light;
        self.incident.project(&mut arriving)?;
        let mut leaving = vec![0f64; self.exit.coefficients() * lights];
        let rows = self.reflection.chunks_exact(self.incident.coefficients());
        for (leaving, row) in leaving.chunks_exact_mut(lights).zip(rows) {
            for (q, arriving) in row.iter().zip(arriving.chunks_exact(lights)) {
                leaving.iter_mut().zip(arriving).for_each(|(y, x)| *y += q * x);
            }
        }
        if self.coordinates == Coordinates::Harmonics {
            self.exit.to_harmonic(&mut leaving)?;
        }
        Error::expect_size("numbers of exit radiance", leaving.len(), out.len())?;
        out.iter_mut().zip(leaving).for_each(|(out, y)| *out += y as f32);
        Ok(())
    }
}

impl DenseSignal for Glossy {
    fn basis(&self) -> LightBasis {
        LightBasis::SphericalHarmonics { order: self.params.light }
    }
    fn responses(&self) -> ResponseBasis {
        ResponseBasis::Exit { coefficients: self.exit.coefficients(), coordinates: self.coordinates }
    }
    fn samples(&self) -> &Samples {
        &self.samples
    }
    fn rows_into(&self, surface: &Surface, point: usize, visible: &Visible, out: &mut [f32]) -> Result<()> {
        let lights = self.params.light * self.params.light;
        let mut moments = vec![0f64; self.moments.coefficients()];
        self.moments.sum_into(visible, &mut moments);
        let mut transfer = vec![0f64; self.incident.coefficients() * lights];
        self.products.matrix_into(&moments, &mut transfer);
        let mut rotation = self.rotation.clone();
        rotation.set(axes(&surface.frames[point]))?;
        let mut local = vec![0f64; transfer.len()];
        rotation.apply_rows(&transfer, &mut local, lights)?;
        self.reflect(local, out)
    }
}

impl Interreflecting for Glossy {
    fn bounce_into(
        &self,
        surface: &Surface,
        point: usize,
        arrivals: &[Arrival],
        leaving: &[f32],
        out: &mut [f32],
    ) -> Result<()> {
        let lights = self.params.light * self.params.light;
        let mut arriving = vec![0f64; self.incident.coefficients() * lights];
        let (mut y, mut radiance) = (vec![0f64; self.incident.coefficients()], vec![0f64; lights]);
        let mut functions = vec![0f64; self.exit.coefficients()];
        for arrival in arrivals {
            // What leaves the corners in this direction, each in its own frame.
            radiance.fill(0.0);
            for (corner, share) in arrival.corners.into_iter().zip(arrival.shares) {
                let view = towards(&surface.frames[corner as usize], -arrival.direction).as_dvec3();
                self.exit_functions(view, &mut functions);
                let rows = leaving[corner as usize * out.len()..][..out.len()].chunks_exact(lights);
                for (row, function) in rows.zip(&functions) {
                    let weight = f64::from(share) * function;
                    radiance.iter_mut().zip(row).for_each(|(r, m)| *r += weight * f64::from(*m));
                }
            }
            let local = surface.frames[point].to_local(arrival.direction).as_dvec3().normalize();
            self.incident.evaluate(local.to_array(), &mut y);
            for (arriving, y) in arriving.chunks_exact_mut(lights).zip(&y) {
                let weight = f64::from(arrival.solid_angle) * y;
                arriving.iter_mut().zip(&radiance).for_each(|(a, r)| *a += weight * r);
            }
        }
        self.reflect(arriving, out)
    }
}

/// The frame's axes as rows.
fn axes(frame: &Frame) -> [[f64; 3]; 3] {
    [frame.tangent, frame.bitangent, frame.normal].map(|axis| axis.as_dvec3().to_array())
}
