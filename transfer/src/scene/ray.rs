//! Single rays through the same hierarchy.
//!
//! A triangle is hit by the rule of the batched sweep, edge functions with an exact fallback, so that a single ray and a bit
//! of [`Occluders::visible`] never disagree.

use super::bvh::{LEAF, Leaf, Node, Occluders, WIDTH, unit_scale};
use super::edges::{UNDERFLOW, dot, edge, largest};
use super::exact;
use super::visibility_kernel::{Lanes, Task, dispatch};
use glam::{DVec3, Vec3};
use std::cell::Cell;

thread_local! {
    /// The list of a ray's walk, kept from ray to ray: an allocation would cost as much as a short walk.
    static WAITING: Cell<Vec<(f32, u32)>> = const { Cell::new(Vec::new()) };
}

/// Where a ray meets a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Distance over the length of the direction: the point is `origin + t·direction`, `t` > 0.
    pub t: f32,
    /// Face of the mesh.
    pub face: u32,
    /// Weight of the face's second corner; the first has `1 - u - v`.
    pub u: f32,
    /// Weight of the face's third corner.
    pub v: f32,
}

impl Occluders {
    /// Whether the ray from `origin` along `direction` (of any length but 0) meets a triangle, from either side, at any
    /// positive distance. The origin is taken as it is: lift it off the surface that it lies on, see [`Occluders::offset`].
    pub fn occluded(&self, origin: Vec3, direction: Vec3) -> bool {
        self.query(origin, direction, true, f32::INFINITY).is_some()
    }

    /// Whether a triangle, seen from either side, lies between two points. They are taken as they are: lift both off the surfaces that they
    /// lie on.
    pub fn between(&self, from: Vec3, to: Vec3) -> bool {
        self.query(from, to - from, true, 1.0).is_some()
    }

    /// The nearest triangle that the ray meets, from either side; of several at the same distance, any.
    pub fn nearest(&self, origin: Vec3, direction: Vec3) -> Option<Hit> {
        self.query(origin, direction, false, f32::INFINITY)
    }

    /// A hit nearer than `limit`, over the length of the direction.
    fn query(&self, origin: Vec3, direction: Vec3, any: bool, limit: f32) -> Option<Hit> {
        if direction == Vec3::ZERO {
            return None;
        }
        // Powers of two: exact, and no product below underflows.
        let length = unit_scale(direction.abs().max_element());
        let limit = limit * self.scale / length;
        let mut waiting = WAITING.take();
        waiting.clear();
        waiting.reserve(self.stack);
        let (origin, direction) = (origin * self.scale, direction * length);
        let ray = Query { occluders: self, origin, direction, any, limit };
        let hit = dispatch(Walk { ray, waiting: &mut waiting });
        WAITING.set(waiting);
        hit.map(|hit| Hit { t: hit.t * length / self.scale, ..hit })
    }
}

/// A ray in the occluders' scaled coordinates.
struct Query<'a> {
    occluders: &'a Occluders,
    origin: Vec3,
    direction: Vec3,
    /// Whether the first hit found will do.
    any: bool,
    /// Hits beyond this distance do not count.
    limit: f32,
}

/// The walk of a ray through the hierarchy.
struct Walk<'a> {
    ray: Query<'a>,
    /// Nodes and leaves that the ray enters, with the distance; empty at first.
    waiting: &'a mut Vec<(f32, u32)>,
}

impl Task for Walk<'_> {
    type Output = Option<Hit>;

    #[inline(always)]
    fn run<L: Lanes>(self) -> Option<Hit> {
        let Walk { ray, waiting } = self;
        let slabs = Slabs::<L>::new(&ray);
        waiting.extend(ray.occluders.root.map(|root| (0.0, root)));
        let mut best: Option<Hit> = None;
        while let Some((entry, reference)) = waiting.pop() {
            let limit = best.map_or(ray.limit, |hit| hit.t);
            if entry > limit {
                continue;
            }
            if reference & LEAF == 0 {
                slabs.open(&ray.occluders.nodes[reference as usize], limit, waiting);
                continue;
            }
            let leaf = &ray.occluders.leaves[(reference & !LEAF) as usize];
            let mut met = ray.meet::<L>(leaf);
            while met != 0 {
                let hit = ray.hit(leaf, met.trailing_zeros() as usize);
                met &= met - 1;
                if hit.t > ray.limit {
                    continue;
                }
                if ray.any {
                    return Some(hit);
                }
                if best.is_none_or(|best| hit.t < best.t) {
                    best = Some(hit);
                }
            }
        }
        best
    }
}

