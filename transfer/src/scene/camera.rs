//! A pinhole camera in a world whose z axis is up.

use crate::error::{Error, Result};
use crate::mesh::Mesh;
use glam::{DMat3, DVec2, DVec3, Vec3};

/// Most pixels along a side of a picture.
pub const MAX_SIDE: usize = 1 << 14;

/// What a camera projects onto.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Film {
    /// Pixels in a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// The angle in degrees that the shorter side spans, above 0 and below 180.
    pub field_of_view: f64,
}

/// A pinhole camera.
#[derive(Clone, Debug, PartialEq)]
pub struct Camera {
    eye: DVec3,
    width: usize,
    height: usize,
    /// From the eye to the top left corner of the film, one unit away.
    corner: DVec3,
    /// One pixel to the right on that film; one pixel down is `down`.
    right: DVec3,
    down: DVec3,
}

impl Camera {
    /// Looks at the centre of the mesh's bounds from the distance at which the sphere of all vertices around it just
    /// fits between the sides of the film. `azimuth` in degrees runs from +x towards +y, `elevation` from the horizon
    /// to the zenith (90): both say where the camera is, seen from the centre.
    ///
    /// # Errors
    /// A mesh of fewer than two different positions, angles that are not finite, and a film that [`Camera::looking`]
    /// refuses.
    pub fn framing(mesh: &Mesh, azimuth: f64, elevation: f64, film: Film) -> Result<Camera> {
        mesh.check_positions()?;
        film.check()?;
        for (name, angle) in [("azimuth", azimuth), ("elevation", elevation)] {
            if !angle.is_finite() {
                return Err(refuse(name, angle, "a finite angle in degrees"));
            }
        }
        let (low, high) = mesh.bounds().unwrap_or_default();
        let centre = low.as_dvec3().midpoint(high.as_dvec3());
        let radius = mesh.positions.iter().map(|p| p.as_dvec3().distance(centre)).fold(0.0, f64::max);
        if radius == 0.0 {
            let (what, expected) = ("camera: mesh to look at".into(), "at least two vertices, apart".into());
            return Err(Error::Unsupported { what, expected, found: format!("{} vertices", mesh.positions.len()) });
        }
        let ((s, c), (sine, cosine)) = (azimuth.to_radians().sin_cos(), elevation.to_radians().sin_cos());
        let towards = DVec3::new(cosine * c, cosine * s, sine);
        // The direction in which `towards` moves as the elevation grows: up, and defined at the zenith too.
        let up = DVec3::new(-sine * c, -sine * s, cosine);
        let distance = radius / (0.5 * film.field_of_view.to_radians()).sin();
        Ok(Camera::build(centre + distance * towards, -towards, up, film))
    }

    /// Looks from `eye` at `target`, upright; straight up or down, the top of the picture is towards +y.
    ///
    /// # Errors
    /// An eye that is not finite or lies at the target; a film without pixels, of more than [`MAX_SIDE`] along a side,
    /// or with a field of view that is not between 0 and 180 degrees.
    pub fn looking(eye: Vec3, target: Vec3, film: Film) -> Result<Camera> {
        film.check()?;
        let forward = (target.as_dvec3() - eye.as_dvec3()).try_normalize();
        let Some(forward) = forward.filter(|_| eye.is_finite() && target.is_finite()) else {
            return Err(refuse("eye", eye, &format!("finite, and apart from the target {target}")));
        };
        let up = DVec3::Z.reject_from_normalized(forward).try_normalize();
        Ok(Camera::build(eye.as_dvec3(), forward, up.unwrap_or(DVec3::Y), film))
    }

    /// `forward` and `up` are perpendicular unit vectors.
    fn build(eye: DVec3, forward: DVec3, up: DVec3, Film { width, height, field_of_view }: Film) -> Camera {
        let pixel = 2.0 * (0.5 * field_of_view.to_radians()).tan() / width.min(height) as f64;
        let (right, down) = (pixel * forward.cross(up), -pixel * up);
        let corner = forward - 0.5 * (width as f64 * right + height as f64 * down);
        Camera { eye, width, height, corner, right, down }
    }

