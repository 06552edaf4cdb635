//! When a moving triangle can be seen in a tile: bounds that leave no sample out [Munkberg2011, Laine2011].
//!
//! All are computed with a slack above what rounding can do, so that they err on the safe side.

use super::motion::{MovingTriangle, NEAR, Views};
use glam::Vec2;

/// A part of a segment's time, from 0 to 1; empty if it ends before it begins.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interval {
    /// When it begins.
    pub from: f32,
    /// When it ends.
    pub to: f32,
}

impl Interval {
    /// The whole segment.
    pub const ALL: Self = Self { from: 0.0, to: 1.0 };
    const NONE: Self = Self { from: f32::INFINITY, to: f32::NEG_INFINITY };

    /// Whether no instant belongs to it.
    pub fn is_empty(&self) -> bool {
        self.from > self.to
    }

    /// The shortest interval that has both.
    fn hull(self, other: Self) -> Self {
        Self { from: self.from.min(other.from), to: self.to.max(other.to) }
    }

    /// What both have.
    pub fn and(self, other: Self) -> Self {
        Self { from: self.from.max(other.from), to: self.to.min(other.to) }
    }

    /// Where a + (b − a)·t is not below 0 within the segment.
    fn where_linear([a, b]: [f32; 2]) -> Self {
        match (a >= 0.0, b >= 0.0) {
            (true, true) => Self::ALL,
            (false, false) => Self::NONE,
            (true, false) => Self { from: 0.0, to: (a / (a - b) + TIME_SLACK).min(1.0) },
            (false, true) => Self { from: (a / (a - b) - TIME_SLACK).max(0.0), to: 1.0 },
        }
    }

    /// The hull of where the quadratic with these Bernstein coefficients is not below 0 within the segment.
    fn where_quadratic([a, b, c]: [f32; 3]) -> Self {
        if a < 0.0 && b < 0.0 && c < 0.0 {
            return Self::NONE;
        }
        if a >= 0.0 && c >= 0.0 {
            return Self::ALL;
        }
        // (a − 2b + c)t² + 2(b − a)t + a: the roots, without cancellation.
        let (square, half) =
            (f64::from(a) - 2.0 * f64::from(b) + f64::from(c), f64::from(b) - f64::from(a));
        let discriminant = half * half - square * f64::from(a);
        if discriminant < 0.0 {
            // Below 0 at an end, and so everywhere.
            return Self::NONE;
        }
        let q = -(half + half.signum() * discriminant.sqrt());
        let roots = [q / square, f64::from(a) / q].map(|root| root as f32);
        let [first, last] = [roots[0].min(roots[1]), roots[0].max(roots[1])];
        let within = |root: f32| (0.0..=1.0).contains(&root);
        match (a >= 0.0, c >= 0.0) {
            // It falls through 0 once within.
            (true, false) => {
                let root = if within(first) { first } else { last };
                let root = if within(root) { root } else { 1.0 };
                Self { from: 0.0, to: (root + TIME_SLACK).min(1.0) }
            }
            (false, true) => {
                let root = if within(last) { last } else { first };
                let root = if within(root) { root } else { 0.0 };
                Self { from: (root - TIME_SLACK).max(0.0), to: 1.0 }
            }
            // Up and down again, if both roots are within.
            _ if within(first) && within(last) => {
                Self { from: (first - TIME_SLACK).max(0.0), to: (last + TIME_SLACK).min(1.0) }
            }
            // Roots that are not numbers tell nothing.
            _ if first.is_nan() || last.is_nan() => Self::ALL,
            _ => Self::NONE,
        }
    }
}

/// What rounding can move a time.
const TIME_SLACK: f32 = 1e-5;

/// What rounding can change a sum of products, as part of the sum of their sizes.
const SLACK: f32 = 2e-6;

/// A rectangle of the image, in pixels from its corner.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rectangle {
    /// Its upper left corner.
    pub min: Vec2,
    /// Its lower right corner.
    pub max: Vec2,
}

/// The rectangle that a triangle in all its views stays in from one time to another, or nothing if it may come behind
/// the camera. In front of it what goes straight in homogeneous coordinates goes straight in the image.
pub fn swept(views: &Views, between: Interval) -> Option<Rectangle> {
    let mut swept = Rectangle { min: Vec2::INFINITY, max: Vec2::NEG_INFINITY };
    for triangle in views.all() {
        for time in [between.from, between.to] {
            for k in 0..3 {
                let q = triangle.start[k] + (triangle.end[k] - triangle.start[k]) * time;
                if q.z < 1e-3 {
                    return None;
                }
                let place = q.truncate() / q.z;
                let slack = 1e-3 + SLACK * place.abs();
                swept.min = swept.min.min(place - slack);
                swept.max = swept.max.max(place + slack);
            }
        }
    }
    Some(swept)
}

