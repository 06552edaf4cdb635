//! What the bounds of stochastic rasterization save: how many of the samples that are tested against a moving triangle it
//! is seen by, and the time of a frame, beside a moving bounding box around each triangle, all of whose samples are
//! tested.
//!
//! `script/bench sample_tests [MESH…]` takes models that `render` can read, or makes three: a ball of few triangles, one
//! of many, and needles. Each crosses the view at four speeds, in 640×480 pixels with 32 samples. Columns:
//! - `box`: hits per test where all samples of the pixels in the rectangle that a triangle sweeps over are tested;
//! - `tiles`: where those of a tile are that lie in the interval of the planes and the edges;
//! - `slices`: where of these only those in the pixels are that the triangle sweeps over within their slice of time, as in
//!   the pipeline's loop, but for its culling by depth, which leaves out more;
//! - `frame s`: seconds of the pipeline's frame, with its shading and with culling; `brute s`: of making the samples and
//!   testing those in the boxes, without shading; medians of three in turns after one that is not counted.
//!
//! The bounds are found to miss no hit, too.
#![expect(clippy::print_stdout, reason = "a benchmark prints")]

use glam::{Vec2, Vec3};
use rayon::prelude::*;
use shutterlab::pipelines::frame::Frame;
use shutterlab::pipelines::stochastic_rasterization::bounds::{Interval, swept};
use shutterlab::pipelines::stochastic_rasterization::motion::{
    MovingTriangle, Path as Motion, Views,
};
use shutterlab::pipelines::stochastic_rasterization::reference::each_tile;
use shutterlab::pipelines::stochastic_rasterization::{TILE, slices};
use shutterlab::pipelines::{DeviceChoice, OpenDevice};
use shutterlab::raster::shapes::shapes;
use shutterlab::sampling::random::{StreamKey, unit};
use shutterlab::sampling::sampler::first_blocks;
use shutterlab::scene::world::World;
use shutterlab_stimuli::assets::{Asset, Kind};
use shutterlab_stimuli::scene::{
    Environment, Illumination, Light, Motion as Moving, Object, Shape,
};
use shutterlab_stimuli::stimulus::{Method, Sampler, Trajectory};
use shutterlab_stimuli::{Grid, Selection, Stimulus};
use std::f32::consts::TAU;
use std::fmt::Write;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::time::Instant;

type Failure = Box<dyn std::error::Error + Send + Sync>;

const SIZE: [u32; 2] = [640, 480];
const SAMPLES: u32 = 32;
const SPEEDS_PX: [u32; 4] = [10, 30, 90, 270];
const FRAME: u32 = 60;
const COUNTED_RUNS: usize = 3;

fn main() -> Result<(), Failure> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("target/bench/sample_tests");
    std::fs::create_dir_all(&folder)?;
    // cargo says --bench.
    let mut models: Vec<PathBuf> =
        std::env::args().skip(1).filter(|a| !a.starts_with("--")).map(Into::into).collect();
    if models.is_empty() {
        for (name, text) in [("ball", ball(16)), ("fine-ball", ball(72)), ("needles", needles())] {
            models.push(folder.join(format!("{name}.obj")));
            std::fs::write(models.last().expect("pushed"), text)?;
        }
    }
    println!(
        "model        triangles    px     box   tiles  slices   frame s   brute s   brute/frame"
    );
    for model in &models {
        let asset = Asset::open(model, Kind::Model)?;
        asset.keep(&folder)?;
        for speed in SPEEDS_PX {
            let stimulus = crossing(model, &asset.sha256, speed)?;
            row(&stimulus, model, speed, &folder)?;
        }
    }
    Ok(())
}

/// A row of the table.
fn row(stimulus: &Stimulus, model: &Path, speed: u32, folder: &Path) -> Result<(), Failure> {
    let view = stimulus.views(FRAME).remove(0);
    let world = World::load(stimulus, folder)?;
    let frame = Frame::new(stimulus, &world, &view, FRAME);
    let shape = shapes(&world, &frame.objects).remove(0);
    let motion = Motion::new(&frame, &view, &frame.objects[0], &shape);
    // What goes straight has one segment, a whole shutter interval.
    assert_eq!(motion.segments(), 1);
    let triangles: Vec<Seen> = shape
        .triangles
        .iter()
        .map(|&vertices| {
            let triangle = motion.triangle(0, vertices);
            let views = Views::new(triangle, &frame.params.camera);
            let pixels = pixels(&views, Interval::ALL, SIZE.map(|side| 0..side));
            Seen { triangle, views, pixels }
        })
        .collect();

    let samples = samples(&frame);
    let [boxes, tiles, in_slices, hits] = triangles
        .par_iter()
        .map(|triangle| triangle.tests(&samples))
        .reduce(|| [0; 4], |a, b| std::array::from_fn(|k| a[k] + b[k]));
    let seen_in_boxes: u64 = brute_force(&triangles, &samples).iter().map(|&(hits, _)| hits).sum();
    assert_eq!(hits, seen_in_boxes, "a hit was missed");
    let [boxes, tiles, in_slices] =
        [boxes, tiles, in_slices].map(|tests| hits as f64 / tests as f64);

    let mut pipeline = OpenDevice::open(DeviceChoice::Cpu)?.pipeline(stimulus.method, folder);
    let mut films = || pipeline.films(stimulus, &view, FRAME, &[SAMPLES]).map(|_| ());
    films()?;
    let (mut by_bounds, mut by_force) = (vec![], vec![]);
    for _ in 0..COUNTED_RUNS {
        let started = Instant::now();
        films()?;
        by_bounds.push(started.elapsed().as_secs_f64());
        let started = Instant::now();
        brute_force(&triangles, &self::samples(&frame));
        by_force.push(started.elapsed().as_secs_f64());
    }
    let [by_bounds, by_force] = [by_bounds, by_force].map(median);
    let name = model.file_stem().unwrap_or_default().to_string_lossy();
    println!(
        "{name:12} {:9} {speed:5} {boxes:7.3} {tiles:7.3} {in_slices:7.3} {by_bounds:9.3} {by_force:9.3} {:13.1}",
        triangles.len(),
        by_force / by_bounds
    );
    Ok(())
}

