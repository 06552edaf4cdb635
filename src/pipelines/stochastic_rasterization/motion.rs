//! Moving triangles in homogeneous coordinates.

use crate::mesh::Mesh;
use crate::pipelines::frame::Frame;
use crate::raster::shapes::{corners, object_to_image};
use crate::scene::camera::Camera;
use crate::scene::object::Object;
use glam::{Affine3A, Mat3, Vec2, Vec3};
use rayon::prelude::*;
use shutterlab_stimuli::stimulus::View;

/// How far a point may be from where it truly is, in pixels, because a segment takes it straight and evenly.
const TOLERANCE_PX: f32 = 1.0 / 32.0;

/// Most segments of a shutter interval.
const MOST_SEGMENTS: u32 = 256;

/// Nearer to the camera's plane nothing is seen, in metres: as the rasterizer has it.
pub const NEAR: f32 = 1e-6;

/// The way of an object while the shutter is open.
#[derive(Clone, Debug)]
pub struct Way {
    /// At the beginning of each segment and at the end of the last: what takes the object's own space to (x·z, y·z, z),
    /// with x and y in pixels from the image's corner; and where a mesh is between its two poses.
    pub ends: Vec<(Affine3A, f32)>,
    /// The corners of the box around it.
    corners: [Vec3; 8],
}

impl Way {
    /// The way of `object`, whose triangles are those of `shape`.
    pub fn new(frame: &Frame, view: &View, object: &Object, shape: &Mesh) -> Self {
        let instant = |time: f32| {
            let shutter = time - 0.5;
            let pose = object.at(shutter);
            let [width, height] = [frame.params.width, frame.params.height];
            let centre = Vec3::new(0.5 * width as f32, 0.5 * height as f32, 1.0);
            let from_corner = Affine3A::from_mat3(Mat3::from_cols(Vec3::X, Vec3::Y, centre));
            (from_corner * object_to_image(view, width, object, &pose, shutter), pose.time)
        };
        let corners = corners(shape);
        let segments = segments(&corners, shape.end_positions.is_some(), &instant);
        let ends = (0..=segments).map(|end| instant(end as f32 / segments as f32));
        Self { ends: ends.collect(), corners }
    }

    /// The least and the greatest distance along the view of the corners of the box around it.
    pub fn depths(&self) -> [f32; 2] {
        let corners = |(to_image, _): &(Affine3A, f32)| {
            let depth = |&corner| to_image.transform_point3(corner).z;
            self.corners.iter().map(depth).collect::<Vec<_>>()
        };
        let fold = |[least, most]: [f32; 2], z: f32| [least.min(z), most.max(z)];
        self.ends.iter().flat_map(corners).fold([f32::INFINITY, f32::NEG_INFINITY], fold)
    }
}

/// The vertices of an object at the ends of the segments.
#[derive(Clone, Debug)]
pub struct Path {
    /// (x·z, y·z, z) of each vertex.
    ends: Vec<Vec<Vec3>>,
}

impl Path {
    /// The path of `object`, whose triangles are those of `shape`, while the shutter is open.
    pub fn new(frame: &Frame, view: &View, object: &Object, shape: &Mesh) -> Self {
        let ends =
            Way::new(frame, view, object, shape).ends.into_par_iter().map(|(to_image, pose)| {
                shape
                    .vertices_at(pose)
                    .map(|position| to_image.transform_point3(position))
                    .collect()
            });
        Self { ends: ends.collect() }
    }

    /// How many segments there are.
    pub fn segments(&self) -> usize {
        self.ends.len() - 1
    }

    /// The triangle of these vertices during a segment.
    pub fn triangle(&self, segment: usize, vertices: [u32; 3]) -> MovingTriangle {
        let [start, end] = [&self.ends[segment], &self.ends[segment + 1]];
        MovingTriangle {
            start: vertices.map(|v| start[v as usize]),
            end: vertices.map(|v| end[v as usize]),
        }
    }
}

