//! Progressive meshes [Hoppe1996]: a coarse mesh and the vertex splits that lead from it to the input, each
//! of which can be undone.
//!
//! A record holds every contraction of one simplification. Going from one level of detail to another costs
//! time in proportion to the splits in between. Vertices and faces are numbered from coarse to fine, so that
//! those of any level are the first ones.
//!
//! ```
//! use shutterlab::mesh::Mesh;
//! use shutterlab::mesh::simplify::{Options, progressive::record};
//!
//! // A grid of 8 by 8 squares.
//! let positions = (0..81).map(|i| glam::vec3((i % 9) as f32, (i / 9) as f32, 0.0)).collect();
//! let squares = (0..64).map(|i| i % 8 + 9 * (i / 8));
//! let triangles = squares.flat_map(|i| [[i, i + 1, i + 10], [i, i + 10, i + 9]]).collect();
//! let input = Mesh { positions, triangles, ..Mesh::default() };
//!
//! let mut progressive = record(&input, None, &Options::default(), &[])?;
//! progressive.set_faces(20);
//! let (mesh, faces) = progressive.mesh();
//! assert!(mesh.triangles.len() <= 20 && mesh.triangles.len() == faces.len());
//! progressive.set_faces(usize::MAX);
//! assert_eq!(progressive.mesh().0, input);
//! # Ok::<(), shutterlab::mesh::simplify::SimplifyError>(())
//! ```

pub mod file;
pub(super) mod recorder;
mod redirect;
#[cfg(test)]
mod tests;

pub use redirect::{Directed, redirect};

use super::surface::Surface;
use super::{Options, SimplifyError};
use crate::mesh::Mesh;
use glam::{Vec2, Vec3};
use rayon::prelude::*;
use recorder::Recorder;

/// Which numbers a vertex has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Layout {
    /// A position at the end, three numbers behind the three of the position.
    has_end: bool,
    /// A normal, three numbers.
    has_normal: bool,
    /// Texture coordinates, two numbers.
    has_texture: bool,
    /// The normals are those of the input's faces, so that no other level has any.
    is_flat: bool,
}

/// A split of one vertex, or of two at a seam; the last of all may split many.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Split {
    /// How many vertex splits there are up to it.
    vertices: u32,
    /// How many faces there are after it.
    faces: u32,
    /// The error of the mesh after it.
    error: f32,
}

/// One vertex becomes two, of which the new one is the next that was not there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct VertexSplit {
    /// The vertex that was there.
    old: u32,
    /// Where its corners, which go from the old vertex to the new one, end in the list of all.
    corners: u32,
}

/// A mesh that goes from any level of detail to any other.
#[derive(Clone, Debug, PartialEq)]
pub struct ProgressiveMesh {
    layout: Layout,
    /// How many vertices and faces the input has; a file that was read in part has brought fewer.
    input: [u32; 2],
    /// The faces of the coarsest mesh, and its error.
    base_faces: u32,
    base_error: f32,
    /// The numbers of all vertices as they are now, or will be when they come.
    values: Vec<f32>,
    /// The vertices of all faces as they are now, or will be when they come.
    triangles: Vec<[u32; 3]>,
    /// The numbers that vertices and faces have in the input.
    vertex_ids: Vec<u32>,
    face_ids: Vec<u32>,
    /// From coarse to fine.
    splits: Vec<Split>,
    vertex_splits: Vec<VertexSplit>,
    /// For each vertex split the numbers of the old vertex on the other side of it.
    split_values: Vec<f32>,
    /// Three times the face and which of the three, growing in each vertex split.
    corners: Vec<u32>,
    /// How many splits have been done.
    done: usize,
    /// Multiples of the speed, growing, and the splits that have to be done at each.
    speeds: Vec<(f32, u32)>,
}

impl Layout {
    fn of(mesh: &Mesh) -> Self {
        Self {
            has_end: mesh.end_positions.is_some(),
            has_normal: mesh.normals.is_some(),
            has_texture: mesh.texture_coordinates.is_some(),
            is_flat: false,
        }
    }

    /// Numbers of a vertex.
    fn stride(&self) -> usize {
        3 + 3 * usize::from(self.has_end)
            + 3 * usize::from(self.has_normal)
            + 2 * usize::from(self.has_texture)
    }

