//! What bounds must keep and what they leave out.

use super::TILE;
use super::bounds::{Interval, Rectangle, by_edges, by_planes, swept};
use super::motion::{MovingTriangle, Views};
use super::reference::each_tile;
use crate::sampling::random::{StreamKey, unit};
use crate::sampling::warp::concentric_disk;
use crate::scene::camera::Camera;
use bytemuck::Zeroable;
use glam::{Vec2, Vec3};

const TILES: u32 = 8;
const SIDE: f32 = (TILES * TILE) as f32;

/// Numbers in [0, 1), one after the other.
struct Numbers {
    key: StreamKey,
    next: u32,
}

impl Numbers {
    fn new(name: &str) -> Self {
        Self { key: StreamKey::new(1, name, 0, 0, 0), next: 0 }
    }

    fn one(&mut self) -> f32 {
        self.next += 1;
        unit(self.key.words(self.next, 0, 0)[0])
    }

    fn between(&mut self, low: f32, high: f32) -> f32 {
        low + (high - low) * self.one()
    }
}

/// Triangles of all sizes and speeds in and about the image; of every five, two have corners behind the camera, at one
/// end of their time or at both, and one turns over.
fn triangles(count: usize) -> Vec<MovingTriangle> {
    let mut numbers = Numbers::new("triangles");
    let mut all = vec![];
    for index in 0..count {
        let size = SIDE * numbers.one().powi(4).max(1e-3);
        let speed = SIDE * numbers.one().powi(2);
        let middle = Vec2::new(numbers.between(-0.2, 1.2), numbers.between(-0.2, 1.2)) * SIDE;
        let shift = Vec2::new(numbers.between(-1.0, 1.0), numbers.between(-1.0, 1.0)) * speed;
        let mut corner = |moved: Vec2| {
            let place = middle
                + moved
                + Vec2::new(numbers.between(-1.0, 1.0), numbers.between(-1.0, 1.0)) * size;
            let z = match index % 5 {
                0 => numbers.between(-2.0, 3.0),
                1 => numbers.between(-0.01, 0.05),
                _ => numbers.between(0.5, 8.0),
            };
            Vec3::new(place.x * z, place.y * z, z)
        };
        let start: [Vec3; 3] = std::array::from_fn(|_| corner(Vec2::ZERO));
        let end = match index % 5 {
            // The same triangle elsewhere, at other depths; or any other.
            2 | 3 => start.map(|q| {
                let z = q.z + numbers.between(-0.2, 0.2);
                let place = q.truncate() / q.z + shift;
                Vec3::new(place.x * z, place.y * z, z)
            }),
            _ => std::array::from_fn(|_| corner(shift)),
        };
        all.push(MovingTriangle { start, end });
    }
    all
}

/// A pinhole.
fn pinhole() -> Camera {
    Camera { focus_distance: 2.0, ..Camera::zeroed() }
}

/// A lens that makes circles of up to 30 pixels of what is half a metre away.
fn lens() -> Camera {
    Camera { lens_radius: 0.1, focal_length_px: 100.0, ..pinhole() }
}

/// The intervals of all tiles, nothing where the triangle cannot be seen.
fn intervals(views: &Views) -> Vec<Option<Interval>> {
    let mut found = vec![None; (TILES * TILES) as usize];
    // The upper half and the lower half by themselves.
    for first in [0, TILES / 2] {
        each_tile(views, TILES, &(first..first + TILES / 2), |tile, interval| {
            found[(first * TILES + tile) as usize] = Some(interval);
        });
    }
    found
}

#[test]
fn no_sample_of_a_pinhole_is_missed() {
    no_sample_is_missed(&pinhole());
}

#[test]
fn no_sample_of_a_lens_is_missed() {
    no_sample_is_missed(&lens());
}

