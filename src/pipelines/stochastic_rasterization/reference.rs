//! The CPU twin: tiles side by side, each with the triangles that can be seen in it.

use super::bounds::{Interval, Rectangle, by_edges, by_planes, swept};
use super::motion::{MovingTriangle, Path, Views};
use super::{TILE, slices};
use crate::film::Film;
use crate::mesh::Mesh;
use crate::pipelines::frame::{Frame, met_where, tent};
use crate::raster::shapes::shapes;
use crate::sampling::random::{StreamKey, unit};
use crate::sampling::sampler;
use crate::scene::camera::Camera;
use crate::scene::environment::{Environment, luminance};
use crate::scene::world::{Instant, World};
use glam::{Vec2, Vec3, Vec4};
use rayon::prelude::*;
use shutterlab_stimuli::stimulus::View;
use std::borrow::Cow;
use std::ops::Range;

/// Rows of tiles that are drawn together: a few, because a fast triangle has an entry in each of many tiles, and a million
/// of them in all tiles at once would not fit into memory.
const ROWS: u32 = 6;

/// The films of the pipeline.
pub fn films(
    frame: &Frame,
    world: &World,
    environment: &Environment,
    view: &View,
    samples: &[u32],
) -> Vec<Film> {
    let (width, height) = (frame.params.width, frame.params.height);
    let moving = Moving::new(frame, world, view);
    let mut sums = vec![Vec4::ZERO; (width * height) as usize];
    let mut drawn = 0;
    let mut film = |&count: &u32| {
        add(&mut sums, frame, world, environment, &moving, drawn..count);
        drawn = count;
        Film { width, height, samples: count, sums: sums.clone() }
    };
    samples.iter().map(&mut film).collect()
}

/// The objects of a frame as moving triangles.
#[derive(Debug)]
struct Moving<'a> {
    camera: Camera,
    shapes: Vec<Cow<'a, Mesh>>,
    paths: Vec<Path>,
}

/// A triangle in a tile.
#[derive(Clone, Copy, Debug)]
struct Entry {
    object: u32,
    segment: u32,
    triangle: u32,
    /// When it can be seen, in parts of its segment.
    interval: Interval,
    /// Not nearer than this.
    depth: f32,
}

/// The samples of a tile, sorted by slice of time, and within one by pixel.
struct Samples {
    /// Where each pixel of each slice begins.
    starts: Vec<u32>,
    /// The point in the image, the time, the point of the lens, and which sample of the pixel it is.
    samples: Vec<Sample>,
}

#[derive(Clone, Copy, Debug, Default)]
struct Sample {
    point: Vec2,
    time: f32,
    lens: Vec2,
    pixel: u32,
    number: u32,
}

/// What a sample sees.
#[derive(Clone, Copy, Debug)]
struct Seen {
    object: u32,
    triangle: u32,
    depth: f32,
}

impl<'a> Moving<'a> {
    /// The objects of `frame` as `view` sees them.
    fn new(frame: &Frame, world: &'a World, view: &View) -> Self {
        let shapes = shapes(world, &frame.objects);
        let paths = frame
            .objects
            .iter()
            .zip(&shapes)
            .map(|(object, shape)| Path::new(frame, view, object, shape));
        Self { camera: frame.params.camera, paths: paths.collect(), shapes }
    }

    /// The triangle of an entry.
    fn triangle(&self, entry: &Entry) -> MovingTriangle {
        let object = entry.object as usize;
        let vertices = self.shapes[object].triangles[entry.triangle as usize];
        self.paths[object].triangle(entry.segment as usize, vertices)
    }

