//! Distribution ray tracing (Cook, Porter and Carpenter 1984): each sample of a pixel is one path, with its
//! own point in the pixel and its own instant of the shutter interval, at which all that moves stands still.
//!
//! Method, for sample s of a pixel:
//! 1. draw a point of the pixel (box filter) and an instant of the shutter interval (by its profile);
//! 2. follow the ray; at each of at most five surface hits, look at every light without extent, draw a
//!    light direction from the environment (next-event estimation) and one from the surface to go on;
//! 3. weigh the two by the balance heuristic (Veach and Guibas 1995): the light sample adds
//!    f · L cos θ / (p_light + p_surface), and light met by going on adds
//!    f cos θ / p_surface · L · p_surface / (p_light + p_surface);
//! 4. nothing is clamped, and there is no roulette: the fifth hit still sees the light.
//!
//! | symbol | here |
//! |---|---|
//! | shutter instant | `shutter` ∈ [−½, ½], the part of the interval from its middle |
//! | block 0 of a sample's words | x, y in the pixel, instant, shift of the camera's look at the sky |
//! | block 1 + k | two for the light sample at hit k, two for the direction to go on |
//!
//! The scalar twin in [`mod@reference`] is the specification; `trace.wgsl` follows it line by line
//! with the same random words.

#[cfg(feature = "gpu")]
pub mod compute;
pub mod reference;
#[cfg(test)]
mod tests;

use crate::sampling::random::StreamKey;
use crate::scene::camera::Camera;
use crate::scene::environment::Environment;
use crate::scene::import::ImportError;
use crate::scene::object::Object;
use crate::scene::shutter::Shutter;
use crate::scene::world::World;
use crate::shading::bsdf::Bsdf;
use crate::shading::material::Material;
use bytemuck::{Pod, Zeroable};
use shutterlab_stimuli::stimulus::{Sampler, View};
use shutterlab_stimuli::{Stimulus, scene};
use std::path::Path;

/// Surface hits along a path.
pub const MAX_HITS: u32 = 5;

/// What frames of stimuli have in common: made anew only where they have not.
#[derive(Debug)]
struct Kept<E, W> {
    environment: Option<(scene::Environment, E)>,
    world: Option<(scene::Scene, scene::Material, W)>,
}

impl<E, W> Default for Kept<E, W> {
    fn default() -> Self {
        Self { environment: None, world: None }
    }
}

impl<E, W> Kept<E, W> {
    /// The environment and the world of `stimulus`, with what a device makes of them; files are taken from
    /// `assets`.
    fn of<F: From<ImportError>>(
        &mut self,
        stimulus: &Stimulus,
        assets: &Path,
        environment: impl FnOnce(Environment) -> Result<E, F>,
        world: impl FnOnce(World) -> Result<W, F>,
    ) -> Result<(&E, &W), F> {
        let (scene, material) = (&stimulus.scene, &stimulus.material);
        let kept = match self.environment.take() {
            Some(kept) if kept.0 == scene.environment => kept,
            _ => {
                let loaded = Environment::load(&scene.environment, assets)?;
                (scene.environment.clone(), environment(loaded)?)
            }
        };
        let kept_world = match self.world.take() {
            Some(kept) if kept.0 == *scene && kept.1 == *material => kept,
            _ => {
                let loaded = World::load(stimulus, assets)?;
                (scene.clone(), material.clone(), world(loaded)?)
            }
        };
        Ok((&self.environment.insert(kept).1, &self.world.insert(kept_world).2))
    }
}

/// One frame as both devices read it. `trace.wgsl` declares the same struct; a test compares them.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct FrameParams {
    /// The camera.
    pub camera: Camera,
    /// Pixels per row.
    pub width: u32,
    /// Rows.
    pub height: u32,
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
    /// Fills up to a multiple of 16 bytes.
    pub padding: u32,
}

/// A frame: its parameters, and the objects of its world with their surfaces.
#[derive(Clone, Debug, PartialEq)]
pub struct Frame {
    /// What is alike in all scenes.
    pub params: FrameParams,
    /// The objects, in the order of their world.
    pub objects: Vec<Object>,
    /// The pattern of each.
    pub materials: Vec<Material>,
    /// How each scatters light.
    pub bsdfs: Vec<Bsdf>,
}

impl Frame {
    /// Frame number `frame` of `stimulus`, whose world is `world`, as `view` sees it, with all its samples.
    pub fn new(stimulus: &Stimulus, world: &World, view: &View, frame: u32) -> Self {
        let shutter = Shutter::new(stimulus.shutter_profile);
        let StreamKey(key) = StreamKey::new(
            stimulus.seed,
            &stimulus.noise_stream,
            stimulus.exemplar,
            view.noise,
            frame,
        );
        let params = FrameParams {
            camera: Camera::new(view, stimulus.image.width_px),
            width: stimulus.image.width_px,
            height: stimulus.image.height_px,
            first_sample: 0,
            sample_count: stimulus.samples,
            key,
            strata: stimulus.samples,
            sampler: stimulus.sampler as u32,
            shutter_kind: shutter.kind,
            shutter_width: shutter.width,
            shutter_reach: shutter.reach,
            padding: 0,
        };
        let descriptions: Vec<_> = world.descriptions(stimulus).collect();
        let materials = || descriptions.iter().map(|object| stimulus.material_of(object));
        Self {
            params,
            objects: world.objects(stimulus, frame),
            materials: materials()
                .zip(&world.object_pictures)
                .map(|(material, &picture)| Material::new(material, picture))
                .collect(),
            bsdfs: materials().map(|material| Bsdf::new(material.coat())).collect(),
        }
    }
}

impl FrameParams {
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
}
