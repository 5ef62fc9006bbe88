//! From where the pictures of an origin are taken.

use super::field::SeenField;
use super::scenery::Scenery;
use crate::operator::Operator;
use crate::scenes;
use crate::suite::Origin;
use ndarray::ArrayView2;
use prt_transfer::image::Image;
use prt_transfer::scene::camera::{Camera, Film};
use prt_transfer::scene::shading::Shading;
use prt_transfer::scene::view::View;
use prt_transfer::{Progress, ResponseBasis};

/// Degrees from +x towards +y at which the camera stands where nobody says, and above the horizon.
pub const AZIMUTH: f64 = 30.0;
/// See [`AZIMUTH`].
pub const ELEVATION: f64 = 15.0;
/// Degrees that the shorter side of the picture spans.
pub const FIELD_OF_VIEW: f64 = 40.0;
/// Samples along an edge of a pixel.
pub const SAMPLES: usize = 4;
/// Pixels of a picture that a bench takes.
pub const SIZE: [usize; 2] = [256, 192];

/// What is seen of an origin, whatever lights it and whatever compressed its matrix.
pub struct Viewpoint {
    subject: Subject,
    coverage: Vec<f32>,
}

enum Subject {
    /// A mesh, lit by transfer.
    Mesh { scenery: Box<Scenery>, view: Box<View>, shading: Shading },
    /// A shape whose light field is known.
    Field(SeenField),
}

impl Viewpoint {
    /// The whole scene of an origin, as `prt render --crop` sees it, in so many pixels; `responses` are those of its matrix. `None` for a matrix
    /// file, of which no scene is known, and for a surface that fills no pixel.
    pub fn of(
        origin: &Origin,
        responses: &ResponseBasis,
        [width, height]: [usize; 2],
        progress: &dyn Progress,
    ) -> anyhow::Result<Option<Viewpoint>> {
        let film = Film { width, height, field_of_view: FIELD_OF_VIEW };
        let viewpoint = match origin {
            Origin::Matrix(_) => return Ok(None),
            Origin::Scene { scene, vertices, up, spec } => {
                let scenery = Scenery::new(scenes::load(scene, *vertices, *up)?.0)?;
                let camera = Camera::framing(scenery.mesh(), AZIMUTH, ELEVATION, film)?;
                let view = scenery.view(camera.cropped(&scenery.mesh().positions)?, SAMPLES, progress)?;
                // Only light by local directions leaves the reflectance open.
                let open = matches!(responses, ResponseBasis::LocalDirections { .. });
                let shading = Shading::new(responses, open.then_some(&spec.brdf))?;
                let coverage = view.coverage();
                Viewpoint {
                    subject: Subject::Mesh { scenery: Box::new(scenery), view: Box::new(view), shading },
                    coverage,
                }
            }
            Origin::Field { world, shape, .. } => {
                let (field, coverage) = SeenField::new(world, shape, film)?;
                Viewpoint { subject: Subject::Field(field), coverage }
            }
        };
        Ok(Some(viewpoint).filter(|v| v.coverage.contains(&1.0)))
    }

    /// For every pixel the share of its samples that meet the surface.
    pub fn coverage(&self) -> &[f32] {
        &self.coverage
    }

    /// Whether light falls on what is seen; a light field has its own within it.
    pub fn is_lit(&self) -> bool {
        matches!(self.subject, Subject::Mesh { .. })
    }

    /// Linear radiance before black: of the origin's matrix or one like it, under a light as its responses expect it (lights x 3; see
    /// [`ResponseBasis::light`]), which a light field does not look at.
    pub fn image(&self, matrix: &dyn Operator, light: ArrayView2<f32>) -> anyhow::Result<Image> {
        match &self.subject {
            Subject::Mesh { scenery, view, shading } => {
                Ok(scenery.image(view, shading, matrix.relit(light)?.view(), |_| [0.0; 3])?)
            }
            Subject::Field(field) => field.image(matrix),
        }
    }
}
