//! Meshes for tests, and what is counted on them.

use crate::mesh::Mesh;
use glam::{Vec2, Vec3};
use std::collections::HashMap;

/// A grid of `n`×`n` squares over the unit square, each two triangles, with heights.
pub fn grid(n: usize, height: impl Fn(f32, f32) -> f32) -> Mesh {
    let at = |i: usize| i as f32 / n as f32;
    let mut mesh = Mesh::default();
    for (x, y) in (0..=n).flat_map(|y| (0..=n).map(move |x| (x, y))) {
        mesh.positions.push(Vec3::new(at(x), at(y), height(at(x), at(y))));
    }
    let vertex = |x: usize, y: usize| (y * (n + 1) + x) as u32;
    for (x, y) in (0..n).flat_map(|y| (0..n).map(move |x| (x, y))) {
        let [a, b] = [vertex(x, y), vertex(x + 1, y)];
        let [c, d] = [vertex(x + 1, y + 1), vertex(x, y + 1)];
        mesh.triangles.extend(if (x + y) % 2 == 0 {
            [[a, b, c], [a, c, d]]
        } else {
            [[a, b, d], [b, c, d]]
        });
    }
    mesh
}

/// A torus of `n`×`n` squares, each two triangles, with bumps.
pub fn torus(n: usize, bumps: f32) -> Mesh {
    let mut mesh = Mesh::default();
    for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
        let [u, v] = [i, j].map(|k| k as f32 / n as f32 * std::f32::consts::TAU);
        let tube = 0.4 + bumps * (7.0 * u).sin() * (5.0 * v).cos();
        let ring = 1.0 + tube * v.cos();
        mesh.positions.push(Vec3::new(ring * u.cos(), ring * u.sin(), tube * v.sin()));
        let vertex = |i: usize, j: usize| ((i % n) * n + j % n) as u32;
        let [a, b] = [vertex(i, j), vertex(i + 1, j)];
        let [c, d] = [vertex(i + 1, j + 1), vertex(i, j + 1)];
        mesh.triangles.extend([[a, b, c], [a, c, d]]);
    }
    mesh
}

/// An octahedron divided `times` times, on the unit sphere.
pub fn sphere(times: usize) -> Mesh {
    let mut mesh = octahedron();
    for _ in 0..times {
        let mut halves: HashMap<[u32; 2], u32> = HashMap::new();
        for [a, b, c] in std::mem::take(&mut mesh.triangles) {
            let [d, e, f] = [[a, b], [b, c], [c, a]].map(|mut edge| {
                edge.sort_unstable();
                *halves.entry(edge).or_insert_with(|| {
                    let [p, q] = edge.map(|vertex| mesh.positions[vertex as usize]);
                    mesh.positions.push((p + q).normalize());
                    mesh.positions.len() as u32 - 1
                })
            });
            mesh.triangles.extend([[a, d, f], [d, b, e], [f, e, c], [d, e, f]]);
        }
    }
    mesh
}

/// Eight faces about six vertices.
pub fn octahedron() -> Mesh {
    Mesh {
        positions: vec![Vec3::X, Vec3::Y, Vec3::Z, -Vec3::X, -Vec3::Y, -Vec3::Z],
        triangles: vec![
            [0, 1, 2],
            [1, 3, 2],
            [3, 4, 2],
            [4, 0, 2],
            [1, 0, 5],
            [3, 1, 5],
            [4, 3, 5],
            [0, 4, 5],
        ],
        ..Mesh::default()
    }
}

/// Texture coordinates that are the place from above; from `seam` to the right they are further right, and
/// what was there has its vertices twice.
pub fn with_texture(mut mesh: Mesh, seam: f32) -> Mesh {
    let texture: Vec<Vec2> = mesh.positions.iter().map(|p| Vec2::new(p.x, p.y)).collect();
    let mut right: HashMap<u32, u32> = HashMap::new();
    let (mut positions, mut all) = (mesh.positions.clone(), texture.clone());
    for triangle in &mut mesh.triangles {
        let middle = triangle.iter().map(|&v| mesh.positions[v as usize].x).sum::<f32>() / 3.0;
        if middle > seam {
            *triangle = triangle.map(|vertex| {
                *right.entry(vertex).or_insert_with(|| {
                    positions.push(mesh.positions[vertex as usize]);
                    all.push(texture[vertex as usize] + Vec2::X);
                    positions.len() as u32 - 1
                })
            });
        }
    }
    (mesh.positions, mesh.texture_coordinates) = (positions, Some(all));
    mesh
}

/// The edges of a mesh between places, each with how many triangles have it.
pub fn edges(mesh: &Mesh) -> HashMap<[[u32; 3]; 2], usize> {
    let mut edges = HashMap::new();
    for [a, b, c] in mesh.triangles.iter().map(|t| t.map(|v| bits(mesh, v))) {
        for mut edge in [[a, b], [b, c], [c, a]] {
            edge.sort_unstable();
            *edges.entry(edge).or_default() += 1;
        }
    }
    edges
}

fn bits(mesh: &Mesh, vertex: u32) -> [u32; 3] {
    mesh.positions[vertex as usize].to_array().map(|c| (c + 0.0).to_bits())
}

/// How many edges have so many triangles.
pub fn edges_of(mesh: &Mesh, triangles: impl Fn(usize) -> bool) -> usize {
    edges(mesh).values().filter(|&&count| triangles(count)).count()
}

/// Vertices, counted by place, minus edges plus faces.
pub fn euler(mesh: &Mesh) -> isize {
    let mut places: Vec<_> = mesh.triangles.as_flattened().iter().map(|&v| bits(mesh, v)).collect();
    places.sort_unstable();
    places.dedup();
    places.len() as isize - edges(mesh).len() as isize + mesh.triangles.len() as isize
}
