//! The motion of an object of a stimulus, as the renderer shows it.

use super::{Instant, NEAR, ScreenPaths, camera_turn, steps_of, to_image};
use crate::scene::object::Object;
use glam::{DAffine3, DMat3, Vec3};
use shutterlab_stimuli::stimulus::View;
use shutterlab_stimuli::{Stimulus, scene};
use std::f64::consts::TAU;
use std::ops::Range;

impl ScreenPaths {
    /// The paths of the points that `to_object` takes to the own space of `object`, which is one of the scene of
    /// `stimulus`. The window is the shutter intervals of `frames` (of the first, if it is empty), for either eye;
    /// its middle is that of the middle frame for the left eye.
    pub fn of_stimulus(
        stimulus: &Stimulus,
        object: &scene::Object,
        to_object: DAffine3,
        frames: Range<u32>,
    ) -> Self {
        let frames = frames.start..frames.end.max(frames.start + 1);
        let intervals: Vec<(View, Object)> = frames
            .clone()
            .flat_map(|frame| {
                let moving = Object::new(stimulus, object, 0.0, frame);
                stimulus.views(frame).into_iter().map(move |view| (view, moving))
            })
            .collect();
        let eyes = intervals.len() / frames.len();
        let middle_run = frames.len() / 2 * eyes;
        let turn = |(view, object): &(View, Object)| {
            camera_turn(view) + TAU * f64::from(object.turns_per_m * object.travel).abs()
        };
        let steps = steps_of(intervals.iter().map(turn).fold(0.0, f64::max));
        let run = |(view, object): &(View, Object)| {
            let instant = |k| {
                let time = k as f64 / steps as f64 - 0.5;
                let pose = object.at(time as f32);
                let axes =
                    [Vec3::X, Vec3::Y, Vec3::Z].map(|v| object.to_world(&pose, v).as_dvec3());
                let axes = DMat3::from_cols(axes[0], axes[1], axes[2]);
                let to_world = DAffine3::from_mat3_translation(axes, pose.centre.as_dvec3());
                let to_image = to_image(view, stimulus.image.width_px, time) * to_world * to_object;
                Instant { to_image: to_image.as_affine3a(), pose: pose.time }
            };
            (0..=steps).map(instant).collect()
        };
        let near = NEAR * intervals[middle_run].0.camera.look_at_distance_m();
        Self::new(intervals.iter().map(run).collect(), middle_run, steps, near)
    }
}
