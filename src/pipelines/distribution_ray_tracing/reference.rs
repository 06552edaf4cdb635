//! The CPU twin: scalar, one path after the other, rows in parallel. It is the specification that
//! `trace.wgsl` is held to, and the fallback where there is no GPU.

use super::{FrameParams, MAX_HITS, kept};
use crate::film::Film;
use crate::pipelines::Pipeline;
use crate::sampling::random::{StreamKey, unit};
use crate::sampling::sampler;
use crate::sampling::warp::{cosine_hemisphere, sin_cos_turns};
use crate::scene::environment::{Environment, luminance};
use glam::{Vec3, Vec4};
use rayon::prelude::*;
use shutterlab_stimuli::generate::RenderError;
use shutterlab_stimuli::stimulus::View;
use shutterlab_stimuli::{Stimulus, scene};
use std::f32::consts::FRAC_1_PI;
use std::path::{Path, PathBuf};

/// The pipeline on the processor.
#[derive(Debug)]
pub struct OnCpu {
    assets: PathBuf,
    environment: Option<(scene::Environment, Environment)>,
}

impl OnCpu {
    /// The pipeline with the files in `assets`.
    pub fn new(assets: &Path) -> Self {
        Self { assets: assets.into(), environment: None }
    }
}

impl Pipeline for OnCpu {
    fn films(
        &mut self,
        stimulus: &Stimulus,
        view: &View,
        frame: u32,
        samples: &[u32],
    ) -> Result<Vec<Film>, RenderError> {
        let description = &stimulus.scene.environment;
        let environment = kept(&mut self.environment, description, || {
            Environment::load(description, &self.assets)
        })?;
        Ok(trace(&FrameParams::new(stimulus, view, frame), environment, samples))
    }
}

/// Draws the samples of every pixel from `frame.first_sample` on, and returns the film at each of the
/// numbers of `samples`, which ascend.
pub fn trace(frame: &FrameParams, environment: &Environment, samples: &[u32]) -> Vec<Film> {
    let (width, height) = (frame.width, frame.height);
    let mut sums = vec![Vec4::ZERO; (width * height) as usize];
    let mut drawn = 0;
    let mut film = |&count: &u32| {
        let (from, to) = (frame.first_sample + drawn, frame.first_sample + count);
        sums.par_chunks_mut(width as usize).enumerate().for_each(|(y, row)| {
            for (x, sum) in row.iter_mut().enumerate() {
                for sample in from..to {
                    let radiance = path_radiance(frame, environment, x as u32, y as u32, sample);
                    *sum += radiance.extend(luminance(radiance).powi(2));
                }
            }
        });
        drawn = count;
        Film { width, height, samples: count, sums: sums.clone() }
    };
    samples.iter().map(&mut film).collect()
}

#[derive(Clone, Copy, PartialEq)]
enum Surface {
    Floor,
    Sphere,
}