    /// The numbers of a vertex in a row.
    fn pack(&self, keyframes: [Vec3; 2], normal: Vec3, texture: Vec2, to: &mut Vec<f32>) {
        to.extend(keyframes[0].to_array());
        if self.has_end {
            to.extend(keyframes[1].to_array());
        }
        if self.has_normal {
            to.extend(normal.to_array());
        }
        if self.has_texture {
            to.extend(texture.to_array());
        }
    }
}

/// Simplifies as [`simplify`] does, and records it. With a limit, and `speeds`, it goes on for growing
/// multiples of the motion's speed, to each of which [`ProgressiveMesh::set_speed`] leads; without it goes on
/// to the faces or the error that is asked for, or as far as it can.
///
/// # Errors
/// As [`simplify`], and speeds that do not grow from above 0.
pub fn record(
    mesh: &Mesh,
    groups: Option<&[u32]>,
    options: &Options,
    speeds: &[f32],
) -> Result<ProgressiveMesh, SimplifyError> {
    options.check(mesh, groups)?;
    let mut last = 0.0;
    for &speed in speeds {
        if !(speed.is_finite() && speed > last) {
            return Err(SimplifyError::value(
                "speeds",
                speed,
                "growing numbers above 0 are allowed",
            ));
        }
        last = speed;
    }
    match mesh.end_positions {
        None => recorded::<1>(mesh, groups, options, speeds),
        Some(_) => recorded::<2>(mesh, groups, options, speeds),
    }
}

fn recorded<const F: usize>(
    mesh: &Mesh,
    groups: Option<&[u32]>,
    options: &Options,
    speeds: &[f32],
) -> Result<ProgressiveMesh, SimplifyError> {
    let mut surface = Surface::<F>::new(mesh, groups, options.attributes)?;
    let mut recorder = Recorder::new(mesh, &surface);
    if let Some(limit) = options.limit {
        // A slower one, too, for `redirect` to begin with.
        for &speed in if speeds.is_empty() { &[1.0 / redirect::SPARE as f32, 1.0] } else { speeds }
        {
            let mut limit = limit;
            limit.slope *= speed;
            let settings = options.settings(surface.unit, Some(limit));
            surface.contract(&settings, options.faces, Some(&mut recorder));
            recorder.reached(speed);
        }
    } else {
        let settings = options.settings(surface.unit, None);
        surface.contract(&settings, options.faces, Some(&mut recorder));
    }
    Ok(recorder.finish())
}

impl ProgressiveMesh {
    /// How many faces there are now.
    pub fn face_count(&self) -> usize {
        self.faces_after(self.done)
    }

    /// How many faces there are at the coarsest level and at the finest.
    pub fn face_counts(&self) -> [usize; 2] {
        [self.base_faces as usize, self.triangles.len()]
    }

    /// The error of the mesh as it is now, in the mesh's unit: the largest root of the mean squared distance to
    /// the planes that a contraction replaced.
    pub fn error(&self) -> f32 {
        self.error_after(self.done)
    }

    /// Goes to `faces` faces, or as many fewer as one split brings; to the coarsest mesh if that has more.
    pub fn set_faces(&mut self, faces: usize) {
        self.go_to(self.splits_for_faces(faces));
    }

    /// Goes to the coarsest mesh whose error is not above `error`, or to the finest.
    pub fn set_error(&mut self, error: f32) {
        self.go_to(self.splits_for_error(error));
    }

    /// Goes to the mesh of the largest recorded multiple of the speed that is not above `speed`, or to the
    /// input if all are.
    pub fn set_speed(&mut self, speed: f32) {
        self.go_to(self.splits_for_speed(speed));
    }

    fn splits_for_faces(&self, faces: usize) -> usize {
        self.splits.partition_point(|split| split.faces as usize <= faces)
    }

    fn splits_for_error(&self, error: f32) -> usize {
        match self.base_error <= error {
            true => 0,
            false => 1 + self.splits.partition_point(|split| split.error > error),
        }
    }

    fn splits_for_speed(&self, speed: f32) -> usize {
        let recorded = self.speeds.iter().rfind(|(recorded, _)| *recorded <= speed);
        recorded.map_or(usize::MAX, |&(_, splits)| splits as usize)
    }

