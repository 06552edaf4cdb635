//! A bounding volume hierarchy over triangles that may move: which triangle does a ray meet first, and
//! does it meet any.
//!
//! Where vertices move linearly, a box whose corners move linearly from the bounds at the shutter's
//! opening to those at its closing holds its triangles at every time between, and is far smaller than
//! one box around the whole motion. The boxes at the closing are an array of their own, empty for a
//! mesh at rest.
//!
//! The nodes are laid out to be uploaded as they are. Children lie side by side, so that one node
//! costs one index. The search goes into the nearer child first and keeps the other on a stack: a
//! search without a stack would have to follow a fixed order, and look at more boxes beyond the
//! nearest hit, or climb through parents. The builder keeps the hierarchy so flat that
//! [`MAX_DEPTH`] places are enough for every mesh, 128 bytes on a graphics card.

mod build;

use super::Mesh;
use super::ray::{Hit, Ray, RayFrame};
use bytemuck::{Pod, Zeroable};
use glam::Vec3;

/// No node lies deeper under the root: the size of the stack that a search needs.
pub const MAX_DEPTH: usize = 32;

/// A box, as the shutter opens if the mesh moves, and what is in it.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Node {
    /// Lower corner.
    pub min: [f32; 3],
    /// A leaf's first face, an inner node's first child; the second child is the next node.
    pub first: u32,
    /// Upper corner.
    pub max: [f32; 3],
    /// Faces of a leaf, 0 for an inner node.
    pub count: u32,
}

/// A node's box as the shutter closes, with the padding that WGSL gives to vectors.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct EndBox {
    /// Lower corner.
    pub min: [f32; 3],
    /// 0.
    pub unused: u32,
    /// Upper corner.
    pub max: [f32; 3],
    /// 0.
    pub unused_too: u32,
}

/// A triangle in the order of the leaves.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
pub struct Face {
    /// Its vertices in the mesh.
    pub vertices: [u32; 3],
    /// Its place in the mesh.
    pub triangle: u32,
}

/// The hierarchy of one mesh. It is the same for any number of threads.
#[derive(Clone, Debug, PartialEq)]
pub struct Bvh {
    /// The root, then pairs of children.
    pub nodes: Vec<Node>,
    /// One per node, or none if nothing moves.
    pub end_boxes: Vec<EndBox>,
    /// The triangles, leaf by leaf.
    pub faces: Vec<Face>,
}

impl Bvh {
    /// The hierarchy of `mesh`, which [`Mesh::check`] has found good.
    pub fn new(mesh: &Mesh) -> Self {
        build::build(mesh)
    }

    /// The first triangle that `ray` meets; `mesh` is the one that the hierarchy was built of.
    pub fn nearest(&self, mesh: &Mesh, ray: &Ray) -> Option<Hit> {
        self.search::<false>(mesh, ray)
    }

    /// Whether `ray` meets a triangle; `mesh` is the one that the hierarchy was built of.
    pub fn any(&self, mesh: &Mesh, ray: &Ray) -> bool {
        self.search::<true>(mesh, ray).is_some()
    }

    fn search<const ANY: bool>(&self, mesh: &Mesh, ray: &Ray) -> Option<Hit> {
        let (min, max) = self.reach();
        let mut frame = RayFrame::new(ray, min, max);
        let mut nearest = None;
        let mut stack = [0_u32; MAX_DEPTH];
        let mut height = 0;
        let mut at = self.enter(0, &frame).map(|_| 0);
        while let Some(index) = at {
            let node = &self.nodes[index as usize];
            let first = node.first;
            at = if node.count == 0 {
                match (self.enter(first, &frame), self.enter(first + 1, &frame)) {
                    (Some(left), Some(right)) => {
                        let right_first = u32::from(right < left);
                        stack[height] = first + 1 - right_first;
                        height += 1;
                        Some(first + right_first)
                    }
                    (Some(_), None) => Some(first),
                    (None, Some(_)) => Some(first + 1),
                    (None, None) => None,
                }
            } else {
                for face in &self.faces[first as usize..][..node.count as usize] {
                    let corners = mesh.corners(face.vertices, ray.time);
                    if let Some((distance, barycentrics)) = frame.meet(corners) {
                        frame.ray.between[1] = distance;
                        nearest = Some(Hit { triangle: face.triangle, distance, barycentrics });
                        if ANY {
                            return nearest;
                        }
                    }
                }
                None
            };
            if at.is_none() && height > 0 {
                height -= 1;
                at = Some(stack[height]);
            }
        }
        nearest
    }

    /// Where the ray enters node `index`.
    fn enter(&self, index: u32, frame: &RayFrame) -> Option<f32> {
        let node = &self.nodes[index as usize];
        let (mut min, mut max) = (Vec3::from(node.min), Vec3::from(node.max));
        if let Some(end) = self.end_boxes.get(index as usize) {
            min = super::between(min, end.min.into(), frame.ray.time);
            max = super::between(max, end.max.into(), frame.ray.time);
        }
        frame.enter(min, max, frame.ray.between[1])
    }

    /// The corners of the box around everything, at any time.
    fn reach(&self) -> (Vec3, Vec3) {
        let (min, max) = (self.nodes[0].min.into(), self.nodes[0].max.into());
        match self.end_boxes.first() {
            None => (min, max),
            Some(end) => (min.min(end.min.into()), max.max(end.max.into())),
        }
    }
}

#[cfg(test)]
mod tests;