/// Radiance along one path through pixel (x, y).
fn path_radiance(
    frame: &FrameParams,
    environment: &Environment,
    x: u32,
    y: u32,
    sample: u32,
) -> Vec3 {
    let pixel = y * frame.width + x;
    let key = StreamKey(frame.key);
    let [start, mut words] =
        sampler::first_blocks(frame.sampler(), key, frame.strata, pixel, sample);

    let [in_x, in_y, instant, _] = start.map(unit);
    let (sphere_x, turns) =
        frame.rolling().at(frame.shutter().instant(instant), frame.sphere_radius);
    let center = Vec3::new(sphere_x, frame.sphere_radius, 0.0);

    let right =
        (x as f32 + in_x - 0.5 * frame.width as f32 - frame.shift_px) / frame.focal_length_px;
    let down = (y as f32 + in_y - 0.5 * frame.height as f32) / frame.focal_length_px;
    let mut origin = frame.camera_position;
    let mut direction =
        (frame.camera_forward + frame.camera_right * right - frame.camera_up * down).normalize();

    let mut radiance = Vec3::ZERO;
    let mut throughput = Vec3::ONE;
    // Density of the direction by the cosine law; the camera's own ray has none.
    let mut cosine_density = None;
    let mut met = intersect(frame, center, origin, direction, None);
    for hit in 0..MAX_HITS {
        let Some((surface, distance)) = met else { break };
        origin += direction * distance;
        let (normal, albedo) = match surface {
            Surface::Floor => {
                origin.y = 0.0;
                (Vec3::Y, Vec3::splat(frame.floor_albedo))
            }
            Surface::Sphere => {
                let normal = (origin - center) / frame.sphere_radius;
                (normal, frame.material.albedo(rotate_about_z(normal, turns)))
            }
        };
        throughput *= albedo;

        let [a, b, c, d] = words;
        let light = environment.sample([a, b]);
        let cosine = normal.dot(light.direction);
        if cosine > 0.0
            && intersect(frame, center, origin, light.direction, Some(surface)).is_none()
        {
            let density = light.density + cosine * FRAC_1_PI;
            radiance += throughput * light.radiance * (cosine * FRAC_1_PI / density);
        }

        direction = cosine_hemisphere(normal, [unit(c), unit(d)]);
        cosine_density = Some(normal.dot(direction).max(0.0) * FRAC_1_PI);
        met = intersect(frame, center, origin, direction, Some(surface));
        words = key.words(pixel, sample, 2 + hit);
    }
    if met.is_some() {
        return radiance;
    }
    match cosine_density {
        None => {
            let tent = [start[3] >> 16, start[3] & 0xffff].map(|half| half as f32 / 65536.0 - 0.5);
            environment.evaluate(direction, tent).0
        }
        Some(cosine_density) => {
            let (light, light_density) = environment.evaluate(direction, [0.0; 2]);
            // A direction along the surface may meet black: nothing over nothing.
            let densities = (cosine_density + light_density).max(1e-30);
            radiance + throughput * light * (cosine_density / densities)
        }
    }
}

/// The nearest surface that a ray from surface `from` meets, and how far away. A ray from the floor
/// can only meet the sphere, and one from the sphere only the floor.
fn intersect(
    frame: &FrameParams,
    center: Vec3,
    origin: Vec3,
    direction: Vec3,
    from: Option<Surface>,
) -> Option<(Surface, f32)> {
    if from != Some(Surface::Sphere)
        && let Some(distance) = sphere_distance(center, frame.sphere_radius, origin, direction)
    {
        return Some((Surface::Sphere, distance));
    }
    if from != Some(Surface::Floor)
        && let Some(distance) = floor_distance(frame.floor_half_side, origin, direction)
    {
        return Some((Surface::Floor, distance));
    }
    None
}

/// Distance to the near side of a sphere from a point outside it. The discriminant is taken from the
/// vector between the ray and the centre, which keeps its precision far away (Haines et al. 2019).
fn sphere_distance(center: Vec3, radius: f32, origin: Vec3, direction: Vec3) -> Option<f32> {
    let to_center = center - origin;
    let along = to_center.dot(direction);
    let across = to_center - direction * along;
    let discriminant = radius * radius - across.length_squared();
    (along > 0.0 && discriminant > 0.0).then(|| along - discriminant.sqrt())
}

/// Distance to the floor y = 0 from a point above it.
fn floor_distance(half_side: f32, origin: Vec3, direction: Vec3) -> Option<f32> {
    if direction.y >= 0.0 {
        return None;
    }
    let distance = -origin.y / direction.y;
    let at = origin + direction * distance;
    (at.x.abs() <= half_side && at.z.abs() <= half_side).then_some(distance)
}

/// Turns a world-space vector of a sphere that has rolled by `turns` about −z into object space.
fn rotate_about_z(v: Vec3, turns: f32) -> Vec3 {
    let (sin, cos) = sin_cos_turns(turns - turns.floor());
    Vec3::new(cos * v.x - sin * v.y, sin * v.x + cos * v.y, v.z)
}