    fn faces_after(&self, splits: usize) -> usize {
        let last = splits.checked_sub(1).map(|last| self.splits[last].faces);
        last.unwrap_or(self.base_faces) as usize
    }

    fn vertex_splits_after(&self, splits: usize) -> usize {
        splits.checked_sub(1).map_or(0, |last| self.splits[last].vertices as usize)
    }

    fn error_after(&self, splits: usize) -> f32 {
        splits.checked_sub(1).map_or(self.base_error, |last| self.splits[last].error)
    }

    /// How many vertices there are before any split.
    fn base_vertices(&self) -> usize {
        self.vertex_ids.len() - self.vertex_splits.len()
    }

    /// Whether nothing of the input is missing now.
    fn is_input(&self) -> bool {
        self.done == self.splits.len()
            && [&self.vertex_ids, &self.face_ids].map(|ids| ids.len() as u32) == self.input
    }

    /// Does or undoes splits until `splits` of them, or all, are done.
    fn go_to(&mut self, splits: usize) {
        let splits = splits.min(self.splits.len());
        let [now, then] = [self.done, splits].map(|splits| self.vertex_splits_after(splits));
        let base = self.base_vertices();
        for index in now..then {
            self.exchange(index, (base + index) as u32);
        }
        for index in (then..now).rev() {
            self.exchange(index, self.vertex_splits[index].old);
        }
        self.done = splits;
    }

    /// Goes to the other side of a vertex split, where its corners are at vertex `to`.
    fn exchange(&mut self, index: usize, to: u32) {
        let VertexSplit { old, corners } = self.vertex_splits[index];
        let before = index.checked_sub(1).map_or(0, |before| self.vertex_splits[before].corners);
        for &corner in &self.corners[before as usize..corners as usize] {
            self.triangles.as_flattened_mut()[corner as usize] = to;
        }
        let stride = self.layout.stride();
        self.values[old as usize * stride..][..stride]
            .swap_with_slice(&mut self.split_values[index * stride..][..stride]);
    }

    /// The mesh as it is now and, for each of its faces, which face of the input it is. At the finest level
    /// this is the input; at others without the vertices that no face needs, and without normals if those were the
    /// faces' own.
    pub fn mesh(&self) -> (Mesh, Vec<u32>) {
        let triangles = &self.triangles[..self.face_count()];
        let mut faces: Vec<u32> = (0..triangles.len() as u32).collect();
        faces.par_sort_unstable_by_key(|&face| self.face_ids[face as usize]);
        let count = self.base_vertices() + self.vertex_splits_after(self.done);
        let mut is_used = vec![self.is_input(); count];
        triangles.as_flattened().iter().for_each(|&vertex| is_used[vertex as usize] = true);
        let mut used: Vec<u32> = (0..count as u32).filter(|&v| is_used[v as usize]).collect();
        used.par_sort_unstable_by_key(|&vertex| self.vertex_ids[vertex as usize]);
        let mut places = vec![0; count];
        for (place, &vertex) in used.iter().enumerate() {
            places[vertex as usize] = place as u32;
        }

        let stride = self.layout.stride();
        let mut width = 0;
        // The next numbers of all vertices.
        let mut column = |has_it: bool, count: usize| {
            let from = width;
            width += if has_it { count } else { 0 };
            let rows = used.iter().map(move |&v| &self.values[v as usize * stride + from..]);
            has_it.then_some(rows)
        };
        let mesh = Mesh {
            positions: column(true, 3).into_iter().flatten().map(Vec3::from_slice).collect(),
            end_positions: column(self.layout.has_end, 3)
                .map(|rows| rows.map(Vec3::from_slice).collect()),
            normals: column(self.layout.has_normal, 3)
                .filter(|_| !self.layout.is_flat || self.is_input())
                .map(|rows| rows.map(Vec3::from_slice).collect()),
            texture_coordinates: column(self.layout.has_texture, 2)
                .map(|rows| rows.map(Vec2::from_slice).collect()),
            triangles: faces
                .iter()
                .map(|&face| triangles[face as usize].map(|vertex| places[vertex as usize]))
                .collect(),
        };
        faces.iter_mut().for_each(|face| *face = self.face_ids[*face as usize]);
        (mesh, faces)
    }
}