    /// The part of the picture that holds all points and a twentieth more of its larger side, magnified to as many pixels.
    ///
    /// # Errors
    /// No point, points that are all in one place of the picture, and a point that is not in front of the camera.
    pub fn cropped(&self, points: &[Vec3]) -> Result<Camera> {
        let (mut low, mut high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        for &point in points {
            let place = self.place(point).ok_or_else(|| refuse("crop", point, "in front of the camera"))?;
            (low, high) = (low.min(place), high.max(place));
        }
        let film = DVec2::new(self.width as f64, self.height as f64);
        let scale = ((high - low) / film).max_element() / 0.95;
        if !(scale.is_finite() && scale > 0.0) {
            return Err(refuse("crop", points.len(), "points at different places of the picture"));
        }
        let first = low.midpoint(high) - 0.5 * scale * film;
        let corner = self.corner + first.x * self.right + first.y * self.down;
        Ok(Camera { corner, right: scale * self.right, down: scale * self.down, ..*self })
    }

    /// Where a point is seen, in pixels from the top left corner: the inverse of [`Camera::ray`], by solving
    /// `s (corner + x right + y down) = point - eye` with s > 0.
    fn place(&self, point: Vec3) -> Option<DVec2> {
        let axes = DMat3::from_cols(self.corner, self.right, self.down);
        let solved = axes.inverse() * (point.as_dvec3() - self.eye);
        (solved.x > 0.0).then(|| DVec2::new(solved.y, solved.z) / solved.x)
    }

    /// Where the camera is.
    pub fn eye(&self) -> Vec3 {
        self.eye.as_vec3()
    }

    /// Pixels in a row.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Rows.
    pub fn height(&self) -> usize {
        self.height
    }

    /// The unit direction in which the eye sees the point (x, y) of the picture: pixels from its top left corner.
    pub fn ray(&self, x: f64, y: f64) -> DVec3 {
        (self.corner + x * self.right + y * self.down).normalize()
    }
}

impl Film {
    fn check(&self) -> Result<()> {
        for (name, side) in [("width", self.width), ("height", self.height)] {
            if !(1..=MAX_SIDE).contains(&side) {
                return Err(refuse(name, side, &format!("from 1 to {MAX_SIDE} pixels")));
            }
        }
        if !(self.field_of_view > 0.0 && self.field_of_view < 180.0) {
            return Err(refuse("field of view", self.field_of_view, "above 0 and below 180 degrees"));
        }
        Ok(())
    }
}

fn refuse(name: &str, value: impl ToString, expected: &str) -> Error {
    Error::Parameter { method: "camera".into(), name: name.into(), value: value.to_string(), expected: expected.into() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::shapes;
    use proptest::prelude::*;

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(32))]
        #[test]
        fn every_vertex_is_in_the_picture_and_a_sphere_touches_its_sides(
            azimuth in -400f64..400.0, elevation in -90f64..=90.0, field_of_view in 5f64..100.0,
            width in 1usize..500, height in 1usize..500,
        ) {
            let film = Film { width, height, field_of_view };
            let sides = [width as f64, height as f64];
            let framing = |mesh: &Mesh| Camera::framing(mesh, azimuth, elevation, film).unwrap();
            let extremes = |camera: &Camera, mesh: &Mesh| {
                let places: Vec<_> = mesh.positions.iter().map(|&p| camera.place(p).unwrap().to_array()).collect();
                [0, 1].map(|k| places.iter().fold([f64::MAX, f64::MIN], |[a, b], p| [a.min(p[k]), b.max(p[k])]))
            };
            for scene in shapes::all() {
                let mesh = scene.build(300).unwrap();
                let camera = framing(&mesh);
                for (k, [low, high]) in extremes(&camera, &mesh).into_iter().enumerate() {
                    prop_assert!(low > -1e-3 * sides[k] && high < 1.001 * sides[k], "{} {} {}", scene.name, low, high);
                }
                // Cropped, it fills nineteen twentieths of one side, around the middle, and of the other no more.
                let cropped = camera.cropped(&mesh.positions).unwrap();
                let filled = [0, 1].map(|k| {
                    let [low, high] = extremes(&cropped, &mesh)[k].map(|place| place / sides[k]);
                    assert!((low + high - 1.0).abs() < 1e-9, "{} {low} {high}", scene.name);
                    high - low
                });
                prop_assert!((filled[0].max(filled[1]) - 0.95).abs() < 1e-9, "{} {:?}", scene.name, filled);
            }
            let shorter = usize::from(height < width);
            let sphere = shapes::sphere(24);
            let [low, high] = extremes(&framing(&sphere), &sphere)[shorter];
            prop_assert!(low < 0.02 * sides[shorter] && high > 0.98 * sides[shorter], "{} {}", low, high);
        }
    }

    #[test]
    fn directions_are_those_of_the_words() {
        let film = Film { width: 40, height: 20, field_of_view: 60.0 };
        let camera = Camera::looking(Vec3::new(2.0, 0.0, 1.0), Vec3::new(0.0, 0.0, 1.0), film).unwrap();
        let near = |x: f64, y: f64, expected: DVec3| {
            let found = camera.ray(x, y);
            assert!((found - expected.normalize()).length() < 1e-12, "{found} {expected}");
        };
        // 60 degrees from the top edge to the bottom one; seen along -x, right is +y.
        let half = 30f64.to_radians().tan();
        near(20.0, 10.0, DVec3::NEG_X);
        near(20.0, 0.0, DVec3::new(-1.0, 0.0, half));
        near(40.0, 10.0, DVec3::new(-1.0, 2.0 * half, 0.0));
        // The same place told by angles.
        let mut mesh = shapes::sphere(20);
        mesh.positions.iter_mut().for_each(|p| p.z += 1.0);
        let framing = Camera::framing(&mesh, 0.0, 0.0, film).unwrap();
        assert!((framing.eye() - Vec3::new(2.0, 0.0, 1.0)).length() < 1e-3, "{}", framing.eye());
        assert!((framing.ray(3.0, 4.0) - camera.ray(3.0, 4.0)).length() < 1e-9);
        // From above, the top of the picture is away from the azimuth.
        let above = Camera::framing(&mesh, 90.0, 90.0, film).unwrap();
        assert!(above.ray(20.0, 0.0).y < -0.4 && above.ray(20.0, 10.0).z < -0.999_999);
        let down = Camera::looking(Vec3::Z, Vec3::ZERO, film).unwrap();
        assert!(down.ray(20.0, 0.0).y > 0.4);
    }

    #[test]
    fn a_crop_sees_what_was_seen_there_before() {
        let film = Film { width: 40, height: 20, field_of_view: 60.0 };
        let camera = Camera::looking(Vec3::new(3.0, 1.0, 2.0), Vec3::ZERO, film).unwrap();
        let points = [Vec3::ZERO, Vec3::new(0.3, 0.4, 0.5), Vec3::new(-0.2, 0.1, 0.0)];
        let cropped = camera.cropped(&points).unwrap();
        assert_eq!((cropped.eye(), cropped.width(), cropped.height()), (camera.eye(), 40, 20));
        for point in points {
            let place = cropped.place(point).unwrap();
            let ray = cropped.ray(place.x, place.y);
            assert!((ray - (point.as_dvec3() - camera.eye).normalize()).length() < 1e-9);
        }
        for points in [&[][..], &points[..1], &[Vec3::ZERO, Vec3::new(9.0, 3.0, 6.0)]] {
            assert!(camera.cropped(points).unwrap_err().to_string().contains("crop"));
        }
    }

    #[test]
    fn what_cannot_be_looked_at_is_refused_with_the_number() {
        let film = Film { width: 4, height: 4, field_of_view: 40.0 };
        let sphere = shapes::sphere(1);
        let refused = |mesh: &Mesh, azimuth: f64, film: Film, part: &str| {
            let message = Camera::framing(mesh, azimuth, 0.0, film).unwrap_err().to_string();
            assert!(message.contains(part), "{message}");
        };
        refused(&Mesh::default(), 0.0, film, "found 0 vertices");
        refused(&Mesh { positions: vec![Vec3::ONE], ..Mesh::default() }, 0.0, film, "found 1 vertices");
        refused(&sphere, f64::NAN, film, "azimuth=NaN");
        refused(&sphere, 0.0, Film { width: 0, ..film }, "width=0");
        refused(&sphere, 0.0, Film { height: MAX_SIDE + 1, ..film }, "height=16385");
        refused(&sphere, 0.0, Film { field_of_view: 180.0, ..film }, "field of view=180");
        assert!(Camera::looking(Vec3::ONE, Vec3::ONE, film).is_err());
        assert!(Camera::looking(Vec3::INFINITY, Vec3::ONE, film).is_err());
    }
}
