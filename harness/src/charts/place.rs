//! Places labels beside their points, where they cover as little as possible.

/// An upright rectangle in pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Box2 {
    pub(super) left: f64,
    pub(super) top: f64,
    pub(super) right: f64,
    pub(super) bottom: f64,
}

impl Box2 {
    /// Around a centre.
    pub(super) fn around(x: f64, y: f64, half_width: f64, half_height: f64) -> Box2 {
        Box2 { left: x - half_width, top: y - half_height, right: x + half_width, bottom: y + half_height }
    }
    /// The area that both cover.
    fn overlap(&self, other: &Box2) -> f64 {
        let width = self.right.min(other.right) - self.left.max(other.left);
        let height = self.bottom.min(other.bottom) - self.top.max(other.top);
        width.max(0.0) * height.max(0.0)
    }
    /// The area outside `frame`.
    fn outside(&self, frame: &Box2) -> f64 {
        (self.right - self.left) * (self.bottom - self.top) - self.overlap(frame)
    }
}

/// What the DejaVu Sans of both outputs takes for a character, on average, in font sizes.
const ADVANCE: f64 = 0.6;

/// The width of a text in pixels, about.
pub(super) fn width(text: &str, size: f64) -> f64 {
    ADVANCE * size * text.chars().count() as f64
}

/// The left end of each label's base line. `points` are the markers' centres, `obstacles` what should not be covered.
pub(super) fn labels(
    points: &[(f64, f64)],
    texts: &[&str],
    size: f64,
    frame: Box2,
    obstacles: &[Box2],
) -> Vec<(f64, f64)> {
    let markers: Vec<Box2> =
        points.iter().map(|&(x, y)| Box2::around(x, y, 6.0, 6.0)).chain(obstacles.to_vec()).collect();
    let mut placed: Vec<Box2> = Vec::new();
    // At first each beside those before it; then each once more beside all others, as long as that may help.
    for sweep in 0..SWEEPS {
        for (i, (&(x, y), text)) in points.iter().zip(texts).enumerate() {
            let others = placed.iter().enumerate().filter(|(other, _)| *other != i).map(|(_, b)| b);
            let taken: Vec<&Box2> = markers.iter().chain(others).collect();
            let cost = |b: &Box2| taken.iter().map(|t| t.overlap(b)).sum::<f64>() + 10.0 * b.outside(&frame);
            let best = candidates(x, y, width(text, size) / 2.0, size / 2.0).min_by(|a, b| cost(a).total_cmp(&cost(b)));
            let best = best.unwrap_or(Box2::around(x, y, width(text, size) / 2.0, size / 2.0));
            if sweep == 0 {
                placed.push(best);
            } else if cost(&best) < cost(&placed[i]) {
                placed[i] = best;
            }
        }
    }
    placed.iter().map(|b| (b.left, b.bottom - 0.15 * size)).collect()
}

/// How often every label is placed.
const SWEEPS: usize = 4;

/// Right, left, above, below, then the corners, then the same further away: the first is the best of equals.
fn candidates(x: f64, y: f64, half_width: f64, half_height: f64) -> impl Iterator<Item = Box2> {
    [1.0, 1.6, 2.2, 3.0].into_iter().flat_map(move |far| {
        let (dx, dy) = (half_width + 9.0 * far, half_height + 8.0 * far);
        let offsets = [(dx, 0.0), (-dx, 0.0), (0.0, -dy), (0.0, dy), (dx, -dy), (-dx, -dy), (dx, dy), (-dx, dy)];
        offsets.map(|(dx, dy)| Box2::around(x + dx, y + dy, half_width, half_height))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const FRAME: Box2 = Box2 { left: 0.0, top: 0.0, right: 400.0, bottom: 300.0 };

    #[test]
    fn neighbours_do_not_cover_each_other_and_nothing_leaves_the_frame() {
        let points = [(200.0, 150.0), (215.0, 150.0), (200.0, 162.0), (395.0, 5.0)];
        let texts = ["64", "128", "sphere", "a long label"];
        let placed = labels(&points, &texts, 11.0, FRAME, &[]);
        let boxes: Vec<Box2> = placed
            .iter()
            .zip(texts)
            .map(|(&(left, base), text)| Box2 { left, top: base - 9.35, right: left + width(text, 11.0), bottom: base })
            .collect();
        for (i, a) in boxes.iter().enumerate() {
            assert!(boxes[..i].iter().all(|b| a.overlap(b) == 0.0), "{boxes:?}");
            assert!(a.outside(&FRAME).abs() < 1e-9, "{a:?}");
        }
    }
}
