//! Meshes and their hierarchies as `bvh.wgsl` reads them: all in one buffer, because the least of adapters
//! binds few, and per mesh a struct that says where in it what begins.

use super::Mesh;
use super::bvh::Bvh;
use bytemuck::{Pod, Zeroable};
use glam::Vec3;

/// In place of the beginning of what a mesh does not have.
pub const NONE: u32 = u32::MAX;

/// One mesh in the buffer: its reach, and where its parts begin, counted in vectors of four words.
/// `bvh.wgsl` declares the same struct; a test compares them.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct MeshRange {
    /// See [`Bvh::reach`].
    pub min: Vec3,
    /// Seven vectors per node: its planes and its children.
    pub nodes: u32,
    /// See [`Bvh::reach`].
    pub max: Vec3,
    /// The nodes as the shutter closes, in the same seven; `nodes` again for a mesh at rest.
    pub end_nodes: u32,
    /// Ten per leaf: its corners, and its triangles in the mesh.
    pub leaves: u32,
    /// The leaves as the shutter closes, in the same ten; `leaves` again for a mesh at rest.
    pub end_leaves: u32,
    /// One per triangle of the mesh: its vertices and its material.
    pub faces: u32,
    /// One per vertex: its position.
    pub vertices: u32,
    /// Positions as the shutter closes; `vertices` again for a mesh at rest.
    pub end_vertices: u32,
    /// One per vertex: its shading normal, of any length. Or [`NONE`].
    pub normals: u32,
    /// One per vertex: u, v. Or [`NONE`].
    pub texture_coordinates: u32,
    /// The materials of its faces, if a pipeline adds them. Or [`NONE`].
    pub materials: u32,
}

/// The buffer of all meshes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Geometry {
    /// Where in the buffer it begins.
    pub begin: u32,
    /// What to upload.
    pub words: Vec<[u32; 4]>,
}

impl Geometry {
    /// Adds `mesh` with its hierarchy and the material of each of its triangles.
    pub fn push(&mut self, mesh: &Mesh, bvh: &Bvh, face_materials: &[u32]) -> MeshRange {
        debug_assert_eq!(mesh.triangles.len(), face_materials.len());
        let nodes = self.append(bytemuck::cast_slice(&bvh.nodes));
        let leaves = self.append(bytemuck::cast_slice(&bvh.leaves));
        let faces = (mesh.triangles.iter().zip(face_materials))
            .map(|(&[a, b, c], &material)| [a, b, c, material]);
        let faces = self.append(&faces.collect::<Vec<_>>());
        let vertices = self.vectors(&mesh.positions);
        let [mut end_nodes, mut end_leaves, mut end_vertices] = [nodes, leaves, vertices];
        if let Some(end) = &mesh.end_positions {
            // The last word of each is read at the opening alone.
            let ends = bvh
                .end_planes
                .iter()
                .map(|planes| [bytemuck::cast_slice(planes), &[[0; 4]]].concat());
            end_nodes = self.append(&ends.flatten().collect::<Vec<_>>());
            let ends = bvh
                .end_corners
                .iter()
                .map(|corners| [bytemuck::cast_slice(corners.as_flattened()), &[[0; 4]]].concat());
            end_leaves = self.append(&ends.flatten().collect::<Vec<_>>());
            end_vertices = self.vectors(end);
        }
        let normals = mesh.normals.as_ref().map_or(NONE, |normals| self.vectors(normals));
        let texture_coordinates = mesh.texture_coordinates.as_ref().map_or(NONE, |list| {
            let list: Vec<Vec3> = list.iter().map(|at| at.extend(0.0)).collect();
            self.vectors(&list)
        });
        let [min, max] = bvh.reach;
        MeshRange {
            min,
            nodes,
            max,
            end_nodes,
            leaves,
            end_leaves,
            faces,
            vertices,
            end_vertices,
            normals,
            texture_coordinates,
            materials: NONE,
        }
    }

    /// Adds `words`, and returns where they begin.
    pub fn append(&mut self, words: &[[u32; 4]]) -> u32 {
        let begin = self.begin + self.words.len() as u32;
        self.words.extend_from_slice(words);
        begin
    }

    fn vectors(&mut self, list: &[Vec3]) -> u32 {
        let words = list.iter().map(|v| v.extend(0.0).to_array().map(f32::to_bits));
        self.append(&words.collect::<Vec<_>>())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec2;

    #[test]
    fn every_part_lies_where_the_range_says() {
        let mesh = Mesh {
            positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y],
            normals: Some(vec![Vec3::Z; 3]),
            triangles: vec![[0, 1, 2], [2, 1, 0]],
            ..Mesh::default()
        };
        let moving = Mesh {
            end_positions: Some(vec![Vec3::X, Vec3::Y, Vec3::Z]),
            normals: None,
            texture_coordinates: Some(vec![Vec2::new(0.5, 2.0); 3]),
            ..mesh.clone()
        };
        let mut geometry = Geometry::default();
        let rests = geometry.push(&mesh, &Bvh::new(&mesh), &[7, 8]);
        let moves = geometry.push(&moving, &Bvh::new(&moving), &[9, 9]);
        let floats = |at: u32| geometry.words[at as usize].map(f32::from_bits);
        assert_eq!([rests.nodes, rests.end_nodes, rests.end_leaves], [0, 0, rests.leaves]);
        assert_eq!((rests.leaves, rests.faces, rests.vertices), (7, 17, 19));
        assert_eq!(geometry.words[18], [2, 1, 0, 8]);
        assert_eq!(geometry.words[16], [0, 1, 1, 1]);
        assert_eq!(floats(rests.vertices + 1), [1.0, 0.0, 0.0, 0.0]);
        assert_eq!(rests.end_vertices, rests.vertices);
        assert_eq!(floats(rests.normals + 2), [0.0, 0.0, 1.0, 0.0]);
        assert_eq!([rests.texture_coordinates, moves.normals], [NONE; 2]);
        assert_eq!(floats(moves.end_vertices), [1.0, 0.0, 0.0, 0.0]);
        assert_eq!(floats(moves.texture_coordinates), [0.5, 2.0, 0.0, 0.0]);
        // The first corner's x, of both triangles; the second fills the leaf.
        assert_eq!(floats(moves.leaves), [0.0; 4]);
        assert_eq!(floats(moves.end_leaves), [1.0, 0.0, 0.0, 0.0]);
        assert_eq!(moves.end_leaves - moves.end_nodes, 7);
        assert_eq!(moves.end_vertices - moves.end_leaves, 10);
        assert_eq!((moves.min, moves.max), (Vec3::ZERO, Vec3::ONE));
    }
}
