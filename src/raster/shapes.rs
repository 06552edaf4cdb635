//! The objects of a world as triangles, and where these are in the image at an instant.
//!
//! A sphere is drawn as an icosahedron that was divided into 20,480 triangles, whose corners lie on it: its outline
//! is nowhere more than 4·10⁻⁴ of the radius inside the true one. What is seen there is found on the true sphere.

use crate::mesh::Mesh;
use crate::scene::object::{Object, Pose};
use crate::scene::screen_motion::to_image;
use crate::scene::world::World;
use glam::{Affine3A, BVec3, DAffine3, DMat3, Vec3};
use shutterlab_stimuli::stimulus::View;
use std::borrow::Cow;
use std::collections::BTreeMap;

/// How often each triangle of the icosahedron becomes four.
const SUBDIVISIONS: u32 = 5;

/// The triangles of each object of `world`, in its own space.
pub fn shapes<'a>(world: &'a World, objects: &[Object]) -> Vec<Cow<'a, Mesh>> {
    let [spheres, planes, _] = world.counts;
    let unit_sphere = if spheres > 0 { icosphere() } else { Mesh::default() };
    let scaled = |mesh: &Mesh, size: f32| {
        let positions = mesh.positions.iter().map(|&p| p * size).collect();
        Mesh { positions, ..mesh.clone() }
    };
    let plane = Mesh {
        positions: [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
            .map(|(x, z)| Vec3::new(x, 0.0, z))
            .into(),
        triangles: vec![[0, 2, 1], [0, 3, 2]],
        ..Mesh::default()
    };
    let shape = |(k, object): (usize, &Object)| match k {
        k if k < spheres => Cow::Owned(scaled(&unit_sphere, object.size)),
        k if k < spheres + planes => Cow::Owned(scaled(&plane, object.size)),
        k => Cow::Borrowed(&world.meshes[k - spheres - planes].mesh),
    };
    objects.iter().enumerate().map(shape).collect()
}

/// The corners of the box around `shape` in both of its poses.
pub fn corners(shape: &Mesh) -> [Vec3; 8] {
    let both = shape.positions.iter().chain(shape.end_positions.iter().flatten());
    let [min, max] =
        both.fold([Vec3::INFINITY, Vec3::NEG_INFINITY], |[min, max], &p| [min.min(p), max.max(p)]);
    std::array::from_fn(|k| Vec3::select(BVec3::new(k & 1 > 0, k & 2 > 0, k & 4 > 0), max, min))
}

/// A sphere of radius 1.
fn icosphere() -> Mesh {
    let golden = 0.5 * (1.0 + 5.0f32.sqrt());
    let mut positions: Vec<Vec3> = vec![];
    for (one, other) in [(1.0, golden), (1.0, -golden), (-1.0, golden), (-1.0, -golden)] {
        let corner = Vec3::new(0.0, one, other).normalize();
        positions.extend([
            corner,
            Vec3::new(corner.z, 0.0, corner.y),
            Vec3::new(corner.y, corner.z, 0.0),
        ]);
    }
    // Three corners are a face where all are as near to one another as corners get.
    let edge = 2.0 / (1.0 + golden * golden).sqrt() + 1e-3;
    let is_edge = |a: usize, b: usize| positions[a].distance(positions[b]) < edge;
    let mut triangles: Vec<[u32; 3]> = vec![];
    for a in 0..12 {
        for b in a + 1..12 {
            for c in b + 1..12 {
                if is_edge(a, b) && is_edge(b, c) && is_edge(c, a) {
                    let [u, v, w] = [a, b, c].map(|corner| positions[corner]);
                    let is_outward = (v - u).cross(w - u).dot(u) > 0.0;
                    let face = [a as u32, b as u32, c as u32];
                    triangles.push(if is_outward { face } else { [face[0], face[2], face[1]] });
                }
            }
        }
    }
    for _ in 0..SUBDIVISIONS {
        let mut middles: BTreeMap<[u32; 2], u32> = BTreeMap::new();
        let mut divided = vec![];
        for [a, b, c] in triangles {
            let [ab, bc, ca] = [[a, b], [b, c], [c, a]].map(|[from, to]| {
                *middles.entry([from.min(to), from.max(to)]).or_insert_with(|| {
                    let middle = positions[from as usize] + positions[to as usize];
                    positions.push(middle.normalize());
                    positions.len() as u32 - 1
                })
            });
            divided.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
        }
        triangles = divided;
    }
    Mesh { positions, triangles, ..Mesh::default() }
}

/// Takes points of the own space of `object`, where it is in `pose`, to (x·z, y·z, z) in an image `width_px` wide, when
/// the part `shutter` ∈ [−½, ½] of the shutter interval, counted from its middle, has passed: as
/// [`to_image`] does points of the world.
pub fn object_to_image(
    view: &View,
    width_px: u32,
    object: &Object,
    pose: &Pose,
    shutter: f32,
) -> Affine3A {
    let axes = [Vec3::X, Vec3::Y, Vec3::Z].map(|v| object.to_world(pose, v).as_dvec3());
    let to_world = DAffine3::from_mat3_translation(
        DMat3::from_cols(axes[0], axes[1], axes[2]),
        pose.centre.as_dvec3(),
    );
    (to_image(view, width_px, f64::from(shutter)) * to_world).as_affine3a()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f32::consts::PI;

    /// Closed, of as many triangles as told, and nearly as large as the sphere.
    #[test]
    fn the_icosphere_is_a_sphere() {
        let sphere = icosphere();
        assert_eq!((sphere.triangles.len(), sphere.positions.len()), (20_480, 10_242));
        let volume: f32 = sphere
            .triangles
            .iter()
            .map(|&triangle| {
                let [a, b, c] = sphere.corners(triangle, 0.0);
                let middle = (a + b + c) / 3.0;
                assert!(middle.length() > 1.0 - 4e-4, "{middle}");
                a.dot(b.cross(c)) / 6.0
            })
            .sum();
        assert!((volume / (4.0 / 3.0 * PI) - 1.0).abs() < 1e-3, "{volume}");
    }
}
