//! How far a point is from the nearest triangle.
//!
//! The hierarchy is searched in single precision, as rays do; triangles are measured in double precision, in
//! which the plane of the thinnest one is still known.

use super::{Bvh, LEAF, STACK};
use crate::mesh::ray::{Corners, Planes};
use glam::{DVec4, Vec3, Vec4};

impl Bvh {
    /// The squared distance of `point` from the nearest of the triangles, which are at rest. `leaf` is the leaf
    /// to look into first, and then that of the nearest triangle: for a point close to the last one, nearly
    /// all others are too far away.
    pub fn squared_distance(&self, point: Vec3, leaf: &mut u32) -> f64 {
        let lanes = point.to_array().map(Vec4::splat);
        let mut least = self.squared_distance_from_leaf(*leaf, point);
        // What is to be searched and how far away its box is, the nearest on top.
        let mut stack = [(0_u32, 0.0_f32); STACK + 1];
        let mut height = 1;
        while height > 0 {
            height -= 1;
            let (child, away) = stack[height];
            if f64::from(away) >= least {
                continue;
            }
            if child & LEAF != 0 {
                let place = child & !LEAF;
                let distance = self.squared_distance_from_leaf(place, point);
                if distance < least {
                    (least, *leaf) = (distance, place);
                }
                continue;
            }
            let node = &self.nodes[child as usize];
            let away = squared_distances_of_boxes(&node.planes, lanes);
            let below = height;
            for (child, away) in node.children.into_iter().zip(away.to_array()) {
                if f64::from(away) >= least {
                    continue;
                }
                let mut place = height;
                while place > below && stack[place - 1].1 < away {
                    stack[place] = stack[place - 1];
                    place -= 1;
                }
                stack[place] = (child, away);
                height += 1;
            }
        }
        least
    }

    fn squared_distance_from_leaf(&self, leaf: u32, point: Vec3) -> f64 {
        squared_distances(&self.leaves[leaf as usize].corners, point).min_element()
    }
}

fn squared_distances_of_boxes(planes: &Planes, point: [Vec4; 3]) -> Vec4 {
    let [x, y, z] = [0, 1, 2].map(|axis| {
        let outside = (planes[axis] - point[axis]).max(point[axis] - planes[axis + 3]);
        outside.max(Vec4::ZERO)
    });
    x * x + y * y + z * z
}

/// The squared distance of a point from each of four triangles: from the plane where the point projects into the
/// triangle, else from the nearest edge.
fn squared_distances(corners: &Corners, point: Vec3) -> DVec4 {
    type Vector = [DVec4; 3];
    let dot = |a: Vector, b: Vector| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let cross = |a: Vector, b: Vector| {
        [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    };
    let minus = |a: Vector, b: Vector| [a[0] - b[0], a[1] - b[1], a[2] - b[2]];

    let at = point.as_dvec3().to_array().map(DVec4::splat);
    // From each corner to the point, and to the next corner.
    let from = corners.map(|corner| minus(at, corner.map(|along| along.as_dvec4())));
    let edges = [0, 1, 2].map(|k| minus(from[k], from[(k + 1) % 3]));
    let normal = cross(edges[0], edges[1]);
    let squared_normal = dot(normal, normal);

    let mut inside = squared_normal.cmpgt(DVec4::ZERO);
    let mut least = DVec4::INFINITY;
    for (edge, from) in edges.into_iter().zip(from) {
        inside &= dot(cross(normal, edge), from).cmpge(DVec4::ZERO);
        // An edge of two equal corners is its corner.
        let length = dot(edge, edge).max(DVec4::splat(f64::MIN_POSITIVE));
        let along = (dot(from, edge) / length).clamp(DVec4::ZERO, DVec4::ONE);
        let away = minus(from, edge.map(|axis| axis * along));
        least = least.min(dot(away, away));
    }
    let height = dot(normal, from[0]);
    DVec4::select(inside, height * height / squared_normal, least)
}
