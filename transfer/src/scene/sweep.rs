//! All rays of a window at once: which directions of it do the occluders leave free?
//!
//! One walk over the hierarchy per window, nearest boxes first. Everything is seen in the window's coordinates (column, row):
//! a box becomes a rectangle, and is dropped if it lies below the horizon or behind the face, or if no direction in the
//! rectangle is still free; a triangle's edge `(a, b)` becomes the linear function `F = (a × b)·(u, v, 1)`, and a direction is
//! hidden where all three have the sign of the triangle's orientation (which also says that the distance is positive).
//!
//! What is closer to zero than `F` is known (see [`edges`](super::edges)) goes to [`exact`], so the masks do not depend on
//! how `F` was rounded.

use super::bvh::{LEAF, Leaf, Node, Occluders, WIDTH};
use super::directions::{Directions, Window};
use super::edges::{Edges, UNDERFLOW, dot, edge, largest};
use super::exact;
use super::grid::Grid;
use super::scattered::Scattered;
use super::visibility_kernel::{Lanes, Task};
use crate::basis::FACES;
use glam::Vec3;

/// How far, in columns and rows, a rectangle is widened for the rounding of its borders. A grid has at most 2366 directions
/// along a face's edge, so this is 4 times what rounding can do.
const GRID_MARGIN: f32 = 1.0 / 1024.0;

/// The same for scattered directions, which may lie between whole columns.
const SCATTERED_MARGIN: f32 = 1.0;

/// An inclusive rectangle of columns and rows: first and last column, first and last row, one byte each.
#[derive(Clone, Copy)]
pub(crate) struct Rectangle(u32);

impl Rectangle {
    #[inline(always)]
    pub(crate) fn columns(self) -> u64 {
        (!0 << (self.0 & 63)) & (!0 >> (63 - (self.0 >> 8 & 63)))
    }

    #[inline(always)]
    pub(crate) fn rows(self) -> std::ops::RangeInclusive<usize> {
        (self.0 >> 16 & 255) as usize..=(self.0 >> 24) as usize
    }
}

/// The occluders and directions of a sweep, seen from an origin.
pub(crate) struct Sweep<'a> {
    pub(crate) occluders: &'a Occluders,
    pub(crate) directions: &'a Directions,
    /// In the occluders' scaled coordinates.
    pub(crate) origin: Vec3,
    pub(crate) normal: Vec3,
    /// One mask per tile.
    pub(crate) out: &'a mut [u64],
}

impl Task for Sweep<'_> {
    /// Directions above the horizon.
    type Output = u64;

    #[inline(always)]
    fn run<L: Lanes>(self) -> u64 {
        let mut waiting = Vec::with_capacity(self.occluders.stack);
        let mut rays = 0;
        for window in &self.directions.windows {
            let view = View::<L>::new(&self, window);
            let tiles = if window.places.is_some() { 1 } else { window.size[1] };
            let out = &mut self.out[window.first_tile..][..tiles];
            rays += match &window.places {
                None => view.sweep(Grid::new(&view), &mut waiting, out),
                Some(places) => view.sweep(Scattered::new(&view, places), &mut waiting, out),
            };
        }
        rays
    }
}

/// The directions of a window that are still free.
pub(crate) trait Free<L: Lanes> {
    fn count(&self) -> u64;
    /// Whether a direction in the rectangle is free; may err on the side of yes.
    fn meets(&self, rectangle: Rectangle) -> bool;
    /// Takes away what the triangle hides; `hits(tile, bit)` is the exact answer for one direction.
    fn hide(&mut self, edges: &Edges, lane: usize, rectangle: Rectangle, hits: impl Fn(usize, usize) -> bool);
    fn store(&self, out: &mut [u64]);
}

/// What stays the same during the sweep of a window: face coordinates (u, v, w) of a point `p` are `sign·(p − origin)[axis]`.
pub(crate) struct View<'a, L> {
    occluders: &'a Occluders,
    pub(crate) directions: &'a Directions,
    pub(crate) window: &'a Window,
    origin: Vec3,
    pub(crate) normal: Vec3,
    pub(crate) axis: [usize; 3],
    pub(crate) sign: [f32; 3],
    /// A point is below the horizon where `normal·p` is at most `horizon`, which is a little below zero.
    face_normal: [L; 3],
    horizon: L,
    margin: f32,
}