/// When the triangle can be seen in `tile` by the planes through the camera and its sides, and when it is in front of
/// the camera. Its corners' distances from them are linear in time; it is on the inner side of a plane while one of
/// its corners is, in one of its views.
pub fn by_planes(views: &Views, tile: &Rectangle) -> Interval {
    let when = |distance: &dyn Fn(glam::Vec3) -> (f32, f32)| {
        let corners = views.all().iter().flat_map(|view| view.start.into_iter().zip(view.end));
        corners.fold(Interval::NONE, |hull, (start, end)| {
            let at = |q| {
                let (distance, size) = distance(q);
                distance + SLACK * size
            };
            hull.hull(Interval::where_linear([at(start), at(end)]))
        })
    };
    let x = |side: f32, sign: f32| {
        move |q: glam::Vec3| (sign * (q.x - side * q.z), q.x.abs() + (side * q.z).abs())
    };
    let y = |side: f32, sign: f32| {
        move |q: glam::Vec3| (sign * (q.y - side * q.z), q.y.abs() + (side * q.z).abs())
    };
    let interval = when(&|q| (q.z - NEAR, q.z.abs()));
    let interval = interval.and(when(&x(tile.min.x, 1.0))).and(when(&x(tile.max.x, -1.0)));
    interval.and(when(&y(tile.min.y, 1.0))).and(when(&y(tile.max.y, -1.0)))
}

/// When the triangle can be seen in `tile` by its edges: while for each of them one of the tile's corners is on its
/// inner side, in one of the views. Which side that is follows from how the triangle is turned; if that may change, this
/// tells nothing.
pub fn by_edges(views: &Views, tile: &Rectangle) -> Interval {
    let Some(sign) = turned(views) else { return Interval::ALL };
    let corners =
        [tile.min, Vec2::new(tile.max.x, tile.min.y), tile.max, Vec2::new(tile.min.x, tile.max.y)];
    let mut interval = Interval::ALL;
    for edge in [[1, 2], [2, 0], [0, 1]] {
        let mut hull = Interval::NONE;
        for triangle in views.all() {
            for corner in corners {
                hull = hull.hull(beyond_edge(triangle, edge, corner, sign));
            }
        }
        interval = interval.and(hull);
    }
    interval
}

/// When a corner of a tile is on the inner side of an edge.
fn beyond_edge(triangle: &MovingTriangle, [i, j]: [usize; 2], corner: Vec2, sign: f32) -> Interval {
    let from = |q: glam::Vec3| q.truncate() - corner * q.z;
    let [i0, j0] = [i, j].map(|k| from(triangle.start[k]));
    let [i1, j1] = [i, j].map(|k| from(triangle.end[k]));
    // What rounding leaves uncertain of the vectors themselves, and of their product.
    let size = |q: glam::Vec3| (q.truncate().abs() + (corner * q.z).abs()).max_element();
    let [si, sj] = [i, j].map(|k| size(triangle.start[k]).max(size(triangle.end[k])));
    let lengths = |a: Vec2, b: Vec2| a.abs().max_element().max(b.abs().max_element());
    let slack = 4.0 * SLACK * (si * lengths(j0, j1) + sj * lengths(i0, i1));
    let product = |a: Vec2, b: Vec2| sign * a.perp_dot(b);
    let middle = 0.5 * (product(i0, j1) + product(i1, j0));
    let coefficients = [product(i0, j0), middle, product(i1, j1)];
    Interval::where_quadratic(coefficients.map(|value| value + slack))
}

/// 1 if the triangle's corners go around counter-clockwise as the camera sees them, in the y-down image clockwise, at
/// any time of the segment and in any view, −1 if the other way; nothing if it may turn over.
fn turned(views: &Views) -> Option<f32> {
    let mut signs = views.all().iter().map(turned_in);
    let first = signs.next()?;
    signs.all(|sign| sign == first).then_some(first)?
}

/// The same in one view, by the Bernstein coefficients of the cubic determinant.
fn turned_in(triangle: &MovingTriangle) -> Option<f32> {
    let [a0, b0, c0] = triangle.start.map(|q| q.as_dvec3());
    let [a1, b1, c1] = triangle.end.map(|q| q.as_dvec3());
    let volume = |a: glam::DVec3, b: glam::DVec3, c: glam::DVec3| a.dot(b.cross(c));
    let coefficients = [
        volume(a0, b0, c0),
        volume(a1, b0, c0) + volume(a0, b1, c0) + volume(a0, b0, c1),
        volume(a0, b1, c1) + volume(a1, b0, c1) + volume(a1, b1, c0),
        volume(a1, b1, c1),
    ];
    let size = |a: &[glam::Vec3; 3]| a.iter().map(|q| f64::from(q.length())).product::<f64>();
    // Seen so nearly edge on, either side is within the slack of the edges.
    let slack = 1e-12 * size(&triangle.start).max(size(&triangle.end));
    match coefficients {
        all if all.iter().all(|&c| c > slack) => Some(1.0),
        all if all.iter().all(|&c| c < -slack) => Some(-1.0),
        _ => None,
    }
}
