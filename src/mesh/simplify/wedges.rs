//! The wedges of a surface: at each point one for each set of normals and texture coordinates there.

use super::attributes::{AttributeQuadric, Scale, Values};
use super::cluster::{self, Log};
use glam::Vec3;
use std::ops::Range;

/// Wedges in the order of their points, and what the triangles have to do with them.
#[derive(Clone, Debug)]
pub struct Wedges {
    /// The wedges of each triangle.
    pub corners: Vec<[u32; 3]>,
    /// The group, such as the material, of each triangle.
    pub groups: Vec<u32>,
    /// The first wedge of each point, and the number of wedges.
    pub starts: Vec<u32>,
    /// A vertex of the input for each wedge.
    pub vertices: Vec<u32>,
    /// What the wedges carry.
    pub values: Vec<Values>,
    /// How far other values would be from those of the input; empty if values are averaged.
    pub quadrics: Vec<AttributeQuadric>,
    /// How attributes became values.
    pub scale: Scale,
}

impl Wedges {
    /// The wedge that a corner, three times the triangle and which of the three, is at.
    pub fn at(&self, corner: u32) -> u32 {
        self.corners[corner as usize / 3][corner as usize % 3]
    }

    /// Whether several wedges or groups meet at a point with these corners.
    pub fn differ(&self, corners: &[u32]) -> bool {
        let kind = |corner: u32| (self.at(corner), self.groups[corner as usize / 3]);
        corners.windows(2).any(|pair| kind(pair[0]) != kind(pair[1]))
    }

    /// Adds the triangle of points at `positions` to the quadrics of its wedges.
    pub fn add_triangle(&mut self, triangle: usize, positions: [Vec3; 3]) {
        let wedges = self.corners[triangle].map(|wedge| wedge as usize);
        for corner in 0..3 {
            let others = [(corner + 1) % 3, (corner + 2) % 3];
            let here = self.values[wedges[corner]];
            self.quadrics[wedges[corner]].add_triangle(
                others.map(|other| positions[other] - positions[corner]),
                others.map(|other| {
                    let there = self.values[wedges[other]];
                    std::array::from_fn(|attribute| there[attribute] - here[attribute])
                }),
            );
        }
    }

    /// The wedges of consecutive points.
    pub fn of_points(&self, points: Range<usize>) -> Range<usize> {
        self.starts[points.start] as usize..self.starts[points.end] as usize
    }

    /// Carries out what clusters of `size` points did, whose places are still as they were; says where each
    /// wedge has gone.
    pub fn apply<const F: usize>(
        &mut self,
        size: usize,
        logs: &[Log<F>],
        positions: &[[Vec3; F]],
    ) -> Vec<u32> {
        let mut forward: Vec<u32> = (0..self.values.len() as u32).collect();
        for (cluster, log) in logs.iter().enumerate() {
            let first = cluster * size;
            let points = first..positions.len().min(first + size);
            let own = self.of_points(points.clone());
            let mut places: Vec<Vec3> = positions[points].iter().map(|p| p[0]).collect();
            let quadrics = self.quadrics.get_mut(own.clone()).unwrap_or_default();
            let mut pairs = log.wedges.iter();
            for contraction in &log.contractions {
                let (r, k) = (contraction.removed as usize, contraction.kept as usize);
                let to = contraction.position[0];
                for &pair in pairs.by_ref().take(contraction.wedges as usize) {
                    let ends = [places[k], places[r]];
                    let values = &mut self.values[own.clone()];
                    cluster::merge_wedges(quadrics, values, pair, ends, to);
                    forward[own.start + pair.0 as usize] = own.start as u32 + pair.1;
                }
                places[k] = to;
            }
            // A wedge goes where that goes which it went into.
            let count = log.contractions.iter().map(|c| c.wedges as usize).sum();
            for &(removed, ..) in log.wedges[..count].iter().rev() {
                let r = own.start + removed as usize;
                forward[r] = forward[forward[r] as usize];
            }
        }
        forward
    }

    /// Leaves out the wedges that have gone elsewhere, as `forward` says, and those that no triangle needs; points
    /// that are not needed have none.
    pub fn compact(&mut self, is_point_needed: &[bool], mut forward: Vec<u32>) {
        let mut is_needed = vec![false; forward.len()];
        for wedge in self.corners.as_flattened_mut() {
            *wedge = forward[*wedge as usize];
            is_needed[*wedge as usize] = true;
        }
        let (mut starts, mut new) = (vec![], 0);
        for point in (0..is_point_needed.len()).filter(|&point| is_point_needed[point]) {
            starts.push(new);
            for wedge in self.of_points(point..point + 1) {
                if is_needed[wedge] {
                    forward[wedge] = new;
                    self.values[new as usize] = self.values[wedge];
                    self.vertices[new as usize] = self.vertices[wedge];
                    if !self.quadrics.is_empty() {
                        self.quadrics[new as usize] = self.quadrics[wedge];
                    }
                    new += 1;
                }
            }
        }
        starts.push(new);
        self.starts = starts;
        self.values.truncate(new as usize);
        self.vertices.truncate(new as usize);
        self.quadrics.truncate(new as usize);
        for wedge in self.corners.as_flattened_mut() {
            *wedge = forward[*wedge as usize];
        }
    }

    /// Puts the wedges into the order of their points, of which each is behind its place on a curve.
    pub fn reorder(&mut self, order: &[(u64, u32)]) {
        let (mut starts, mut from) = (vec![], Vec::with_capacity(self.values.len()));
        for &(_, point) in order {
            starts.push(from.len() as u32);
            from.extend(self.of_points(point as usize..point as usize + 1));
        }
        starts.push(from.len() as u32);
        self.starts = starts;
        let mut new = vec![0; from.len()];
        for (place, &wedge) in from.iter().enumerate() {
            new[wedge] = place as u32;
        }
        self.values = from.iter().map(|&wedge| self.values[wedge]).collect();
        self.vertices = from.iter().map(|&wedge| self.vertices[wedge]).collect();
        if !self.quadrics.is_empty() {
            self.quadrics = from.iter().map(|&wedge| self.quadrics[wedge]).collect();
        }
        for wedge in self.corners.as_flattened_mut() {
            *wedge = new[*wedge as usize];
        }
    }
}
