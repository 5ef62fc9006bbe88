//! Texels of a surface: a grid over the unit square of its texture coordinates.

use crate::error::{Error, Result};
use std::fmt;
use std::str::FromStr;

/// How a chart goes on beyond the edges of the unit square.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Border {
    /// It ends there: rectangles, and charts of which nothing is known.
    #[default]
    Clamp,
    /// It begins anew at the opposite edge: a torus.
    Wrap,
    /// Each edge is folded in its middle and sewn to itself: the square is a sphere (Clarberg, "Fast Equal-Area Mapping of the
    /// (Hemi)Sphere using SIMD", 2008).
    Octahedral,
}

/// A grid of texels. Written as `256x128`, with `:wrap` or `:octahedral` where its border is one of those.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Texels {
    /// X, texels in a row.
    pub width: usize,
    /// Y, rows.
    pub height: usize,
    /// What lies beyond the edges.
    pub border: Border,
}

/// Texels with weights from 0 to 1 that add up to 1; one texel may be there twice.
pub type Taps = [(u32, f32); 4];

impl Texels {
    /// How many there are.
    pub fn count(&self) -> usize {
        self.width * self.height
    }

    /// The middle of texel `x + y · width` in texture coordinates.
    pub fn centre(&self, texel: usize) -> [f64; 2] {
        let middle = |i: usize, n: usize| (i as f64 + 0.5) / n as f64;
        [middle(texel % self.width, self.width), middle(texel / self.width, self.height)]
    }

    /// The four texels around a place and their bilinear weights: continuous over the square and, as the border says, across its edges.
    /// Coordinates outside of it are taken for the nearest inside.
    pub fn taps(&self, [u, v]: [f32; 2]) -> Taps {
        let along = |t: f32, n: usize| {
            let t = t.clamp(0.0, 1.0) * n as f32 - 0.5;
            (t.floor() as i64, t - t.floor())
        };
        let ((x, right), (y, down)) = (along(u, self.width), along(v, self.height));
        [
            (self.at(x, y), (1.0 - right) * (1.0 - down)),
            (self.at(x + 1, y), right * (1.0 - down)),
            (self.at(x, y + 1), (1.0 - right) * down),
            (self.at(x + 1, y + 1), right * down),
        ]
    }

    /// The texel at column x and row y, each at most one beyond the grid.
    pub(crate) fn at(&self, x: i64, y: i64) -> u32 {
        let (w, h) = (self.width as i64, self.height as i64);
        let (x, y) = match self.border {
            Border::Clamp => (x.clamp(0, w - 1), y.clamp(0, h - 1)),
            Border::Wrap => (x.rem_euclid(w), y.rem_euclid(h)),
            Border::Octahedral => {
                // Across the left edge at row y is row h-1-y of the same edge; the corners are one point.
                let (x, y) = if x < 0 || x >= w { (x.clamp(0, w - 1), h - 1 - y) } else { (x, y) };
                if y < 0 || y >= h { (w - 1 - x, y.clamp(0, h - 1)) } else { (x, y) }
            }
        };
        (y * w + x) as u32
    }
}

impl fmt::Display for Texels {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Texels { width, height, border } = self;
        write!(f, "{width}x{height}")?;
        f.write_str(match border {
            Border::Clamp => "",
            Border::Wrap => ":wrap",
            Border::Octahedral => ":octahedral",
        })
    }
}

impl FromStr for Texels {
    type Err = Error;

    fn from_str(text: &str) -> Result<Texels> {
        let known = || "WIDTHxHEIGHT, WIDTHxHEIGHT:wrap and WIDTHxHEIGHT:octahedral".into();
        let refuse = || Error::Unknown { what: "grid of texels", name: text.into(), known: known() };
        let (size, border) = match text.split_once(':') {
            None => (text, Border::Clamp),
            Some((size, "wrap")) => (size, Border::Wrap),
            Some((size, "octahedral")) => (size, Border::Octahedral),
            Some(_) => return Err(refuse()),
        };
        let side = |text: &str| text.parse().ok().filter(|n| (1..=MAX_SIDE).contains(n)).ok_or_else(refuse);
        let (width, height) = size.split_once('x').ok_or_else(refuse)?;
        Ok(Texels { width: side(width)?, height: side(height)?, border })
    }
}

