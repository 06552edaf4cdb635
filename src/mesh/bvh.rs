//! A bounding volume hierarchy over triangles that may move: which triangle does a ray meet first, and
//! does it meet any.
//!
//! Where vertices move linearly, a box whose corners move linearly from the bounds at the shutter's
//! opening to those at its closing holds its triangles at every time between, and is far smaller than
//! one box around the whole motion. The boxes at the closing are an array of their own, empty for a
//! mesh at rest.
//!
//! A node has up to four children, which a ray meets at once in the lanes of a vector, and a leaf has up
//! to four triangles [Dammertz2008]. The search goes into the nearest child first and keeps the others
//! on a stack: a search without a stack would have to follow a fixed order, and look at more boxes
//! beyond the nearest hit, or climb through parents. The builder keeps the hierarchy so flat that
//! [`STACK`] places are enough for every mesh.
//!
//! Nodes and leaves are vectors of four words, to be uploaded as they are.

mod build;
mod nearest_point;

use super::ray::{Corners, Hit, Planes, Ray, RayFrame};
use super::{Mesh, between};
use bytemuck::{Pod, Zeroable};
use glam::Vec3;

/// No leaf lies deeper under the root of the binary hierarchy that the wide one is made of.
pub const MAX_DEPTH: usize = 32;

/// The places of the stack that a search needs: a child that is a node lies at least two binary levels
/// below its parent and leaves at most three others waiting.
pub const STACK: usize = 3 * (MAX_DEPTH / 2);

/// The bit of a child that is a leaf; the others are its place among the leaves or the nodes.
pub const LEAF: u32 = 1 << 31;

/// Up to four children. The places that have none come last, with a box that no ray enters.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Node {
    /// Their boxes, as the shutter opens if the mesh moves.
    pub planes: Planes,
    /// Where they are.
    pub children: [u32; 4],
}

/// Up to four triangles; the last fills the places that are left.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Leaf {
    /// Their corners, as the shutter opens if the mesh moves.
    pub corners: Corners,
    /// Their places in the mesh.
    pub triangles: [u32; 4],
}

/// The hierarchy of one mesh. It is the same for any number of threads.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Bvh {
    /// The root, then the other nodes, each before those below it.
    pub nodes: Vec<Node>,
    /// The nodes' boxes as the shutter closes, none if nothing moves.
    pub end_planes: Vec<Planes>,
    /// The triangles.
    pub leaves: Vec<Leaf>,
    /// The leaves' corners as the shutter closes, none if nothing moves.
    pub end_corners: Vec<Corners>,
    /// The corners of the box around everything, at any time.
    pub reach: [Vec3; 2],
}

impl Bvh {
    /// The hierarchy of `mesh`, which [`Mesh::check`] has found good.
    pub fn new(mesh: &Mesh) -> Self {
        build::build(mesh)
    }

    /// The first triangle that `ray` meets.
    pub fn nearest(&self, ray: &Ray) -> Option<Hit> {
        self.search::<false>(ray)
    }

    /// Whether `ray` meets a triangle.
    pub fn any(&self, ray: &Ray) -> bool {
        self.search::<true>(ray).is_some()
    }

    fn search<const ANY: bool>(&self, ray: &Ray) -> Option<Hit> {
        if self.end_planes.is_empty() {
            self.search_in::<ANY, false>(ray)
        } else {
            self.search_in::<ANY, true>(ray)
        }
    }

    fn search_in<const ANY: bool, const MOVES: bool>(&self, ray: &Ray) -> Option<Hit> {
        let mut frame = RayFrame::new(ray, self.reach);
        let mut hit = None;
        // What is to be searched and where the ray enters it, the nearest on top.
        let mut stack = [(0_u32, 0.0_f32); STACK];
        let mut height = 0;
        let mut child = 0;
        loop {
            if child & LEAF == 0 {
                let node = &self.nodes[child as usize];
                let (mut entered, near) = if MOVES {
                    let end = &self.end_planes[child as usize];
                    frame.enter(|k| between(node.planes[k], end[k], ray.time))
                } else {
                    frame.enter(|k| node.planes[k])
                };
                let mut next_entered = || {
                    let lane = (entered != 0).then(|| entered.trailing_zeros() as usize & 3)?;
                    entered &= entered - 1;
                    Some((node.children[lane], near[lane]))
                };
                if let Some(mut first) = next_entered() {
                    let below = height;
                    while let Some(mut other) = next_entered() {
                        if other.1 < first.1 {
                            std::mem::swap(&mut first, &mut other);
                        }
                        let mut place = height;
                        while !ANY && place > below && stack[place - 1].1 < other.1 {
                            stack[place] = stack[place - 1];
                            place -= 1;
                        }
                        stack[place] = other;
                        height += 1;
                    }
                    child = first.0;
                    continue;
                }
            } else {
                let place = (child & !LEAF) as usize;
                let leaf = &self.leaves[place];
                let start = &leaf.corners;
                let met = if MOVES {
                    let end = &self.end_corners[place];
                    frame.meet(|corner, k| between(start[corner][k], end[corner][k], ray.time))
                } else {
                    frame.meet(|corner, k| start[corner][k])
                };
                if let Some((lane, distance, barycentrics)) = met {
                    frame.between[1] = distance;
                    hit = Some(Hit { triangle: leaf.triangles[lane], distance, barycentrics });
                    if ANY {
                        return hit;
                    }
                }
            }
            loop {
                if height == 0 {
                    return hit;
                }
                height -= 1;
                let near;
                (child, near) = stack[height];
                if ANY || near < frame.between[1] {
                    break;
                }
            }
        }
    }
}

#[cfg(test)]
pub(super) mod tests;
