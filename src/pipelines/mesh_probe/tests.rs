//! The twins of the search agree, and the one in WGSL has no gaps either.

use super::*;
use crate::sampling::random::{StreamKey, unit};
use std::f32::consts::TAU;

/// A bumpy torus, closed, that turns and moves ahead if it `moves`.
fn torus(around: u32, across: u32, moves: bool) -> Mesh {
    let point = |column: u32, row: u32, turn: f32| {
        let (s, c) = (TAU * column as f32 / around as f32 + turn).sin_cos();
        let (sine, cosine) = (TAU * row as f32 / across as f32).sin_cos();
        let radius = 0.35 + 0.05 * (TAU * ((column * 5 % around) as f32 / around as f32)).sin();
        let ring = 1.0 + radius * cosine;
        Vec3::new(ring * c + turn, radius * sine, ring * s)
    };
    let places = || (0..around).flat_map(|column| (0..across).map(move |row| (column, row)));
    let place = |column: u32, row: u32| (column % around) * across + row % across;
    let triangles = places().flat_map(|(column, row)| {
        let [a, b] = [place(column, row), place(column + 1, row)];
        let [c, d] = [place(column, row + 1), place(column + 1, row + 1)];
        [[a, b, c], [c, b, d]]
    });
    Mesh {
        positions: places().map(|(column, row)| point(column, row, 0.0)).collect(),
        end_positions: moves
            .then(|| places().map(|(column, row)| point(column, row, 0.3)).collect()),
        triangles: triangles.collect(),
        ..Mesh::default()
    }
}

/// Towards corners, points of edges and points of triangles; every third ray along an axis.
fn rays(mesh: &Mesh, count: u32) -> Vec<Ray> {
    let key = StreamKey::new(1, "probe", 0, 0, 0);
    let ray = |at: u32| {
        let [pick, u, v, time] = key.words(at, 0, 0).map(unit);
        let [x, y, z, kind] = key.words(at, 1, 0).map(unit);
        let triangle = mesh.triangles[(pick * mesh.triangles.len() as f32) as usize];
        let [a, b, c] = mesh.corners(triangle, time);
        let target = match (kind * 4.0) as u32 {
            0 => a,
            1 => a.lerp(b, u),
            _ => a.lerp(b, u).lerp(c, v),
        };
        let origin = 3.0 * (2.0 * Vec3::new(x, y, z) - 1.0);
        let axis = [Vec3::X, Vec3::NEG_Y, Vec3::Z][at as usize / 3 % 3];
        let (origin, direction) = match at % 3 {
            0 => (target - 2.0 * axis, axis),
            _ => (origin, target - origin),
        };
        let end = [f32::INFINITY, 1.5 * v][at as usize % 2];
        Ray { origin, direction, time, between: [0.1 * u, end] }
    };
    (0..count).map(ray).collect()
}

/// No adapter: nothing to test, unless `SHUTTERLAB_REQUIRE_GPU` says that there must be one.
fn gpu() -> Option<Gpu> {
    match Gpu::open() {
        Ok(gpu) => Some(gpu),
        Err(error) => {
            assert!(std::env::var_os("SHUTTERLAB_REQUIRE_GPU").is_none(), "{error}");
            None
        }
    }
}

/// All but one ray in a thousand find something at the same distance or nothing: those apart pass within
/// rounding of an outline, or of where their distances end. Of the hits, one in a thousand may tell another
/// triangle around the same edge or corner.
#[test]
fn the_twins_find_the_same() {
    let Some(gpu) = gpu() else { return };
    for moves in [false, true] {
        let mesh = torus(90, 40, moves);
        let bvh = Bvh::new(&mesh);
        let rays = rays(&mesh, 30_000);
        let probe = MeshProbe::new(&gpu, &mesh, &bvh, &rays).unwrap();
        let (nearest, any) = (probe.nearest(&gpu).unwrap(), probe.any(&gpu).unwrap());
        let (mut apart, mut others, mut hits) = (0, 0, 0);
        for ((ray, found), is_any) in rays.iter().zip(nearest).zip(any) {
            apart += u32::from(is_any != bvh.any(ray));
            match (bvh.nearest(ray), found) {
                (None, None) => {}
                (Some(cpu), Some(gpu)) if (cpu.distance - gpu.distance).abs() <= 1e-5 => {
                    hits += 1;
                    others += u32::from(cpu.triangle != gpu.triangle);
                    let [u, v, w] = gpu.barycentrics;
                    let [a, b, c] = mesh.corners(mesh.triangles[gpu.triangle as usize], ray.time);
                    let along = ray.origin + gpu.distance * ray.direction;
                    assert!((u * a + v * b + w * c).abs_diff_eq(along, 1e-4), "{gpu:?} {ray:?}");
                }
                _ => apart += 1,
            }
        }
        assert!(hits > 20_000 && apart <= 30 && others <= hits / 1000, "{apart} {others} {hits}");
    }
}

/// From inside a closed mesh, every ray meets it, also along edges and through corners.
#[test]
fn no_ray_slips_through_a_closed_mesh() {
    let Some(gpu) = gpu() else { return };
    for moves in [false, true] {
        let mesh = torus(90, 40, moves);
        let outwards = |ray: Ray| {
            // The centre of the tube is inside at all times.
            let around = TAU * ray.between[0] * 10.0;
            let start = Vec3::new(around.cos(), 0.0, around.sin());
            let inside = if moves { start + ray.time * 0.3 * Vec3::X } else { start };
            let direction = ray.origin + ray.direction - inside;
            Ray { origin: inside, direction, between: [0.0, f32::INFINITY], ..ray }
        };
        let rays: Vec<Ray> = rays(&mesh, 30_000).into_iter().map(outwards).collect();
        let probe = MeshProbe::new(&gpu, &mesh, &Bvh::new(&mesh), &rays).unwrap();
        for (ray, hit) in rays.iter().zip(probe.nearest(&gpu).unwrap()) {
            assert!(hit.is_some(), "{ray:?}");
        }
        assert!(probe.any(&gpu).unwrap().into_iter().all(|any| any));
    }
}
