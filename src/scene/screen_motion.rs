//! How the points of an object are seen to move: their paths over the image, for simplification
//! (Zhang et al. 2014, §5.1 and Appendix B).
//!
//! While an instant lasts, what takes a point of the object to the image is an affine map followed by a
//! division, whatever the motions of object and camera are that make it. So a motion is a list of such maps,
//! a few per shutter interval, and a point's path is the chain of chords between its images. Where the path is
//! straight, as under translation in any direction, the chain has its very length; along an arc it is too short
//! by less than 2 in 10⁴, since no chord spans more than 4°. Too short is the safe side: it simplifies less.

mod described;
mod nearest_point;
mod of_stimulus;
#[cfg(test)]
mod tests;

pub use described::{Described, Rule, Turn, camera, framing};

use crate::mesh::simplify::direction::{ScreenMotion, Seen};
use glam::{Affine3A, DAffine3, DVec3, Vec2, Vec3, Vec3A};
use nearest_point::NearestPoint;
use shutterlab_stimuli::scene::Camera;
use shutterlab_stimuli::stimulus::View;

/// The largest angle that a step turns by, in radians.
const STEP_ANGLE: f64 = 4.0 * std::f64::consts::PI / 180.0;

/// Most steps of a shutter interval. What turns by more than 256° meanwhile takes longer ones.
const MOST_STEPS: usize = 64;

/// Nearer to the camera than this part of the distance that it looks at, points count as not seen.
const NEAR: f64 = 1e-3;

/// Largest coordinate and speed that is told, in pixels.
const FARTHEST_PX: f32 = 1e9;

/// Magnification of what comes too near to be seen, and the largest that is told.
const MOST_MAGNIFIED: f32 = 1e6;

/// The paths of an object's points over the image during a time window.
#[derive(Clone, Debug, PartialEq)]
pub struct ScreenPaths {
    /// Instants in even steps, shutter interval by shutter interval; intervals that follow one another without
    /// a gap are one run, in which any shutter may open at any step.
    runs: Vec<Vec<Instant>>,
    /// Steps of a shutter interval; even, so that there is one in the middle.
    steps: usize,
    /// The instants about that of half the window: one step before, it, one step after.
    middle: [Instant; 3],
    /// Distance along the view from which points are seen.
    near: f32,
    /// Tells the speed, if the rule of Appendix B does.
    nearest: Option<NearestPoint>,
}

/// How points are seen at one instant.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Instant {
    /// Takes a point of the object to (x·z, y·z, z): x and y in pixels from the centre of the image, to the right
    /// and downwards; z the distance along the view.
    to_image: Affine3A,
    /// Where between its keyframes a point is: 0 at the first, 1 at the second.
    pose: f32,
}

impl Instant {
    /// As `to_image`, of the point with these keyframes.
    fn see(&self, [start, end]: [Vec3; 2]) -> Vec3A {
        let point = Vec3A::from(start) * (1.0 - self.pose) + Vec3A::from(end) * self.pose;
        self.to_image.transform_point3a(point)
    }
}

/// The place in the image of what is at (x·z, y·z, z); finite if that is and z is above 0.
fn project(seen: Vec3A) -> Vec2 {
    let limit = Vec2::splat(FARTHEST_PX);
    (seen.truncate() / seen.z).clamp(-limit, limit)
}

impl ScreenPaths {
    /// `runs` and `steps` as the fields have them; the middle of the window is that of `middle_run`.
    fn new(runs: Vec<Vec<Instant>>, middle_run: usize, steps: usize, near: f64) -> Self {
        let run = &runs[middle_run];
        let half = run.len() / 2;
        let middle = [run[half - 1], run[half], run[half + 1]];
        Self { middle, runs, steps, near: near as f32, nearest: None }
    }

