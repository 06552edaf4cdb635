//! What a path finds where it meets something: the point to go on from, the normals there and the albedo.
//! All surfaces are seen from either side.

use super::material::{Material, Place};
use crate::scene::world::{Instant, Met, SceneMesh};
use glam::{Vec2, Vec3};

/// A surface where a ray meets it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Surface {
    /// The point, moved off a mesh towards the viewer by what rounding can move it.
    pub point: Vec3,
    /// Unit normal on the viewer's side, interpolated on a mesh with normals.
    pub normal: Vec3,
    /// Unit normal of the true surface, on the viewer's side.
    pub face_normal: Vec3,
    /// Its albedo.
    pub albedo: Vec3,
    /// The sphere or plane that the point is on.
    pub from: Option<usize>,
}

/// What rounding can move a point of a mesh, as part of its largest coordinate.
const SLACK: f32 = 4e-6;

impl Surface {
    /// The surface that a ray meets at `met`, with the patterns of all objects.
    pub fn new(
        instant: &Instant<'_>,
        materials: &[Material],
        met: &Met,
        origin: Vec3,
        direction: Vec3,
    ) -> Self {
        let Met { object, distance, .. } = *met;
        let (of, pose) = (&instant.objects[object], &instant.pose(object));
        let material = &materials[object];
        let pictures = &instant.world.pictures;
        let point = origin + direction * distance;
        if let Some(mesh) = instant.mesh(object) {
            return Self::on_mesh(instant, mesh, material, met, direction);
        }
        if object < instant.world.counts[0] {
            let outward = (point - pose.centre).normalize_or(Vec3::Y);
            let point = pose.centre + outward * of.size;
            let normal = facing(outward, direction);
            let place = Place { n: of.to_object(pose, outward), coordinates: None };
            let albedo = material.albedo(&place, pictures);
            return Self { point, normal, face_normal: normal, albedo, from: Some(object) };
        }
        let up = of.plane_normal(pose);
        let offset = point - pose.centre;
        let point = point - up * up.dot(offset);
        let n = of.to_object(pose, offset) / of.size;
        let place = Place { n, coordinates: Some([0.5 * n.x + 0.5, 0.5 * n.z + 0.5]) };
        let albedo = material.albedo(&place, pictures);
        let normal = facing(up, direction);
        Self { point, normal, face_normal: normal, albedo, from: Some(object) }
    }

    fn on_mesh(
        instant: &Instant<'_>,
        SceneMesh { mesh, face_materials, materials, .. }: &SceneMesh,
        material: &Material,
        met: &Met,
        direction: Vec3,
    ) -> Self {
        let (of, pose) = (&instant.objects[met.object], &instant.pose(met.object));
        let vertices = mesh.triangles[met.triangle as usize];
        let [a, b, c] = mesh.corners(vertices, pose.time);
        let weights = met.barycentrics;
        let local = a * weights[0] + b * weights[1] + c * weights[2];
        let face = of.to_world(pose, (b - a).cross(c - a).normalize_or(Vec3::Y));
        let face_normal = facing(face, direction);
        let normal = match &mesh.normals {
            Some(normals) => {
                let [a, b, c] = vertices.map(|vertex| normals[vertex as usize]);
                let sum = a * weights[0] + b * weights[1] + c * weights[2];
                let smooth = of.to_world(pose, sum.normalize_or_zero());
                let smooth = if smooth.dot(face_normal) < 0.0 { -smooth } else { smooth };
                // What turns away from the viewer would be black: there the face itself is seen.
                if smooth.dot(direction) < 0.0 { smooth } else { face_normal }
            }
            None => face_normal,
        };
        let coordinates = mesh.texture_coordinates.as_ref().map(|all| {
            let [a, b, c] = vertices.map(|vertex| all[vertex as usize]);
            let Vec2 { x, y } = a * weights[0] + b * weights[1] + c * weights[2];
            [x, 1.0 - y]
        });
        // Patterns stick to the surface: they are those of the first pose.
        let [a, b, c] = mesh.corners(vertices, 0.0);
        let first = a * weights[0] + b * weights[1] + c * weights[2];
        let place = Place { n: first.normalize_or(Vec3::Y), coordinates };
        let mut albedo = material.albedo(&place, &instant.world.pictures);
        if let Some(model) = materials.get(face_materials[met.triangle as usize] as usize) {
            let [u, v] = coordinates.unwrap_or_default();
            albedo *= model.color * instant.world.pictures.color(model.picture, u, v);
        }
        let point = pose.centre + of.to_world(pose, local);
        let reach = point.abs().max_element().max(local.abs().max_element());
        let point = point + face_normal * (SLACK * reach);
        Self { point, normal, face_normal, albedo, from: None }
    }
}

/// `normal` on the side that a ray in `direction` comes from.
fn facing(normal: Vec3, direction: Vec3) -> Vec3 {
    if normal.dot(direction) > 0.0 { -normal } else { normal }
}
