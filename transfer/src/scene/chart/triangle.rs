//! A face as it lies among the texels.

use super::{Charted, Place};
use glam::DVec2;
use robust::{Coord, orient2d};
use std::ops::RangeInclusive;

/// A face in the chart, in units of texels: the centre of texel (x, y) is (x + 1/2, y + 1/2). Coordinates of `f32` times whole
/// numbers below 2²⁹ are exact in `f64`.
pub(super) struct Triangle {
    pub(super) face: u32,
    corners: [DVec2; 3],
    /// 1 where the corners run counter-clockwise, -1 where the chart is mirrored.
    turn: f64,
}

/// Rounding of [`Triangle::span`], in texels; who asks for a span has an exact test to follow.
const SLACK: f64 = 1e-6;

impl Triangle {
    /// `None` for a face without area in the chart.
    pub(super) fn new(charted: &Charted, face: u32, [width, height]: [usize; 2]) -> Option<Triangle> {
        let size = DVec2::new(width as f64, height as f64);
        let corners = charted.mesh.faces[face as usize].map(|v| charted.uv[v as usize].as_dvec2() * size);
        let turn = signed_area(corners[0], corners[1], corners[2]);
        (turn != 0.0).then(|| Triangle { face, corners, turn: turn.signum() })
    }

    /// Twice the areas of the triangles between `p` and the edges opposite each corner. Their signs are exact: `p` is in the
    /// triangle, its border included, where none is negative, so that no point between triangles that meet is in none of them.
    pub(super) fn weights(&self, p: DVec2) -> [f64; 3] {
        [0, 1, 2].map(|i| self.turn * signed_area(self.corners[(i + 1) % 3], self.corners[(i + 2) % 3], p))
    }

    /// How far inside the triangle `p` is, in texels; negative outside.
    pub(super) fn depth(&self, p: DVec2) -> f64 {
        let distance =
            |(i, weight): (usize, f64)| weight / self.corners[(i + 1) % 3].distance(self.corners[(i + 2) % 3]);
        self.weights(p).into_iter().enumerate().map(distance).fold(f64::INFINITY, f64::min)
    }

    /// The squared distance from `p` of the nearest point of the border, and the weights of that point.
    pub(super) fn nearest(&self, p: DVec2) -> (f64, [f64; 3]) {
        let on_edge = |i: usize| {
            let j = (i + 1) % 3;
            let (a, b) = (self.corners[i], self.corners[j]);
            let t = ((p - a).dot(b - a) / (b - a).length_squared()).clamp(0.0, 1.0);
            let mut weights = [0.0; 3];
            (weights[i], weights[j]) = (1.0 - t, t);
            (p.distance_squared(a.lerp(b, t)), weights)
        };
        let (first, rest) = (on_edge(0), [on_edge(1), on_edge(2)]);
        rest.into_iter().fold(first, |best, other| if other.0 < best.0 { other } else { best })
    }

    /// The rows whose centres are no farther above or below the triangle than `reach`, and, in each, the columns no farther
    /// to its sides. Empty ranges run backwards.
    pub(super) fn rows(&self, reach: f64) -> RangeInclusive<i64> {
        let [low, high] = bounds(self.corners.iter().map(|c| c.y));
        centres(low - reach, high + reach)
    }

    /// The columns whose centres are no farther than `reach` from that part of the triangle that is no farther than `reach`
    /// above or below the centre of a row, and perhaps some more.
    pub(super) fn columns(&self, row: i64, reach: f64) -> RangeInclusive<i64> {
        let y = row as f64 + 0.5;
        let [left, right] = self.span(y - reach, y + reach);
        centres(left - reach - SLACK, right + reach + SLACK)
    }

    /// The least and the greatest x of what lies between two heights.
    fn span(&self, low: f64, high: f64) -> [f64; 2] {
        let ends = [(0, 1), (1, 2), (2, 0)].into_iter().flat_map(|(i, j)| {
            let (a, b) = (self.corners[i], self.corners[j]);
            let (a, b) = if a.y <= b.y { (a, b) } else { (b, a) };
            let at = move |y: f64| if a.y < b.y { a.x + (b.x - a.x) * ((y - a.y) / (b.y - a.y)) } else { a.x };
            let (from, to) = (low.max(a.y), high.min(b.y));
            // A horizontal edge has two ends at one height; its other end begins the next edge.
            (from <= to).then(|| [at(from), at(to)]).into_iter().flatten()
        });
        bounds(ends)
    }
}

/// The whole numbers i with i + 1/2 from `low` to `high`.
fn centres(low: f64, high: f64) -> RangeInclusive<i64> {
    (low - 0.5).ceil() as i64..=(high - 0.5).floor() as i64
}

fn bounds(numbers: impl Iterator<Item = f64>) -> [f64; 2] {
    numbers.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], x| [low.min(x), high.max(x)])
}

/// Twice the area of a triangle, positive where its corners run counter-clockwise; the sign is that of the real numbers.
fn signed_area(a: DVec2, b: DVec2, c: DVec2) -> f64 {
    let point = |p: DVec2| Coord { x: p.x, y: p.y };
    orient2d(point(a), point(b), point(c))
}

impl Place {
    /// The place that has these weights of a face's corners, of any sum.
    pub(super) fn new(face: u32, [a, b, c]: [f64; 3]) -> Place {
        let u = (b / (a + b + c)) as f32;
        Place { face, u, v: ((c / (a + b + c)) as f32).min(1.0 - u) }
    }
}
