//! The pinhole camera.

use glam::{DVec3, Vec3};
use shutterlab_stimuli::scene;

/// An orthonormal frame at the pinhole, in world space, and the focal length in pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// The pinhole, in metres.
    pub position: Vec3,
    /// Towards the centre of the image.
    pub forward: Vec3,
    /// Towards the right of the image.
    pub right: Vec3,
    /// Towards the top of the image.
    pub up: Vec3,
    /// Distance from the pinhole to the image plane, in pixels.
    pub focal_length_px: f32,
}

impl Camera {
    /// The camera of `description` with an image `width_px` wide. It holds y up.
    pub fn new(description: &scene::Camera, width_px: u32) -> Self {
        let position = DVec3::from(description.position_m);
        let forward = (DVec3::from(description.look_at_m) - position).normalize_or(DVec3::NEG_Z);
        let right = DVec3::from(description.right());
        let up = right.cross(forward);
        Self {
            position: position.as_vec3(),
            forward: forward.as_vec3(),
            right: right.as_vec3(),
            up: up.as_vec3(),
            focal_length_px: description.focal_length_px(width_px) as f32,
        }
    }
}