impl<'a, L: Lanes> View<'a, L> {
    #[inline(always)]
    fn new(sweep: &Sweep<'a>, window: &'a Window) -> Self {
        let [forward, right, down] = FACES[window.face];
        let axes = [right, down, forward];
        let axis = axes.map(|d| d.iter().position(|&x| x != 0.0).unwrap_or(0));
        let sign = [0, 1, 2].map(|k| axes[k][axis[k]] as f32);
        let (origin, normal) = (sweep.origin, sweep.normal);
        let reach = (sweep.occluders.lower - origin).abs().max((sweep.occluders.upper - origin).abs()).element_sum();
        View {
            occluders: sweep.occluders,
            directions: sweep.directions,
            window,
            origin,
            normal,
            axis,
            sign,
            face_normal: [0, 1, 2].map(|k| L::splat(sign[k] * normal[axis[k]])),
            // Sixteen times what rounding can do to n·p and to n·d.
            horizon: L::splat(-1e-6 * reach * normal.abs().element_sum()),
            margin: if window.places.is_some() { SCATTERED_MARGIN } else { GRID_MARGIN },
        }
    }

    #[inline(always)]
    fn sweep<F: Free<L>>(&self, mut free: F, waiting: &mut Vec<(u32, Rectangle)>, out: &mut [u64]) -> u64 {
        let rays = free.count();
        if rays > 0 {
            let [columns, rows] = self.window.size.map(|n| n as u32 - 1);
            waiting.extend(self.occluders.root.map(|root| (root, Rectangle(columns << 8 | rows << 24))));
        }
        while let Some((reference, rectangle)) = waiting.pop() {
            if !free.meets(rectangle) {
                continue;
            }
            if reference & LEAF == 0 {
                self.open(&self.occluders.nodes[reference as usize], waiting);
            } else {
                self.hide(&self.occluders.leaves[(reference & !LEAF) as usize], &mut free);
            }
        }
        free.store(out);
        rays
    }

    /// Face coordinates of eight points whose world coordinates are given by axis.
    #[inline(always)]
    fn relative(&self, x: &[f32; WIDTH], k: usize) -> L {
        (L::load(x) - L::splat(self.origin[self.axis[k]])) * L::splat(self.sign[k])
    }

    /// Puts the children that the window may see on the list, the nearest last.
    #[inline(always)]
    fn open(&self, node: &Node, waiting: &mut Vec<(u32, Rectangle)>) {
        let zero = L::splat(0.0);
        let (mut lower, mut upper, mut square, mut height) = ([zero; 3], [zero; 3], zero, zero);
        for k in 0..3 {
            let (near, far) = if self.sign[k] > 0.0 { (0, 3) } else { (3, 0) };
            lower[k] = self.relative(&node.bounds[near + self.axis[k]], k);
            upper[k] = self.relative(&node.bounds[far + self.axis[k]], k);
            let distance = lower[k].max(zero - upper[k]).max(zero);
            square = distance.mul_add(distance, square);
            height = self.face_normal[k].mul_add(self.face_normal[k].select(lower[k], upper[k]), height);
        }
        let (seen, rectangles) = self.project(lower, upper);
        let mut seen = seen & height.gt(self.horizon).signs();
        let squares = square.store();
        let first = waiting.len();
        let mut keys = [0.0f32; WIDTH];
        while seen != 0 {
            let lane = seen.trailing_zeros() as usize;
            seen &= seen - 1;
            let key = squares[lane];
            let entry = (node.child[lane], Rectangle(rectangles[lane]));
            // Insertion keeps the farthest first, the nearest on top.
            waiting.push(entry);
            let mut at = waiting.len() - 1 - first;
            while at > 0 && keys[at - 1] < key {
                keys[at] = keys[at - 1];
                waiting[first + at] = waiting[first + at - 1];
                at -= 1;
            }
            keys[at] = key;
            waiting[first + at] = entry;
        }
    }

    /// The rectangles that eight boxes fill in the window, and which of them are not empty.
    #[inline(always)]
    fn project(&self, lower: [L; 3], upper: [L; 3]) -> (u32, [u32; WIDTH]) {
        let zero = L::splat(0.0);
        let one = L::splat(1.0);
        // 1/w over the part of the box in front: from 1/far to 1/near, which is infinite where the box reaches w = 0. An
        // infinity meets u = 0 only where the other bound is used, and a NaN would leave the border where it widest is.
        let near = one / lower[2].max(zero);
        let far = one / upper[2];
        let (scale, margin) = (L::splat(self.window.scale), L::splat(self.margin));
        let mut bounds = [zero; 4];
        let mut seen = upper[2].gt(zero);
        for k in 0..2 {
            let shift = L::splat(-self.window.corner[k] * self.window.scale);
            let last = L::splat((self.window.size[k] - 1) as f32);
            let least = lower[k] * zero.gt(lower[k]).select(near, far);
            let most = upper[k] * upper[k].gt(zero).select(near, far);
            bounds[2 * k] = (least.mul_add(scale, shift) - margin).ceil().max(zero);
            bounds[2 * k + 1] = (most.mul_add(scale, shift) + margin).floor().min(last);
            seen = seen.and(bounds[2 * k].le(bounds[2 * k + 1]));
        }
        (seen.signs(), L::bytes(bounds))
    }

