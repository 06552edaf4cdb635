//! Distribution ray tracing (Cook, Porter and Carpenter 1984) of the rolling sphere: each sample of a
//! pixel is one path, with its own point in the pixel and its own instant of the shutter interval.
//!
//! Method, for sample s of a pixel:
//! 1. draw a point of the pixel (box filter) and an instant of the shutter interval (by its profile);
//! 2. follow the ray; at each of at most five surface hits, draw a light direction from the
//!    environment (next-event estimation) and one from the cosine law to go on;
//! 3. weigh the two by the balance heuristic (Veach and Guibas 1995). With a Lambertian surface of
//!    albedo ρ the light sample adds ρ/π · L cos θ / (p_light + p_cosine), and light met by going
//!    on adds ρ · L · p_cosine / (p_light + p_cosine);
//! 4. nothing is clamped, and there is no roulette: the fifth hit still sees the light.
//!
//! | symbol | here |
//! |---|---|
//! | shutter instant | `shutter` ∈ [−½, ½], the part of the interval from its middle |
//! | block 0 of a sample's words | x, y in the pixel, instant, shift of the camera's look at the sky |
//! | block 1 + k | two for the light sample at hit k, two for the direction to go on |
//!
//! The scalar twin in [`mod@reference`] is the specification; `trace.wgsl` follows it line by line
//! with the same random words. A surface's own kind tells what a ray that leaves it can meet: from the
//! floor only the sphere, from the sphere only the floor, so no ray needs an offset.

#[cfg(feature = "gpu")]
pub mod compute;
pub mod reference;
#[cfg(test)]
mod tests;

use crate::sampling::random::StreamKey;
use crate::scene::camera::Camera;
use crate::scene::motion::Rolling;
use crate::scene::shutter::Shutter;
use crate::shading::material::Material;
use bytemuck::{Pod, Zeroable};
use glam::Vec3;
use shutterlab_stimuli::stimulus::{Sampler, View};
use shutterlab_stimuli::{Stimulus, scene};

/// Surface hits along a path.
pub const MAX_HITS: u32 = 5;

/// What is made of `description`: kept from the last frame, or made anew where that had another.
fn kept<'a, T, E>(
    last: &'a mut Option<(scene::Environment, T)>,
    description: &scene::Environment,
    make: impl FnOnce() -> Result<T, E>,
) -> Result<&'a T, E> {
    let kept = match last.take() {
        Some(kept) if kept.0 == *description => kept,
        _ => (description.clone(), make()?),
    };
    Ok(&last.insert(kept).1)
}

/// One frame as both devices read it. `trace.wgsl` declares the same struct; a test compares them.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct FrameParams {
    /// The pinhole.
    pub camera_position: Vec3,
    /// Pixels per row.
    pub width: u32,
    /// Towards the centre of the image.
    pub camera_forward: Vec3,
    /// Rows.
    pub height: u32,
    /// Towards the right of the image.
    pub camera_right: Vec3,
    /// Distance of the image plane in pixels.
    pub focal_length_px: f32,
    /// Towards the top of the image.
    pub camera_up: Vec3,
    /// Radius of the sphere.
    pub sphere_radius: f32,
    /// See [`Rolling::x`].
    pub rolling_x: f32,
    /// See [`Rolling::travel`].
    pub rolling_travel: f32,
    /// See [`Rolling::turns`].
    pub rolling_turns: f32,
    /// See [`Rolling::bounce`].
    pub rolling_bounce: f32,
    /// Albedo of the floor.
    pub floor_albedo: f32,
    /// Half the side of the floor.
    pub floor_half_side: f32,
    /// Number of the first sample to draw.
    pub first_sample: u32,
    /// How many samples to draw.
    pub sample_count: u32,
    /// See [`StreamKey`].
    pub key: [u32; 2],
    /// How many samples a pixel has in all, for the sampler that needs to know.
    pub strata: u32,
    /// The [`Sampler`].
    pub sampler: u32,
    /// See [`Shutter::kind`].
    pub shutter_kind: u32,
    /// See [`Shutter::width`].
    pub shutter_width: f32,
    /// See [`Shutter::reach`].
    pub shutter_reach: f32,
    /// Where the camera's axis meets the image, in pixels to the right of its centre.
    pub shift_px: f32,
    /// The sphere's pattern.
    pub material: Material,
}

impl FrameParams {
    /// Frame number `frame` of `stimulus` as `view` sees it, with all its samples.
    pub fn new(stimulus: &Stimulus, view: &View, frame: u32) -> Self {
        let camera = Camera::new(&view.camera, stimulus.image.width_px);
        let rolling = Rolling::new(&stimulus.sphere_path(frame));
        let shutter = Shutter::new(stimulus.shutter_profile);
        let StreamKey(key) = StreamKey::new(
            stimulus.seed,
            &stimulus.noise_stream,
            stimulus.exemplar,
            view.noise,
            frame,
        );
        Self {
            camera_position: camera.position,
            width: stimulus.image.width_px,
            camera_forward: camera.forward,
            height: stimulus.image.height_px,
            camera_right: camera.right,
            focal_length_px: camera.focal_length_px,
            camera_up: camera.up,
            sphere_radius: stimulus.scene.sphere.radius_m as f32,
            rolling_x: rolling.x,
            rolling_travel: rolling.travel,
            rolling_turns: rolling.turns,
            rolling_bounce: rolling.bounce,
            floor_albedo: stimulus.scene.floor.albedo as f32,
            floor_half_side: (0.5 * stimulus.scene.floor.side_m) as f32,
            first_sample: 0,
            sample_count: stimulus.samples,
            key,
            strata: stimulus.samples,
            sampler: stimulus.sampler as u32,
            shutter_kind: shutter.kind,
            shutter_width: shutter.width,
            shutter_reach: shutter.reach,
            shift_px: view.shift_px as f32,
            material: Material::new(&stimulus.material),
        }
    }

    /// The sampler.
    fn sampler(&self) -> Sampler {
        let all = [Sampler::Random, Sampler::Stratified, Sampler::Sobol];
        // The number was one of these, and a wrong one is an ordinary sampler all the same.
        all.into_iter().find(|&s| s as u32 == self.sampler).unwrap_or(Sampler::Random)
    }

    /// The shutter.
    fn shutter(&self) -> Shutter {
        Shutter { kind: self.shutter_kind, width: self.shutter_width, reach: self.shutter_reach }
    }

    /// The sphere's motion.
    fn rolling(&self) -> Rolling {
        Rolling {
            x: self.rolling_x,
            travel: self.rolling_travel,
            turns: self.rolling_turns,
            bounce: self.rolling_bounce,
        }
    }
}
