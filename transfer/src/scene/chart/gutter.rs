//! Texels outside of a chart that interpolation between texels nevertheless takes for points inside.

use super::Place;
use super::triangle::Triangle;
use crate::texels::Texels;
use glam::DVec2;

/// How far from a point the centre of a texel may be that a bilinear lookup of the point touches: less than one texel in x and
/// in y, hence less than √2.
const REACH: f64 = std::f64::consts::SQRT_2;

/// Gives texels without a place, where a lookup of a point of the chart touches them, the nearest place on the chart, of
/// several equally near the first face's. The chart is continued by a texel beyond the edges of the square, as its border says.
/// Returns how many these are.
pub(super) fn fill(texels: &Texels, triangles: &[Triangle], places: &mut [Option<Place>]) -> usize {
    if places.iter().all(Option::is_some) {
        return 0;
    }
    let mut found: Vec<Option<(f64, Place)>> = vec![None; places.len()];
    for triangle in triangles {
        for y in within(triangle.rows(REACH), texels.height) {
            for x in within(triangle.columns(y, REACH), texels.width) {
                let texel = texels.at(x, y) as usize;
                if places[texel].is_some() {
                    continue;
                }
                let (distance, weights) = triangle.nearest(DVec2::new(x as f64, y as f64) + 0.5);
                if distance < found[texel].map_or(REACH * REACH, |best| best.0) {
                    found[texel] = Some((distance, Place::new(triangle.face, weights)));
                }
            }
        }
    }
    let mut gutter = 0;
    for (place, found) in places.iter_mut().zip(found) {
        if let Some((_, nearest)) = found {
            *place = Some(nearest);
            gutter += 1;
        }
    }
    gutter
}

/// What of a range lies in the grid or at most one beyond.
fn within(range: std::ops::RangeInclusive<i64>, side: usize) -> std::ops::RangeInclusive<i64> {
    *range.start().max(&-1)..=*range.end().min(&(side as i64))
}