    /// What can be seen in each tile of some rows, of so many columns.
    fn bin(&self, columns: u32, rows: &Range<u32>) -> Vec<Vec<Entry>> {
        let mut bins = vec![vec![]; columns as usize * rows.len()];
        for (object, (shape, path)) in self.shapes.iter().zip(&self.paths).enumerate() {
            for segment in 0..path.segments() {
                const CHUNK: usize = 4096;
                let found: Vec<Vec<(u32, Entry)>> = shape
                    .triangles
                    .par_chunks(CHUNK)
                    .enumerate()
                    .map(|(chunk, triangles)| {
                        let mut found = vec![];
                        for (index, &vertices) in (chunk * CHUNK..).zip(triangles) {
                            let triangle = path.triangle(segment, vertices);
                            let views = Views::new(triangle, &self.camera);
                            each_tile(&views, columns, rows, |tile, interval| {
                                let ends = triangle.start.iter().chain(&triangle.end);
                                let depth = ends.map(|q| q.z).fold(f32::INFINITY, f32::min);
                                found.push((
                                    tile,
                                    Entry {
                                        object: object as u32,
                                        segment: segment as u32,
                                        triangle: index as u32,
                                        interval,
                                        depth,
                                    },
                                ));
                            });
                        }
                        found
                    })
                    .collect();
                found
                    .into_iter()
                    .flatten()
                    .for_each(|(tile, entry)| bins[tile as usize].push(entry));
            }
        }
        bins
    }
}

/// Calls `with` with each tile of these rows and so many columns that a triangle can be seen in by its views, counted from
/// the first, and when.
pub fn each_tile(
    views: &Views,
    columns: u32,
    rows: &Range<u32>,
    mut with: impl FnMut(u32, Interval),
) {
    let side = TILE as f32;
    let range = |min: f32, max: f32, all: &Range<u32>| {
        let at = |tile: f32| tile.clamp(all.start as f32, all.end as f32) as u32;
        at((min / side).floor())..at((max / side).floor() + 1.0)
    };
    let all = 0..columns;
    let [xs, ys] = match swept(views, Interval::ALL) {
        Some(Rectangle { min, max }) => [range(min.x, max.x, &all), range(min.y, max.y, rows)],
        None => [all, rows.clone()],
    };
    for y in ys {
        for x in xs.clone() {
            let min = Vec2::new(x as f32, y as f32) * side;
            let tile = Rectangle { min, max: min + side };
            let mut interval = by_planes(views, &tile);
            if !interval.is_empty() {
                interval = interval.and(by_edges(views, &tile));
            }
            if !interval.is_empty() {
                with((y - rows.start) * columns + x, interval);
            }
        }
    }
}

/// Adds the samples of these numbers to the sums of all pixels.
fn add(
    sums: &mut [Vec4],
    frame: &Frame,
    world: &World,
    environment: &Environment,
    moving: &Moving<'_>,
    numbers: Range<u32>,
) {
    let (width, height) = (frame.params.width, frame.params.height);
    let [columns, all_rows] = [width, height].map(|side| side.div_ceil(TILE));
    for first in (0..all_rows).step_by(ROWS as usize) {
        let rows = first..all_rows.min(first + ROWS);
        let before: &[Vec4] = sums;
        let drawn: Vec<Vec<(u32, Vec4)>> = moving
            .bin(columns, &rows)
            .into_par_iter()
            .enumerate()
            .map(|(tile, mut entries)| {
                let tile = tile as u32;
                let corner = [tile % columns * TILE, (first + tile / columns) * TILE];
                entries.sort_by(|a, b| a.depth.total_cmp(&b.depth));
                let samples = Samples::new(frame, corner, numbers.clone());
                let seen = samples.see(moving, corner, &entries);
                let of_pixel = samples.shade(&seen, frame, world, environment, corner);
                let sum = |(pixel, radiances): (u32, Vec<Vec3>)| {
                    let with = |sum: Vec4, r: &Vec3| sum + r.extend(luminance(*r).powi(2));
                    (pixel, radiances.iter().fold(before[pixel as usize], with))
                };
                of_pixel.into_iter().map(sum).collect()
            })
            .collect();
        drawn.into_iter().flatten().for_each(|(pixel, sum)| sums[pixel as usize] = sum);
    }
}