/// Most texels along a side.
pub const MAX_SIDE: usize = 1 << 15;

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const BORDERS: [Border; 3] = [Border::Clamp, Border::Wrap, Border::Octahedral];

    /// A smooth function on the closed surface that the border makes of the square, the same on edges that are one.
    fn on_surface(border: Border, [u, v]: [f64; 2]) -> f64 {
        use std::f64::consts::{PI, TAU};
        match border {
            Border::Clamp => u + 2.0 * v,
            Border::Wrap => (TAU * u).sin() + (TAU * v).cos(),
            // Even about the middle of each edge on that edge.
            Border::Octahedral => (TAU * u).cos() * (TAU * v).cos() + (PI * u).sin() * (PI * v).sin(),
        }
    }

    proptest! {
        #[test]
        fn weights_add_up_to_one_and_texels_exist(
            u in -0.2f32..1.2, v in -0.2f32..1.2, width in 1usize..9, height in 1usize..9, border in 0usize..3,
        ) {
            let texels = Texels { width, height, border: BORDERS[border] };
            let taps = texels.taps([u, v]);
            prop_assert!((taps.iter().map(|t| t.1).sum::<f32>() - 1.0).abs() < 1e-5);
            prop_assert!(taps.iter().all(|&(texel, weight)| (texel as usize) < texels.count() && weight >= 0.0));
        }

        #[test]
        fn places_that_are_one_point_have_one_value(t in 0.0f32..1.0, side in 3usize..12, seed in 0u64..1000) {
            // Any numbers on the texels, not only smooth ones.
            let value = |texels: &Texels, place: [f32; 2]| -> f64 {
                let number = |texel: u32| f64::from((u64::from(texel) * 2654435761 + seed) as u32 % 1000);
                texels.taps(place).iter().map(|&(texel, weight)| number(texel) * f64::from(weight)).sum()
            };
            for (border, one, other) in [
                (Border::Wrap, [0.0, t], [1.0, t]),
                (Border::Wrap, [t, 0.0], [t, 1.0]),
                (Border::Octahedral, [0.0, t], [0.0, 1.0 - t]),
                (Border::Octahedral, [1.0, t], [1.0, 1.0 - t]),
                (Border::Octahedral, [t, 0.0], [1.0 - t, 0.0]),
                (Border::Octahedral, [t, 1.0], [1.0 - t, 1.0]),
            ] {
                let texels = Texels { width: side, height: side, border };
                let (a, b) = (value(&texels, one), value(&texels, other));
                prop_assert!((a - b).abs() < 0.1, "{border:?} {one:?}: {a} {b}");
            }
        }
    }

    #[test]
    fn smooth_functions_come_back_to_the_second_order() {
        for border in BORDERS {
            let error = |side: usize| {
                let texels = Texels { width: side, height: side, border };
                let values: Vec<f64> = (0..texels.count()).map(|t| on_surface(border, texels.centre(t))).collect();
                let off = |i: usize| {
                    let place = [(i % 61) as f64 / 60.0, (i / 61) as f64 / 60.0].map(|t| 0.1 + 0.8 * t);
                    let taps = texels.taps(place.map(|t| t as f32));
                    let found: f64 = taps.iter().map(|&(texel, w)| values[texel as usize] * f64::from(w)).sum();
                    (found - on_surface(border, place)).abs()
                };
                (0..61 * 61).map(off).fold(0.0, f64::max)
            };
            assert!(error(64) < 0.3 * error(32) + 1e-5, "{border:?}: {} {}", error(64), error(32));
        }
    }

    #[test]
    fn every_grid_reads_back_what_it_prints() {
        for text in ["256x128", "1x1", "64x64:wrap", "32x32:octahedral"] {
            assert_eq!(text.parse::<Texels>().unwrap().to_string(), text);
        }
        for text in ["", "4", "0x4", "4x", "4x4:", "4x4:mirror", "-1x2", "99999x1", "4x4:wrap:wrap"] {
            assert!(text.parse::<Texels>().is_err(), "{text}");
        }
    }
}