/// A triangle, its views and the pixels that it sweeps over.
struct Seen {
    triangle: MovingTriangle,
    views: Views,
    pixels: [Range<u32>; 2],
}

impl Seen {
    /// Samples tested by box, by tile and interval, and by slice too, and how many of them are hits.
    fn tests(&self, samples: &[Sample]) -> [u64; 4] {
        let [columns, rows] = SIZE.map(|side| side.div_ceil(TILE));
        let area = self.pixels.iter().map(|range| range.len() as u64).product::<u64>();
        let (mut tiles, mut in_slices, mut hits) = (0, 0, 0);
        each_tile(&self.views, columns, &(0..rows), |tile, interval| {
            let [left, top] = [tile % columns * TILE, tile / columns * TILE];
            let within = [left..(left + TILE).min(SIZE[0]), top..(top + TILE).min(SIZE[1])];
            let count = slices(SAMPLES);
            let swept: Vec<[Range<u32>; 2]> = (0..count)
                .map(|slice| {
                    let [from, to] = [slice, slice + 1].map(|end| end as f32 / count as f32);
                    pixels(&self.views, interval.and(Interval { from, to }), within.clone())
                })
                .collect();
            for y in within[1].clone() {
                for x in within[0].clone() {
                    for sample in of_pixel(samples, x, y) {
                        if !(interval.from..=interval.to).contains(&sample.time) {
                            continue;
                        }
                        tiles += 1;
                        let slice = ((sample.time * count as f32) as u32).min(count - 1);
                        let [columns, rows] = &swept[slice as usize];
                        if columns.contains(&x) && rows.contains(&y) {
                            in_slices += 1;
                            let hit = self.triangle.hit(sample.point, sample.time);
                            hits += u64::from(hit.is_some());
                        }
                    }
                }
            }
        });
        [area * u64::from(SAMPLES), tiles, in_slices, hits]
    }
}

/// The pixels of some columns and rows that a triangle sweeps over between two times.
fn pixels(views: &Views, between: Interval, [columns, rows]: [Range<u32>; 2]) -> [Range<u32>; 2] {
    let Some(swept) = swept(views, between) else { return [columns, rows] };
    let range = |min: f32, max: f32, all: Range<u32>| {
        let at = |place: f32| place.clamp(all.start as f32, all.end as f32) as u32;
        at(min.floor())..at(max.floor() + 1.0)
    };
    [range(swept.min.x, swept.max.x, columns), range(swept.min.y, swept.max.y, rows)]
}

#[derive(Clone, Copy)]
struct Sample {
    point: Vec2,
    time: f32,
}

/// The samples of all pixels, those that the pipeline draws.
fn samples(frame: &Frame) -> Vec<Sample> {
    let params = &frame.params;
    let sample = |k: u32| {
        let (pixel, number) = (k / SAMPLES, k % SAMPLES);
        let key = StreamKey(params.key);
        let [start, _] = first_blocks(params.sampler(), key, params.strata, pixel, number);
        let [x, y, instant, _] = start.map(unit);
        let corner = Vec2::new((pixel % SIZE[0]) as f32, (pixel / SIZE[0]) as f32);
        let time = params.shutter().instant(instant) + 0.5;
        Sample { point: corner + Vec2::new(x, y), time }
    };
    (0..SIZE[0] * SIZE[1] * SAMPLES).into_par_iter().map(sample).collect()
}

fn of_pixel(samples: &[Sample], x: u32, y: u32) -> &[Sample] {
    &samples[((y * SIZE[0] + x) * SAMPLES) as usize..][..SAMPLES as usize]
}