impl Query<'_> {
    /// The triangles of the leaf that the ray hits.
    #[inline(always)]
    fn meet<L: Lanes>(&self, leaf: &Leaf) -> u32 {
        let zero = L::splat(0.0);
        let origin = splat::<L>(self.origin);
        let corner = |c: &[[f32; WIDTH]; 3]| subtract([L::load(&c[0]), L::load(&c[1]), L::load(&c[2])], origin);
        let [a, b, c] = [corner(&leaf.corner[0]), corner(&leaf.corner[1]), corner(&leaf.corner[2])];
        let edges = [edge(a, b), edge(b, c), edge(c, a)];
        let (n, bound) = edges[0];
        let side = subtract(c, a);
        let determinant = dot(n, side);
        let determinant_bound = bound.mul_add(largest(side), L::splat(UNDERFLOW));
        // The least edge function, on the triangle's side, lessened and raised by its bound.
        let facing = determinant.gt(zero).select(L::splat(1.0), L::splat(-1.0));
        let direction = splat::<L>(self.direction);
        let length = largest(direction);
        let [mut sure, mut perhaps] = [L::splat(f32::INFINITY); 2];
        for (n, bound) in edges {
            let value = dot(n, direction) * facing;
            let bound = bound.mul_add(length, L::splat(UNDERFLOW));
            sure = sure.min(value - bound);
            perhaps = perhaps.min(value + bound);
        }
        let edge_on = determinant.abs().le(determinant_bound).signs();
        let used = (1 << leaf.count) - 1;
        let met = sure.gt(zero).signs() & !edge_on & used;
        let mut doubtful = (zero.le(perhaps).signs() | edge_on) & !met & used;
        let mut exact_hits = 0;
        while doubtful != 0 {
            let lane = doubtful.trailing_zeros();
            doubtful &= doubtful - 1;
            let hit = exact::hits(leaf.triangle(lane as usize, self.origin), self.direction);
            exact_hits |= u32::from(hit) << lane;
        }
        met | exact_hits
    }

    /// Distance and weights on a triangle that is hit: with `F_i = det(v_j, v_k, d)` opposite to corner i, the weights are
    /// `F_i / ΣF` and `t = det(v_0, v_1, v_2) / ΣF`.
    fn hit(&self, leaf: &Leaf, lane: usize) -> Hit {
        let [a, b, c] = leaf.triangle(lane, self.origin).map(Vec3::as_dvec3);
        let d = self.direction.as_dvec3();
        let det = |a: DVec3, b: DVec3, c: DVec3| a.cross(b).dot(c);
        let weights = DVec3::new(det(b, c, d), det(c, a, d), det(a, b, d));
        // Zero only by rounding, of a triangle seen edge-on but for less than f64 resolves.
        let sum = Some(weights.element_sum()).filter(|&sum| sum != 0.0).unwrap_or(f64::MIN_POSITIVE);
        let [u, v] = [weights.y, weights.z].map(|w| (w / sum).clamp(0.0, 1.0) as f32);
        // The point lies between the corners, also where the triangle is seen so nearly edge-on that the quotient is noise.
        let along = [a, b, c].map(|corner| corner.dot(d) / d.length_squared());
        let (least, most) = (along[0].min(along[1]).min(along[2]), along[0].max(along[1]).max(along[2]));
        Hit { t: (det(a, b, c) / sum).max(least).min(most) as f32, face: leaf.face[lane], u, v }
    }
}