/// No sample that a look at every triangle finds is left out, with corners in front of the camera and behind it. Half of
/// the samples are aimed at the triangle, for few would meet the small ones.
fn no_sample_is_missed(camera: &Camera) {
    let mut numbers = Numbers::new("samples");
    let (mut hits, mut hits_behind) = (0, 0);
    for triangle in triangles(10_000) {
        let intervals = intervals(&Views::new(triangle, camera));
        let is_behind = triangle.start.iter().chain(&triangle.end).any(|q| q.z <= 0.0);
        for sample in 0..400 {
            let time = numbers.one();
            let lens = concentric_disk([numbers.one(), numbers.one()]);
            let triangle = triangle.seen_from(camera.parallax(lens));
            let mut point = Vec2::new(numbers.one(), numbers.one()) * SIDE;
            if sample % 2 == 0 {
                let mut weights = [numbers.one(), numbers.one(), numbers.one()];
                let sum: f32 = weights.iter().sum();
                weights.iter_mut().for_each(|weight| *weight /= sum);
                let q: Vec3 = (0..3)
                    .map(|k| {
                        (triangle.start[k] * (1.0 - time) + triangle.end[k] * time) * weights[k]
                    })
                    .sum();
                let aimed = q.truncate() / q.z;
                if aimed.cmpge(Vec2::ZERO).all() && aimed.cmplt(Vec2::splat(SIDE)).all() {
                    point = aimed;
                }
            }
            if triangle.hit(point, time).is_none() {
                continue;
            }
            hits += 1;
            hits_behind += u32::from(is_behind);
            let [x, y] = (point / TILE as f32).to_array().map(|at| at as u32);
            let interval = intervals[(y * TILES + x) as usize];
            assert!(
                interval.is_some_and(|i| i.from <= time && time <= i.to),
                "{triangle:?} at {point} {time} {lens}: {interval:?}"
            );
        }
    }
    assert!(hits > 500_000 && hits_behind > 100_000, "{hits} {hits_behind}");
}

/// The bounds are worth their while: of the samples that they leave, more meet the triangle than of those in the box
/// that it sweeps over.
#[test]
fn bounds_leave_fewer_samples_than_a_moving_box() {
    let mut numbers = Numbers::new("efficiency");
    let (mut in_box, mut by_first, mut by_both, mut hits) = (0.0, 0.0, 0.0, 0.0);
    for triangle in triangles(3000) {
        let views = Views::new(triangle, &pinhole());
        for tile in 0..TILES * TILES {
            let min = Vec2::new((tile % TILES) as f32, (tile / TILES) as f32) * TILE as f32;
            let tile = Rectangle { min, max: min + TILE as f32 };
            let meets = |swept: Rectangle| {
                swept.min.cmple(tile.max).all() && swept.max.cmpge(tile.min).all()
            };
            if !swept(&views, Interval::ALL).is_none_or(meets) {
                continue;
            }
            let length = |interval: Interval| (interval.to - interval.from).max(0.0);
            let first = by_planes(&views, &tile);
            in_box += 1.0;
            by_first += length(first);
            by_both += length(first.and(by_edges(&views, &tile)));
            for _ in 0..8 {
                let point = min + Vec2::new(numbers.one(), numbers.one()) * TILE as f32;
                hits += if triangle.hit(point, numbers.one()).is_some() { 0.125 } else { 0.0 };
            }
        }
    }
    assert!(
        by_both < by_first && by_first < in_box && hits < by_both,
        "{hits} {by_both} {by_first} {in_box}"
    );
    assert!(hits / by_both > 1.5 * hits / in_box, "{hits} {by_both} {by_first} {in_box}");
}

/// Two triangles that share an edge leave no sample along it to neither.
#[test]
fn neighbours_leave_no_gap() {
    let mut numbers = Numbers::new("neighbours");
    for triangle in triangles(2000) {
        let [a, b, c] = triangle.start;
        let [d, e, f] = triangle.end;
        // The fourth corner on the other side of the edge between the first two.
        let (other, other_end) = (a + b - c, d + e - f);
        let twin = MovingTriangle { start: [b, a, other], end: [e, d, other_end] };
        for _ in 0..100 {
            let (time, along) = (numbers.one(), numbers.one());
            let at = |from: Vec3, to: Vec3| from + (to - from) * time;
            let (p, q) = (at(a, d), at(b, e));
            let edge = p + (q - p) * along;
            let depths = [p.z, q.z, at(c, f).z, at(other, other_end).z];
            let point = edge.truncate() / edge.z;
            if depths.iter().any(|&z| z < 0.1)
                || !point.is_finite()
                || !(0.01..=0.99).contains(&along)
            {
                continue;
            }
            // Too narrow to be told from nothing.
            let area = |triangle: &MovingTriangle| {
                let [p, q, r] = std::array::from_fn(|k| {
                    let corner = at(triangle.start[k], triangle.end[k]);
                    corner.truncate() / corner.z
                });
                (q - p).perp_dot(r - p).abs() / (q - p).length()
            };
            if area(&triangle) < 0.5 || area(&twin) < 0.5 {
                continue;
            }
            let is_met = triangle.hit(point, time).is_some() || twin.hit(point, time).is_some();
            assert!(is_met, "{triangle:?} at {point} {time}");
        }
    }
}