/// How many segments are needed: so many that the corners of the box around an object are, half way through each, within
/// the tolerance of where they should be. It doubles until they are. The object may have two poses.
fn segments(corners: &[Vec3], moves: bool, instant: &impl Fn(f32) -> (Affine3A, f32)) -> u32 {
    let mut segments = 1;
    while segments < MOST_SEGMENTS {
        let is_straight = (0..segments).all(|segment| {
            let at = |part: f32| instant((segment as f32 + part) / segments as f32);
            let [(start, first), (middle, half), (end, last)] = [0.0, 0.5, 1.0].map(at);
            // A vertex that deforms goes evenly from pose to pose while the poses do not turn back.
            let is_even = !moves || (0.5 * (first + last) - half).abs() < 1e-4;
            is_even
                && corners.iter().all(|&corner| {
                    let here = middle.transform_point3(corner);
                    let chord =
                        0.5 * (start.transform_point3(corner) + end.transform_point3(corner));
                    // What is behind the camera or very near is not seen, or seen as one blur.
                    let z = here.z.abs().max(1e-3);
                    (here - chord).abs().max_element() <= TOLERANCE_PX * z
                })
        });
        if is_straight {
            break;
        }
        segments *= 2;
    }
    segments
}

/// A triangle whose corners go straight and evenly from one place to another.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MovingTriangle {
    /// (x·z, y·z, z) of the corners at time 0.
    pub start: [Vec3; 3],
    /// The same at time 1.
    pub end: [Vec3; 3],
}

/// A triangle as it is seen from the corners of the square around the lens. What bounds are made of, the place of its
/// corners, the sides of its edges and which way it is turned, is linear in the point of the lens, so that for any other
/// point it lies between those. A pinhole sees it as it is.
#[derive(Clone, Copy, Debug)]
pub struct Views {
    views: [MovingTriangle; 4],
    count: usize,
}

impl Views {
    /// Of `triangle` from the lens of `camera`.
    pub fn new(triangle: MovingTriangle, camera: &Camera) -> Self {
        if camera.lens_radius == 0.0 {
            return Self { views: [triangle; 4], count: 1 };
        }
        let corners = [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)];
        let view = |(x, y)| triangle.seen_from(camera.parallax(Vec2::new(x, y)));
        Self { views: corners.map(view), count: 4 }
    }

    /// All of them.
    pub fn all(&self) -> &[MovingTriangle] {
        &self.views[..self.count]
    }
}

impl MovingTriangle {
    /// The triangle as a point of the lens with this [`Camera::parallax`] sees it.
    pub fn seen_from(&self, [near, with_depth]: [Vec2; 2]) -> Self {
        let moved = |q: Vec3| (q.truncate() + near + with_depth * q.z).extend(q.z);
        Self { start: self.start.map(moved), end: self.end.map(moved) }
    }

    /// Distance along the view of what of it is seen at `time` at a point of the image, from whichever side. Of triangles
    /// that share an edge at least one has each point: with the sample as origin the two see the same numbers there with
    /// opposite signs.
    pub fn hit(&self, point: Vec2, time: f32) -> Option<f32> {
        let corners: [Vec3; 3] =
            std::array::from_fn(|k| self.start[k] + (self.end[k] - self.start[k]) * time);
        let [a, b, c] = corners.map(|q| q.truncate() - point * q.z);
        let [u, v, w] = [b.perp_dot(c), c.perp_dot(a), a.perp_dot(b)];
        let is_inside = (u >= 0.0 && v >= 0.0 && w >= 0.0) || (u <= 0.0 && v <= 0.0 && w <= 0.0);
        let inverse = 1.0 / (u + v + w);
        if !is_inside || !inverse.is_finite() {
            return None;
        }
        let weights = [u, v, w].map(|edge| edge * inverse);
        let depth = corners.iter().zip(weights).map(|(q, weight)| q.z * weight).sum();
        (depth > NEAR).then_some(depth)
    }
}