impl Samples {
    /// The samples of the pixels of the tile at `corner`, those of distribution ray tracing.
    fn new(frame: &Frame, corner: [u32; 2], numbers: Range<u32>) -> Self {
        let params = &frame.params;
        let slices = slices(numbers.len() as u32);
        let mut all = vec![];
        for k in 0..TILE * TILE {
            let [x, y] = [corner[0] + k % TILE, corner[1] + k / TILE];
            if x >= params.width || y >= params.height {
                continue;
            }
            for number in numbers.clone() {
                let index = y * params.width + x;
                let words = sample_words(frame, index, number);
                let [in_x, in_y, instant, _] = words.map(unit);
                let lens = params.lens(index, number);
                let time = params.shutter().instant(instant) + 0.5;
                let slice = ((time * slices as f32) as u32).min(slices - 1);
                let point = Vec2::new(x as f32 + in_x, y as f32 + in_y);
                all.push((slice, Sample { point, time, lens, pixel: k, number }));
            }
        }
        all.sort_by_key(|&(slice, sample)| (slice, sample.pixel));
        let mut starts = vec![0; (slices * TILE * TILE) as usize + 1];
        for (slice, sample) in &all {
            starts[(slice * TILE * TILE + sample.pixel) as usize + 1] += 1;
        }
        for k in 1..starts.len() {
            starts[k] += starts[k - 1];
        }
        Self { starts, samples: all.into_iter().map(|(_, sample)| sample).collect() }
    }

    /// What each sample sees of the entries, which come from front to back.
    fn see(&self, moving: &Moving<'_>, corner: [u32; 2], entries: &[Entry]) -> Vec<Option<Seen>> {
        const PIXELS: usize = (TILE * TILE) as usize;
        let slices = self.starts.len() / PIXELS;
        let mut seen: Vec<Option<Seen>> = vec![None; self.samples.len()];
        // The farthest that is seen in each slice; known to be out of date where it may be nearer by now.
        let mut farthest = vec![(f32::INFINITY, false); slices];
        let has_lens = moving.camera.lens_radius > 0.0;
        for entry in entries {
            let triangle = moving.triangle(entry);
            let views = Views::new(triangle, &moving.camera);
            let segments = moving.paths[entry.object as usize].segments() as f32;
            let begin = entry.segment as f32;
            // In parts of the shutter interval.
            let from = (begin + entry.interval.from) / segments;
            let to = (begin + entry.interval.to) / segments;
            let first = ((from * slices as f32 - 1e-3).max(0.0) as usize).min(slices - 1);
            let last = ((to * slices as f32 + 1e-3) as usize).min(slices - 1);
            for (slice, (depth, is_old)) in
                farthest.iter_mut().enumerate().take(last + 1).skip(first)
            {
                let own = &self.starts[slice * PIXELS..=(slice + 1) * PIXELS];
                let all = own[0] as usize..own[PIXELS] as usize;
                if std::mem::take(is_old) {
                    let depths =
                        seen[all].iter().map(|seen| seen.map_or(f32::INFINITY, |seen| seen.depth));
                    *depth = depths.fold(0.0, f32::max);
                }
                if entry.depth > *depth {
                    continue;
                }
                let in_segment = |time: f32| (time * segments - begin).clamp(0.0, 1.0);
                let between = entry.interval.and(Interval {
                    from: in_segment(slice as f32 / slices as f32),
                    to: in_segment((slice + 1) as f32 / slices as f32),
                });
                let [columns, rows] = pixels(&views, between, corner);
                for y in rows {
                    let pixels =
                        (y * TILE + columns.start) as usize..(y * TILE + columns.end) as usize;
                    if pixels.is_empty() {
                        continue;
                    }
                    let range = own[pixels.start] as usize..own[pixels.end] as usize;
                    for (sample, seen) in self.samples[range.clone()].iter().zip(&mut seen[range]) {
                        let time = sample.time * segments - begin;
                        // The ends belong to both segments: a triangle that is seen twice is seen once.
                        if !(entry.interval.from..=entry.interval.to).contains(&time) {
                            continue;
                        }
                        let depth = if has_lens {
                            let parallax = moving.camera.parallax(sample.lens);
                            triangle.seen_from(parallax).hit(sample.point, time)
                        } else {
                            triangle.hit(sample.point, time)
                        };
                        let Some(depth) = depth else { continue };
                        if seen.is_none_or(|before| depth < before.depth) {
                            let Entry { object, triangle, .. } = *entry;
                            *seen = Some(Seen { object, triangle, depth });
                            *is_old = true;
                        }
                    }
                }
            }
        }
        seen
    }

