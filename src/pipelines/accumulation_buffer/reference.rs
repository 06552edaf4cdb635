//! The CPU twin: a few images at a time are rasterized side by side, then added up row by row.

use super::{Image, images};
use crate::film::Film;
use crate::mesh::Mesh;
use crate::pipelines::frame::{Frame, met_where, tent};
use crate::raster::Raster;
use crate::raster::shapes::{object_to_image, shapes};
use crate::scene::environment::{Environment, luminance};
use crate::scene::world::{Instant, Met, World};
use glam::{Vec3, Vec4};
use rayon::prelude::*;
use shutterlab_stimuli::stimulus::View;
use std::borrow::Cow;

/// Images that are rasterized side by side.
const BATCH: usize = 8;

/// The films of the pipeline. Each has instants of its own.
pub fn films(
    frame: &Frame,
    world: &World,
    environment: &Environment,
    view: &View,
    samples: &[u32],
) -> Vec<Film> {
    samples.iter().map(|&count| film(frame, world, environment, view, count)).collect()
}

/// The film of `count` images of `frame` as `view` sees it.
fn film(frame: &Frame, world: &World, environment: &Environment, view: &View, count: u32) -> Film {
    let params = &frame.params;
    let (width, height) = (params.width, params.height);
    let shapes = shapes(world, &frame.objects);
    // Where the triangles of each object end in the count of all.
    let mut ends = vec![];
    for shape in &shapes {
        ends.push(ends.last().unwrap_or(&0) + shape.triangles.len() as u32);
    }
    let mut rasters = vec![Raster::new(width, height); BATCH.min(count as usize)];
    let mut sums = vec![Vec4::ZERO; (width * height) as usize];
    // Behind the objects, where nothing has to be looked up.
    let behind = environment.uniform();
    for batch in images(params, count).chunks(BATCH) {
        let pairs = rasters.par_iter_mut().zip(batch);
        pairs.for_each(|(raster, image)| draw(raster, frame, &shapes, view, image));
        sums.par_chunks_mut(width as usize).enumerate().for_each(|(y, row)| {
            for (raster, image) in rasters.iter().zip(batch) {
                let instant = Instant { world, objects: &frame.objects, shutter: image.shutter };
                for (x, sum) in row.iter_mut().enumerate() {
                    let pixel = y * width as usize + x;
                    let radiance = match behind {
                        Some(radiance) if raster.depths[pixel].is_infinite() => radiance,
                        _ => {
                            let place = [x as u32, y as u32];
                            let ray = params.ray(place, image.in_pixel, image.shutter, image.lens);
                            let seen = met(&instant, raster, &ends, pixel, ray);
                            let tent = tent(image.word);
                            frame.local_radiance(&instant, environment, seen, ray, tent)
                        }
                    };
                    *sum += radiance.extend(luminance(radiance).powi(2));
                }
            }
        });
    }
    Film { width, height, samples: count, sums }
}

/// Draws what is seen in `image`.
fn draw(raster: &mut Raster, frame: &Frame, shapes: &[Cow<'_, Mesh>], view: &View, image: &Image) {
    raster.clear();
    let shift = image.shift(&frame.params);
    for (object, shape) in frame.objects.iter().zip(shapes) {
        let pose = object.at(image.shutter);
        let to_image = object_to_image(view, frame.params.width, object, &pose, image.shutter);
        raster.draw(shape.vertices_at(pose.time), &shape.triangles, &(shift * to_image));
    }
}

/// What is seen in a pixel by its ray.
fn met(
    instant: &Instant,
    raster: &Raster,
    ends: &[u32],
    pixel: usize,
    ray: (Vec3, Vec3),
) -> Option<Met> {
    if raster.depths[pixel].is_infinite() {
        return None;
    }
    let triangle = raster.fragments[pixel].triangle;
    let object = ends.partition_point(|&end| end <= triangle);
    let first = object.checked_sub(1).map_or(0, |before| ends[before]);
    met_where(instant, object, triangle - first, ray)
}