    /// Least length of a point's path during a shutter interval and its least distance along the view; none if
    /// it is not seen at every instant.
    fn least(&self, keyframes: [Vec3; 2]) -> Option<[f32; 2]> {
        let image = |instant: &Instant| {
            let seen = instant.see(keyframes);
            (seen.is_finite() && seen.z > self.near).then(|| (project(seen), seen.z))
        };
        let [mut shortest, mut nearest] = [f32::INFINITY; 2];
        for run in &self.runs {
            let (mut before, distance) = image(&run[0])?;
            nearest = nearest.min(distance);
            // In double precision: one long chord must not leave its rounding in all that follow.
            let mut swept = 0.0f64;
            for k in 1..run.len() {
                let (here, distance) = image(&run[k])?;
                nearest = nearest.min(distance);
                swept += f64::from(here.distance(before));
                before = here;
                if k >= self.steps {
                    shortest = shortest.min(swept as f32);
                    // The next shutter interval begins a step later, if there is one.
                    if k + 1 < run.len() {
                        let [first, second] = [k - self.steps, k - self.steps + 1];
                        swept -= f64::from(image(&run[first])?.0.distance(image(&run[second])?.0));
                    }
                }
            }
        }
        Some([shortest, nearest])
    }
}

impl ScreenMotion for ScreenPaths {
    /// The size in the image goes by the distance along the view: that a piece of surface is turned to the camera
    /// or away from it is not counted. What comes behind the camera or very near to it counts as at rest and
    /// magnified a million times, so that a limit of size leaves it alone.
    fn seen(&self, keyframes: [Vec3; 2]) -> Seen {
        let [before, here, after] = self.middle.map(|instant| instant.see(keyframes));
        let Some([swept, nearest]) = self.least(keyframes) else {
            let in_front = here.with_z(here.z.max(self.near.max(f32::MIN_POSITIVE)));
            let place = project(in_front);
            let position_px = if place.is_nan() { Vec2::ZERO } else { place };
            return Seen { position_px, magnification: MOST_MAGNIFIED, ..Seen::default() };
        };
        let speed = match &self.nearest {
            Some(rule) => rule.speed_px(keyframes, self.near),
            None => swept,
        };
        Seen {
            position_px: project(here),
            velocity_px: (project(after) - project(before)) * (0.5 * self.steps as f32),
            speed_px: speed.clamp(0.0, FARTHEST_PX),
            magnification: (here.z / nearest).clamp(1.0, MOST_MAGNIFIED),
        }
    }
}

/// How many steps a shutter interval needs in which something turns by `angle`, in radians.
fn steps_of(angle: f64) -> usize {
    // A value that is not a number becomes 0.
    let pairs = (0.5 * angle.abs() / STEP_ANGLE).ceil() as usize;
    2 * pairs.clamp(1, MOST_STEPS / 2)
}

/// Takes a point of the world to (x·z, y·z, z), as [`Described::to_image`] does, when the camera of `view` has
/// gone `time` of the way that it goes per shutter.
pub fn to_image(view: &View, width_px: u32, time: f64) -> DAffine3 {
    let camera = camera_at(view, time);
    let (forward, right) = (DVec3::from(camera.forward()), DVec3::from(camera.right()));
    let focal_length = camera.focal_length_px(width_px);
    let rows = glam::DMat3::from_cols(
        right * focal_length + forward * view.shift_px,
        forward.cross(right) * focal_length,
        forward,
    );
    let turn = rows.transpose();
    DAffine3::from_mat3_translation(turn, -(turn * DVec3::from(camera.position_m)))
}

/// The camera of `view` where it is then.
fn camera_at(view: &View, time: f64) -> Camera {
    let [position, look_at] = view.travel_m;
    let moved = |from: [f64; 3], by: [f64; 3]| std::array::from_fn(|i| from[i] + by[i] * time);
    Camera {
        position_m: moved(view.camera.position_m, position),
        look_at_m: moved(view.camera.look_at_m, look_at),
        ..view.camera.clone()
    }
}

/// By how much the camera of `view` turns while the shutter is open, in radians.
fn camera_turn(view: &View) -> f64 {
    let [before, after] = [-0.5, 0.5].map(|time| DVec3::from(camera_at(view, time).forward()));
    before.angle_between(after)
}