    /// What each pixel of the image that the tile has sees, sample by sample in the order of their numbers, so that sums
    /// do not depend on how many were drawn together.
    fn shade(
        &self,
        seen: &[Option<Seen>],
        frame: &Frame,
        world: &World,
        environment: &Environment,
        corner: [u32; 2],
    ) -> Vec<(u32, Vec<Vec3>)> {
        let mut order: Vec<usize> = (0..self.samples.len()).collect();
        order.sort_unstable_by_key(|&k| (self.samples[k].pixel, self.samples[k].number));
        // Behind the objects, where nothing has to be looked up.
        let behind = environment.uniform();
        let radiance = |&k: &usize| match (&seen[k], behind) {
            (None, Some(radiance)) => radiance,
            (seen, _) => {
                radiance_of(&self.samples[k], seen.as_ref(), frame, world, environment, corner)
            }
        };
        let pixels = order.chunk_by(|&a, &b| self.samples[a].pixel == self.samples[b].pixel);
        let pixel = |own: &[usize]| {
            let k = self.samples[own[0]].pixel;
            let [x, y] = [corner[0] + k % TILE, corner[1] + k / TILE];
            (y * frame.params.width + x, own.iter().map(radiance).collect())
        };
        pixels.map(pixel).collect()
    }
}

/// Radiance of what a sample of the tile at `corner` sees.
fn radiance_of(
    sample: &Sample,
    seen: Option<&Seen>,
    frame: &Frame,
    world: &World,
    environment: &Environment,
    corner: [u32; 2],
) -> Vec3 {
    let Sample { point, time, lens, pixel, number } = *sample;
    let [x, y] = [corner[0] + pixel % TILE, corner[1] + pixel / TILE];
    let shutter = time - 0.5;
    let instant = Instant { world, objects: &frame.objects, shutter };
    let in_pixel = [point.x - x as f32, point.y - y as f32];
    let ray = frame.params.ray([x, y], in_pixel, shutter, lens);
    let met = seen.and_then(|seen| met_where(&instant, seen.object as usize, seen.triangle, ray));
    let words = sample_words(frame, y * frame.params.width + x, number);
    frame.local_radiance(&instant, environment, met, ray, tent(words[3]))
}

/// The pixels of the tile at `corner` that a triangle sweeps over between two times.
fn pixels(views: &Views, between: Interval, corner: [u32; 2]) -> [Range<u32>; 2] {
    let Some(swept) = swept(views, between) else { return [0..TILE, 0..TILE] };
    let range = |min: f32, max: f32, corner: u32| {
        let at = |place: f32| (place - corner as f32).clamp(0.0, TILE as f32);
        at(min.floor()) as u32..at(max.floor() + 1.0) as u32
    };
    [range(swept.min.x, swept.max.x, corner[0]), range(swept.min.y, swept.max.y, corner[1])]
}

/// The words of a sample, as distribution ray tracing has them.
fn sample_words(frame: &Frame, pixel: u32, number: u32) -> [u32; 4] {
    let params = &frame.params;
    sampler::first_blocks(params.sampler(), StreamKey(params.key), params.strata, pixel, number)[0]
}