/// Tests all samples in the box of each triangle; of each row of the image how many were hits, and the depths seen.
fn brute_force(triangles: &[Seen], samples: &[Sample]) -> Vec<(u64, Vec<f32>)> {
    let row = |y: u32| {
        let mut hits = 0;
        let mut depths = vec![f32::INFINITY; (SIZE[0] * SAMPLES) as usize];
        for Seen { triangle, pixels: [columns, rows], .. } in triangles {
            if !rows.contains(&y) {
                continue;
            }
            for x in columns.clone() {
                let depths = &mut depths[(x * SAMPLES) as usize..][..SAMPLES as usize];
                for (sample, depth) in of_pixel(samples, x, y).iter().zip(depths) {
                    if let Some(hit) = triangle.hit(sample.point, sample.time) {
                        hits += 1;
                        *depth = depth.min(hit);
                    }
                }
            }
        }
        (hits, depths)
    };
    (0..SIZE[1]).into_par_iter().map(row).collect()
}

fn median(mut seconds: Vec<f64>) -> f64 {
    seconds.sort_by(f64::total_cmp);
    seconds[seconds.len() / 2]
}

/// A model that crosses a black view at `speed` pixels per shutter, as high as half the image.
fn crossing(model: &Path, sha256: &str, speed: u32) -> Result<Stimulus, Failure> {
    let mut grid = Grid::load("rolling-sphere-mono")?;
    [grid.image.width_px, grid.image.height_px] = SIZE;
    let selection = Selection::parse(&["material=flat,speed=S2,shutter=T5,samples=A1"], &grid)?;
    let mut stimulus = grid.stimuli(&selection)?.remove(0);
    (stimulus.method, stimulus.sampler) = (Method::StochasticRasterization, Sampler::Sobol);
    (stimulus.samples, stimulus.trajectory) = (SAMPLES, Trajectory::Once);
    let scene = &mut stimulus.scene;
    scene.illumination = Illumination::Local;
    scene.environment = Environment::Uniform([0.0; 3]);
    let (direction, irradiance) = ([0.3, -0.5, -1.0], [2.0; 3]);
    scene.lights = vec![Light::Directional { direction, irradiance }];
    (scene.camera.position_m, scene.camera.look_at_m) = ([0.0, 0.0, 3.0], [0.0; 3]);
    let radius = 0.25 * f64::from(SIZE[1]) / scene.camera.pixels_per_metre(SIZE[0]);
    let metres = f64::from(speed) / scene.camera.pixels_per_metre(SIZE[0]);
    let motion = Moving {
        speed_m_per_s: Some(metres * grid.image.fps),
        translation: Some([1.0, 0.0, 0.0]),
        rotation: None,
        deformation: None,
    };
    let file = model.file_name().ok_or("a model is a file")?.to_string_lossy().into();
    scene.objects = vec![Object {
        name: "model".into(),
        shape: Shape::Mesh { file, sha256: sha256.into(), radius_m: Some(radius) },
        position_m: [0.0; 3],
        orientation: None,
        material: None,
        motion: Some(motion),
    }];
    Ok(stimulus)
}

/// A ball of so many rows of triangles, as OBJ.
fn ball(rows: usize) -> String {
    let columns = 2 * rows;
    let mut text = String::new();
    for j in 0..=rows {
        for i in 0..=columns {
            let (sine, cosine) = (0.5 * TAU * j as f32 / rows as f32).sin_cos();
            let (east, north) = (TAU * i as f32 / columns as f32).sin_cos();
            vertex(&mut text, Vec3::new(sine * east, cosine, sine * north));
        }
    }
    for j in 0..rows {
        for i in 0..columns {
            let at = 1 + i + j * (columns + 1);
            let (next, below) = (at + 1, at + columns + 1);
            for [a, b, c] in [[at, below, next], [next, below, below + 1]] {
                face(&mut text, [a, b, c]);
            }
        }
    }
    text
}

/// Triangles much longer than wide, through a ball in all directions, as OBJ.
fn needles() -> String {
    let key = StreamKey::new(1, "needles", 0, 0, 0);
    let mut text = String::new();
    for k in 0..4000 {
        let [a, b, c, d] = key.words(k, 0, 0).map(unit);
        let on_sphere = |u: f32, v: f32| {
            let z = 1.0 - 2.0 * u;
            let (sine, cosine) = (TAU * v).sin_cos();
            (1.0 - z * z).sqrt() * Vec3::new(cosine, sine, 0.0) + z * Vec3::Z
        };
        let [from, along] = [on_sphere(a, b), on_sphere(c, d)];
        let side = along.any_orthonormal_vector();
        for point in [from, from + 0.3 * along, from + 0.01 * side] {
            vertex(&mut text, point);
        }
        face(&mut text, [1, 2, 3].map(|corner| 3 * k as usize + corner));
    }
    text
}

fn vertex(text: &mut String, Vec3 { x, y, z }: Vec3) {
    writeln!(text, "v {x} {y} {z}").expect("a string takes all");
}

fn face(text: &mut String, [a, b, c]: [usize; 3]) {
    writeln!(text, "f {a} {b} {c}").expect("a string takes all");
}