    #[inline(always)]
    fn hide<F: Free<L>>(&self, leaf: &Leaf, free: &mut F) {
        let zero = L::splat(0.0);
        let mut corner = [[zero; 3]; 3];
        let (mut lower, mut upper) = ([zero; 3], [zero; 3]);
        for k in 0..3 {
            for (i, corner) in corner.iter_mut().enumerate() {
                corner[k] = self.relative(&leaf.corner[i][self.axis[k]], k);
            }
            lower[k] = corner[0][k].min(corner[1][k]).min(corner[2][k]);
            upper[k] = corner[0][k].max(corner[1][k]).max(corner[2][k]);
        }
        let n = self.face_normal;
        let height = dot(n, corner[0]).max(dot(n, corner[1])).max(dot(n, corner[2]));
        let (seen, rectangles) = self.project(lower, upper);
        let mut seen = seen & height.gt(self.horizon).signs() & ((1 << leaf.count) - 1);
        let mut left = seen;
        while left != 0 {
            let lane = left.trailing_zeros() as usize;
            left &= left - 1;
            if !free.meets(Rectangle(rectangles[lane])) {
                seen &= !(1 << lane);
            }
        }
        if seen == 0 {
            return;
        }
        let edges = self.edges(&corner, leaf, &mut seen);
        while seen != 0 {
            let lane = seen.trailing_zeros() as usize;
            seen &= seen - 1;
            free.hide(&edges, lane, Rectangle(rectangles[lane]), |tile, bit| {
                let direction = self.directions.direction(self.window.first_tile + tile, bit);
                exact::hits(leaf.triangle(lane, self.origin), direction)
            });
        }
    }

    /// The edge functions of eight triangles, positive inside. Takes triangles that are seen exactly edge-on out of `seen`.
    #[inline(always)]
    fn edges(&self, corner: &[[L; 3]; 3], leaf: &Leaf, seen: &mut u32) -> Edges {
        let normals = [edge(corner[0], corner[1]), edge(corner[1], corner[2]), edge(corner[2], corner[0])];
        // det(v0, v1, v2) = (v0 × v1)·(v2 − v0)
        let [(n, bound), ..] = normals;
        let side = [0, 1, 2].map(|k| corner[2][k] - corner[0][k]);
        let determinant = dot(n, side);
        let unsure = determinant.abs().le(bound.mul_add(largest(side), L::splat(UNDERFLOW))).signs() & *seen;
        let mut orientation = determinant.gt(L::splat(0.0)).select(L::splat(1.0), L::splat(-1.0));
        if unsure != 0 {
            orientation = self.exact_orientation(orientation, unsure, leaf, seen);
        }
        let mut edges = Edges::default();
        let [u0, v0] = self.window.corner.map(L::splat);
        let step = orientation * L::splat(1.0 / self.window.scale);
        for (i, (n, bound)) in normals.into_iter().enumerate() {
            edges.constant[i] = (v0.mul_add(n[1], u0.mul_add(n[0], n[2])) * orientation).store();
            edges.per_column[i] = (n[0] * step).store();
            edges.per_row[i] = (n[1] * step).store();
            edges.bound[i] = (bound + L::splat(UNDERFLOW)).store();
        }
        edges
    }

    #[cold]
    fn exact_orientation(&self, orientation: L, unsure: u32, leaf: &Leaf, seen: &mut u32) -> L {
        let mut signs = orientation.store();
        for lane in (0..WIDTH).filter(|lane| unsure >> lane & 1 == 1) {
            let [a, b, c] = leaf
                .triangle(lane, self.origin)
                .map(|p| Vec3::from_array([0, 1, 2].map(|k| p[self.axis[k]] * self.sign[k])));
            match exact::orientation(a, b, c) {
                0 => *seen &= !(1 << lane),
                sign => signs[lane] = sign as f32,
            }
        }
        L::load(&signs)
    }
}