// `array::map` is not always inlined, and a closure compiled by itself has none of the instructions of its caller.

/// Eight times the same vector.
#[inline(always)]
fn splat<L: Lanes>(v: Vec3) -> [L; 3] {
    [L::splat(v.x), L::splat(v.y), L::splat(v.z)]
}

/// `a - b` of eight pairs.
#[inline(always)]
fn subtract<L: Lanes>(a: [L; 3], b: [L; 3]) -> [L; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// The ray against eight boxes at once.
struct Slabs<L> {
    origin: [L; 3],
    inverse: [L; 3],
    /// Which of a node's bounds the ray meets first, along each axis; the other is three places away.
    first: [usize; 3],
    /// Boxes are widened by this for the rounding of the planes' distances.
    margin: L,
}

impl<L: Lanes> Slabs<L> {
    #[inline(always)]
    fn new(query: &Query) -> Self {
        let direction = query.direction;
        // A component of zero is as good as one too small to leave the widened box on the way through the scene: it keeps
        // 0 · ∞ away.
        let least = direction.abs().max_element() * 1e-25;
        let component = |k: usize| if direction[k].abs() < least { least.copysign(direction[k]) } else { direction[k] };
        let first = |k: usize| if component(k) > 0.0 { k } else { k + 3 };
        let reach = (query.occluders.lower - query.origin).abs().max((query.occluders.upper - query.origin).abs());
        Slabs {
            origin: splat(query.origin),
            inverse: splat(Vec3::new(1.0 / component(0), 1.0 / component(1), 1.0 / component(2))),
            first: [first(0), first(1), first(2)],
            margin: L::splat(1e-6 * reach.max_element()),
        }
    }

    /// Puts the children that the ray enters before `limit` on the list, the nearest last, with the distance of entry.
    #[inline(always)]
    fn open(&self, node: &Node, limit: f32, waiting: &mut Vec<(f32, u32)>) {
        let (mut enter, mut leave) = (L::splat(0.0), L::splat(limit));
        for k in 0..3 {
            let (near, far) = (self.first[k], (self.first[k] + 3) % 6);
            let outward = if near < 3 { self.margin } else { L::splat(0.0) - self.margin };
            let near = (L::load(&node.bounds[near]) - self.origin[k] - outward) * self.inverse[k];
            let far = (L::load(&node.bounds[far]) - self.origin[k] + outward) * self.inverse[k];
            enter = near.max(enter);
            leave = far.min(leave);
        }
        let mut met = enter.le(leave).signs();
        let enter = enter.store();
        let first = waiting.len();
        while met != 0 {
            let lane = met.trailing_zeros() as usize;
            met &= met - 1;
            // An unused place is an inverted box, which no ray enters.
            let at = waiting[first..].partition_point(|&(other, _)| other > enter[lane]);
            waiting.insert(first + at, (enter[lane], node.child[lane]));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;
    use crate::scene::shapes;

    #[test]
    fn what_lies_between_two_points_is_nearer_than_the_second() {
        for (name, scale) in [("teapot", 1.0), ("temple", 1e-6), ("cornell-box", 3e5)] {
            let mut mesh = shapes::find(name).unwrap().build(800).unwrap();
            mesh.positions.iter_mut().for_each(|p| *p *= scale);
            let (occluders, mut random) = (Occluders::new(&mesh).unwrap(), Random(5));
            let mut counts = [0; 2];
            for _ in 0..4000 {
                let [a, b] =
                    [(); 2].map(|()| scale * Vec3::from_array([(); 3].map(|()| 2.4 * random.uniform() as f32 - 1.2)));
                let (hit, between) = (occluders.nearest(a, b - a), occluders.between(a, b));
                assert_eq!(between, hit.is_some_and(|hit| hit.t <= 1.0), "{name}: {a} {b} {hit:?}");
                counts[usize::from(between)] += 1;
            }
            assert!(counts.iter().all(|&n| n > 200), "{name}: {counts:?}");
            assert!(!occluders.between(Vec3::ZERO, Vec3::ZERO));
        }
    }
}
