//! Clear sky with a sun: Preetham, Shirley and Smits, "A Practical Analytic Model for Daylight" (1999).

use super::environment::{Cap, Environment};
use glam::{DMat3, DVec3};
use std::f64::consts::PI;

/// Elevation and azimuth (from +x towards +y) of the sun in radians.
const SUN: [f64; 2] = [0.7, -0.6];
/// Turbidity of clear air, with some haze (2 is very clear, 10 hazy).
const TURBIDITY: f64 = 2.6;
/// Angular radius of the sun in radians: 6.8e-5 sr.
const SUN_RADIUS: f64 = 4.65e-3;
/// Illuminance of the sun above the atmosphere, klx.
const SUN_ILLUMINANCE: f64 = 133.8;
/// Reflectance of the ground, linear RGB.
const GROUND: DVec3 = DVec3::new(0.22, 0.20, 0.16);
/// Wavelengths in µm that stand for red, green and blue where the sun's light is dimmed.
const WAVELENGTHS: [f64; 3] = [0.61, 0.55, 0.465];

/// The sky, in units of 1 kcd/m² (linear sRGB primaries).
pub(super) fn environment() -> Environment {
    let (elevation, azimuth) = (SUN[0].sin_cos(), SUN[1].sin_cos());
    let sun = DVec3::new(elevation.1 * azimuth.1, elevation.1 * azimuth.0, elevation.0);
    let disk = Cap { centre: sun, radius: SUN_RADIUS, radiance: [0.0; 3] };
    let sunlight = SUN_ILLUMINANCE * transmittance(sun.z.asin());
    let disk = Cap { radiance: (sunlight / disk.solid_angle()).to_array(), ..disk };
    let dome = Dome::new(sun);
    // Radiance of a diffuse ground under the sun and a sky of its zenith's radiance throughout.
    let ground = GROUND * (sunlight * sun.z / PI + dome.radiance(DVec3::Z));
    Environment::new(move |d| if d.z < 0.0 { ground } else { dome.radiance(d) }, vec![disk])
}

/// What the atmosphere leaves of the sun's light (appendix A.1): scattering by molecules and by aerosol.
fn transmittance(elevation: f64) -> DVec3 {
    let degrees = elevation.to_degrees();
    // Relative optical mass (Kasten): 1 at the zenith.
    let mass = 1.0 / (elevation.sin() + 0.15 * (degrees + 3.885).powf(-1.253));
    let aerosol = 0.04608 * TURBIDITY - 0.04586;
    DVec3::from(WAVELENGTHS.map(|um| (-mass * (0.008735 * um.powf(-4.08) + aerosol * um.powf(-1.3))).exp()))
}

/// Luminance Y in kcd/m² and chromaticities x, y over the dome: each is its value at the zenith times Perez' function.
struct Dome {
    sun: DVec3,
    /// A to E of Perez' function for Y, x, y.
    perez: [[f64; 5]; 3],
    /// Value at the zenith over Perez' function there.
    scale: [f64; 3],
}

impl Dome {
    fn new(sun: DVec3) -> Dome {
        let t = TURBIDITY;
        // Appendix A.2: coefficients linear in the turbidity.
        let perez = [
            [
                0.1787 * t - 1.4630,
                -0.3554 * t + 0.4275,
                -0.0227 * t + 5.3251,
                0.1206 * t - 2.5771,
                -0.0670 * t + 0.3703,
            ],
            [
                -0.0193 * t - 0.2592,
                -0.0665 * t + 0.0008,
                -0.0004 * t + 0.2125,
                -0.0641 * t - 0.8989,
                -0.0033 * t + 0.0452,
            ],
            [
                -0.0167 * t - 0.2608,
                -0.0950 * t + 0.0092,
                -0.0079 * t + 0.2102,
                -0.0441 * t - 1.6537,
                -0.0109 * t + 0.0529,
            ],
        ];
        let theta = sun.z.acos();
        let at_zenith = zenith(theta);
        let scale = std::array::from_fn(|i| at_zenith[i] / perez_function(&perez[i], 1.0, theta));
        Dome { sun, perez, scale }
    }

