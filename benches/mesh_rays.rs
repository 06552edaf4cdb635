//! How many rays a core-second searches a mesh with, natively and in WGSL on the adapter at hand: the same
//! rays, the same hierarchy.
//!
//! `script/bench mesh_rays [MESH [REPEATS]]` takes a file that `render` can read, or makes a bumpy ball of
//! 70,000 triangles. Kinds of rays: `camera`, in the order of pixels; `bounce`, from what those hit by the cosine
//! law; `shadow`, from there to points of a large lamp. Once as the mesh is and once with moving vertices.
//! Both run in turns, the processor's on one thread, and the figure is that of the least time; a
//! core-second is a second of this process's processor time, so on a graphics card it says nothing.
#![expect(clippy::print_stdout, reason = "a benchmark prints")]

use cpu_time::ProcessTime;
use glam::{Mat3, Vec2, Vec3};
use shutterlab::gpu::device::Gpu;
use shutterlab::mesh::Mesh;
use shutterlab::mesh::bvh::Bvh;
use shutterlab::mesh::ray::Ray;
use shutterlab::pipelines::mesh_probe::MeshProbe;
use shutterlab::sampling::random::{StreamKey, unit};
use shutterlab::sampling::warp::cosine_hemisphere;
use shutterlab::scene::import;
use std::f32::consts::TAU;
use std::path::Path;

type Failure = Box<dyn std::error::Error>;

/// Pixels of a side of the picture.
const SIDE: u32 = 512;

fn main() -> Result<(), Failure> {
    // cargo says --bench.
    let mut arguments = std::env::args().skip(1).filter(|argument| !argument.starts_with("--"));
    let file = arguments.next();
    let repeats: u32 = arguments.next().map_or(Ok(7), |repeats| repeats.parse())?;
    let mut mesh = match &file {
        Some(file) => import::model(Path::new(file))?.mesh,
        None => ball(),
    };
    place(&mut mesh);
    let gpu = Gpu::open()?;
    println!("{} triangles; {}", mesh.triangles.len(), gpu.info.name);
    println!("mesh    rays            native      WGSL  million rays per core-second; native/WGSL");
    for moves in [false, true] {
        if moves {
            let travel = |p: &Vec3| Mat3::from_rotation_y(0.1) * *p + 0.1 * Vec3::X;
            mesh.end_positions = Some(mesh.positions.iter().map(travel).collect());
        }
        let bvh = Bvh::new(&mesh);
        let [camera, bounce, shadow] = rays(&mesh, &bvh);
        for (name, rays, is_any) in [
            ("camera, first", &camera, false),
            ("bounce, first", &bounce, false),
            ("shadow, any", &shadow, true),
        ] {
            // A mesh may be larger than the adapter binds.
            let probe = MeshProbe::new(&gpu, &mesh, &bvh, rays)
                .inspect_err(|error| println!("{error}"))
                .ok();
            let mut least = [f64::INFINITY; 2];
            let mut found = [0; 2];
            for _ in 0..repeats {
                let started = ProcessTime::now();
                found[0] = match is_any {
                    true => rays.iter().filter(|ray| bvh.any(ray)).count(),
                    false => rays.iter().filter(|ray| bvh.nearest(ray).is_some()).count(),
                };
                least[0] = least[0].min(started.elapsed().as_secs_f64());
                let Some(probe) = &probe else { continue };
                let started = ProcessTime::now();
                found[1] = match is_any {
                    true => probe.any(&gpu)?.iter().filter(|&&any| any).count(),
                    false => probe.nearest(&gpu)?.iter().flatten().count(),
                };
                least[1] = least[1].min(started.elapsed().as_secs_f64());
            }
            let [native, wgsl] = least.map(|seconds| rays.len() as f64 / 1e6 / seconds);
            let kind = if moves { "moving" } else { "resting" };
            let ratio = native / wgsl;
            println!("{kind:7} {name:14} {native:7.2} {wgsl:9.2} {ratio:8.2}   hits {found:?}");
        }
    }
    Ok(())
}

/// A ball of waves.
fn ball() -> Mesh {
    const ROWS: u32 = 132;
    const COLUMNS: u32 = 2 * ROWS;
    let point = |row: u32, column: u32| {
        let (sine, cosine) = (0.5 * TAU * row as f32 / ROWS as f32).sin_cos();
        let (east, north) = (TAU * column as f32 / COLUMNS as f32).sin_cos();
        let direction = Vec3::new(sine * east, cosine, sine * north);
        let waves = (9.0 * direction).to_array().map(f32::sin).iter().sum::<f32>();
        direction * (1.0 + 0.1 * waves)
    };
    let places = || (0..=ROWS).flat_map(|row| (0..COLUMNS).map(move |column| (row, column)));
    let place = |row: u32, column: u32| row * COLUMNS + column % COLUMNS;
    let triangles = places().filter(|&(row, _)| row < ROWS).flat_map(|(row, column)| {
        let [a, b] = [place(row, column), place(row, column + 1)];
        let [c, d] = [place(row + 1, column), place(row + 1, column + 1)];
        [[a, c, b], [b, c, d]]
    });
    Mesh {
        positions: places().map(|(row, column)| point(row, column)).collect(),
        triangles: triangles.collect(),
        ..Mesh::default()
    }
}

/// Into the cube from −1 to 1.
fn place(mesh: &mut Mesh) {
    let least = mesh.positions.iter().copied().fold(Vec3::INFINITY, Vec3::min);
    let most = mesh.positions.iter().copied().fold(Vec3::NEG_INFINITY, Vec3::max);
    let scale = 2.0 / (most - least).max_element();
    mesh.positions.iter_mut().for_each(|p| *p = scale * (*p - 0.5 * (least + most)));
}

/// Camera, bounce and shadow rays.
fn rays(mesh: &Mesh, bvh: &Bvh) -> [Vec<Ray>; 3] {
    let key = StreamKey::new(1, "mesh rays", 0, 0, 0);
    let mut rays = [vec![], vec![], vec![]];
    let eye = Vec3::new(0.8, 0.9, 4.0);
    for pixel in 0..SIDE * SIDE {
        let [x, y, time, _] = key.words(pixel, 0, 0).map(unit);
        let at = Vec2::new((pixel % SIDE) as f32 + x, (pixel / SIDE) as f32 + y) / SIDE as f32;
        let target = (1.8 * (at - 0.5)).extend(0.0);
        let direction = (target - eye).normalize();
        let camera = Ray { origin: eye, direction, time, between: [0.0, f32::INFINITY] };
        rays[0].push(camera);
        let Some(hit) = bvh.nearest(&camera) else { continue };
        let [a, b, c] = mesh.corners(mesh.triangles[hit.triangle as usize], time);
        let normal = (b - a).cross(c - a).normalize_or_zero();
        let normal = if normal.dot(direction) > 0.0 { -normal } else { normal };
        let origin = eye + hit.distance * direction;
        let [u, v, lamp_x, lamp_z] = key.words(pixel, 0, 1).map(unit);
        let bounce = cosine_hemisphere(normal, [u, v]);
        rays[1].push(Ray { origin, direction: bounce, time, between: [1e-4, f32::INFINITY] });
        let direction = Vec3::new(2.0 + 2.0 * lamp_x, 5.0, 1.0 + 2.0 * lamp_z) - origin;
        if direction.dot(normal) > 0.0 {
            rays[2].push(Ray { origin, direction, time, between: [1e-4, 1.0] });
        }
    }
    rays
}
