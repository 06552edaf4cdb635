//! The CPU twin: scalar, one path after the other, rows in parallel. It is the specification that
//! `trace.wgsl` is held to, and the fallback where there is no GPU.

use super::MAX_HITS;
use crate::film::Film;
use crate::pipelines::frame::{Frame, tent};
use crate::sampling::random::{StreamKey, unit};
use crate::sampling::sampler;
use crate::scene::environment::{Environment, luminance};
use crate::scene::world::{Instant, World};
use crate::shading::direct::from_lights;
use crate::shading::surface::Surface;
use glam::{Vec3, Vec4};
use rayon::prelude::*;
use shutterlab_stimuli::stimulus::View;

/// The films of the pipeline; the view is in the frame's camera.
pub fn films(
    frame: &Frame,
    world: &World,
    environment: &Environment,
    _: &View,
    samples: &[u32],
) -> Vec<Film> {
    trace(frame, world, environment, samples)
}

/// Draws the samples of every pixel from `frame.params.first_sample` on, and returns the film at each of
/// the numbers of `samples`, which ascend.
pub fn trace(
    frame: &Frame,
    world: &World,
    environment: &Environment,
    samples: &[u32],
) -> Vec<Film> {
    let (width, height) = (frame.params.width, frame.params.height);
    let mut sums = vec![Vec4::ZERO; (width * height) as usize];
    let mut drawn = 0;
    let mut film = |&count: &u32| {
        let (from, to) = (frame.params.first_sample + drawn, frame.params.first_sample + count);
        sums.par_chunks_mut(width as usize).enumerate().for_each(|(y, row)| {
            for (x, sum) in row.iter_mut().enumerate() {
                for sample in from..to {
                    let place = [x as u32, y as u32, sample];
                    let radiance = path_radiance(frame, world, environment, place);
                    *sum += radiance.extend(luminance(radiance).powi(2));
                }
            }
        });
        drawn = count;
        Film { width, height, samples: count, sums: sums.clone() }
    };
    samples.iter().map(&mut film).collect()
}

/// Radiance along the path of sample `sample` through pixel (x, y).
fn path_radiance(
    frame: &Frame,
    world: &World,
    environment: &Environment,
    [x, y, sample]: [u32; 3],
) -> Vec3 {
    let params = &frame.params;
    let pixel = y * params.width + x;
    let key = StreamKey(params.key);
    let [start, mut words] =
        sampler::first_blocks(params.sampler(), key, params.strata, pixel, sample);

    let [in_x, in_y, instant, _] = start.map(unit);
    let shutter = params.shutter().instant(instant);
    let instant = Instant { world, objects: &frame.objects, shutter };
    let lens = params.lens(pixel, sample);
    let (mut origin, mut direction) = params.ray([x, y], [in_x, in_y], shutter, lens);

    let mut radiance = Vec3::ZERO;
    let mut throughput = Vec3::ONE;
    // Density of the direction by the surface; the camera's own ray has none.
    let mut density = None;
    let mut met = instant.nearest(origin, direction, None);
    let tent = tent(start[3]);
    if params.is_local != 0 {
        return frame.local_radiance(&instant, environment, met, (origin, direction), tent);
    }
    for hit in 0..MAX_HITS {
        let Some(at) = met else { break };
        let surface = Surface::new(&instant, &frame.materials, &at, origin, direction);
        let Surface { normal, face_normal, albedo, from, .. } = surface;
        let (bsdf, to_viewer) = (&frame.bsdfs[at.object], -direction);
        origin = surface.point;

        let is_lit = |to_light: Vec3, distance: f32| {
            face_normal.dot(to_light) > 0.0 && !instant.any(origin, to_light, distance, from)
        };
        radiance += throughput * from_lights(&world.lights, bsdf, &surface, to_viewer, is_lit);
        let [a, b, c, d] = words;
        let light = environment.sample([a, b]);
        let (value, by_surface) = bsdf.evaluate(albedo, normal, to_viewer, light.direction);
        if value != Vec3::ZERO && is_lit(light.direction, f32::INFINITY) {
            radiance += throughput * light.radiance * value * (1.0 / (light.density + by_surface));
        }

        let Some(scattered) = bsdf.sample(albedo, normal, to_viewer, [c, d]) else {
            return radiance;
        };
        if face_normal.dot(scattered.direction) <= 0.0 {
            return radiance;
        }
        direction = scattered.direction;
        throughput *= scattered.weight;
        density = Some(scattered.density);
        met = instant.nearest(origin, direction, from);
        words = key.words(pixel, sample, 2 + hit);
    }
    if met.is_some() {
        return radiance;
    }
    match density {
        None => environment.evaluate(direction, tent).0,
        Some(density) => {
            let (light, light_density) = environment.evaluate(direction, [0.0; 2]);
            // A direction along the surface may meet black: nothing over nothing.
            radiance + throughput * light * (density / (density + light_density).max(1e-30))
        }
    }
}