    /// Linear sRGB of a direction above the horizon; colours outside the triangle of the primaries are clamped to it.
    fn radiance(&self, d: DVec3) -> DVec3 {
        // Perez' function has a pole at the horizon itself.
        let (cosine, gamma) = (d.z.max(1e-3), d.angle_between(self.sun));
        let [luminance, x, y] = std::array::from_fn(|i| self.scale[i] * perez_function(&self.perez[i], cosine, gamma));
        let xyz = DVec3::new(x / y, 1.0, (1.0 - x - y) / y) * luminance;
        (XYZ_TO_RGB * xyz).max(DVec3::ZERO)
    }
}

/// Equation 3: `cosine` of the angle from the zenith, angle `gamma` from the sun.
fn perez_function(&[a, b, c, d, e]: &[f64; 5], cosine: f64, gamma: f64) -> f64 {
    (1.0 + a * (b / cosine).exp()) * (1.0 + c * (d * gamma).exp() + e * gamma.cos().powi(2))
}

/// Y, x and y at the zenith for the sun at angle `theta` from it (appendix A.2).
fn zenith(theta: f64) -> [f64; 3] {
    let t = TURBIDITY;
    let chi = (4.0 / 9.0 - t / 120.0) * (PI - 2.0 * theta);
    let luminance = (4.0453 * t - 4.9710) * chi.tan() - 0.2155 * t + 2.4192;
    let polynomial = |rows: [[f64; 4]; 3]| {
        let [quadratic, linear, constant] = rows.map(|[a, b, c, d]| ((a * theta + b) * theta + c) * theta + d);
        (quadratic * t + linear) * t + constant
    };
    let x = polynomial([
        [0.00166, -0.00375, 0.00209, 0.0],
        [-0.02903, 0.06377, -0.03202, 0.00394],
        [0.11693, -0.21196, 0.06052, 0.25886],
    ]);
    let y = polynomial([
        [0.00275, -0.00610, 0.00317, 0.0],
        [-0.04214, 0.08970, -0.04153, 0.00516],
        [0.15346, -0.26756, 0.06670, 0.26688],
    ]);
    [luminance, x, y]
}

/// CIE XYZ to linear sRGB (IEC 61966-2-1); columns.
const XYZ_TO_RGB: DMat3 = DMat3::from_cols(
    DVec3::new(3.2406, -0.9689, 0.0557),
    DVec3::new(-1.5372, 1.8758, -0.2040),
    DVec3::new(-0.4986, 0.0415, 1.0570),
);

#[cfg(test)]
mod tests {
    use super::*;

    /// Luminance of linear sRGB.
    fn luminance(rgb: DVec3) -> f64 {
        rgb.dot(DVec3::new(0.2126, 0.7152, 0.0722))
    }

    #[test]
    fn the_zenith_has_the_luminance_of_the_model() {
        let light = environment();
        let sun = light.caps()[0].centre;
        let zenith_luminance = zenith(sun.z.acos())[0];
        let rgb = DVec3::from(light.radiance([0.0, 0.0, 1.0]).map(f64::from));
        assert!((luminance(rgb) / zenith_luminance - 1.0).abs() < 1e-3);
        // Clear skies have some 2 to 8 kcd/m² at the zenith for such a sun, and are bluer than white.
        assert!((2.0..8.0).contains(&zenith_luminance) && rgb.z > 1.5 * rgb.x, "{rgb}");
    }

    #[test]
    fn the_sun_has_its_solid_angle_and_a_clear_days_illuminance() {
        let sun = environment().caps()[0];
        assert!((sun.solid_angle() / 6.8e-5 - 1.0).abs() < 0.01);
        let illuminance = luminance(DVec3::from(sun.radiance)) * sun.solid_angle();
        assert!((70.0..110.0).contains(&illuminance), "{illuminance} klx");
        assert!(sun.radiance[0] > sun.radiance[2], "sunlight is yellower than white");
    }

    #[test]
    fn the_sky_is_brightest_around_the_sun_and_positive_everywhere() {
        let (light, sun) = (environment(), environment().caps()[0].centre);
        let around = |angle: f64| {
            luminance(DVec3::from(
                light
                    .radiance(
                        glam::DQuat::from_axis_angle(sun.any_orthonormal_vector(), angle).mul_vec3(sun).to_array(),
                    )
                    .map(f64::from),
            ))
        };
        assert!(around(0.02) > around(0.1) && around(0.1) > around(0.3));
        let image = light.image(64, 32).unwrap();
        assert!(image.pixels.iter().flatten().all(|&c| c > 0.0));
    }
}
