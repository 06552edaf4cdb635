//! The pinhole camera, which may move while the shutter is open.

use bytemuck::{Pod, Zeroable};
use glam::{DVec3, Vec3};
use shutterlab_stimuli::stimulus::View;

/// A pinhole and the frame about it, in world space, as both devices read it. Metres.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Camera {
    /// The pinhole at the frame's time.
    pub position: Vec3,
    /// Distance from the pinhole to the image plane, in pixels.
    pub focal_length_px: f32,
    /// Unit vector towards the point in the centre of the image.
    pub forward: Vec3,
    /// Where the camera's axis meets the image, in pixels to the right of its centre.
    pub shift_px: f32,
    /// Unit vector towards the right of the image.
    pub right: Vec3,
    /// 1 if the camera moves.
    pub moves: u32,
    /// Unit vector towards the top of the image.
    pub up: Vec3,
    /// Distance from the pinhole to the point in the centre of the image.
    pub focus_distance: f32,
    /// How far the pinhole goes while the shutter is open.
    pub travel: Vec3,
    /// Fills up to a multiple of 16 bytes.
    pub padding: u32,
    /// How far the point in the centre of the image goes meanwhile.
    pub look_at_travel: Vec3,
    /// Fills up to a multiple of 16 bytes.
    pub padding_too: u32,
}

impl Camera {
    /// The camera of `view` with an image `width_px` wide. It holds y up.
    pub fn new(view: &View, width_px: u32) -> Self {
        let single = |v: [f64; 3]| DVec3::from(v).as_vec3();
        let description = &view.camera;
        let forward = DVec3::from(description.forward());
        let right = DVec3::from(description.right());
        let [travel, look_at_travel] = view.travel_m.map(single);
        Self {
            position: single(description.position_m),
            focal_length_px: description.focal_length_px(width_px) as f32,
            forward: forward.as_vec3(),
            shift_px: view.shift_px as f32,
            right: right.as_vec3(),
            moves: u32::from(travel != Vec3::ZERO || look_at_travel != Vec3::ZERO),
            up: right.cross(forward).as_vec3(),
            focus_distance: description.focus_distance_m() as f32,
            travel,
            padding: 0,
            look_at_travel,
            padding_too: 0,
        }
    }

    /// Origin and unit direction of the ray through the point of the image `x` pixels to the right of its
    /// centre and `y` below, when the part `shutter` ∈ [−½, ½] of the shutter interval, counted from its
    /// middle, has passed.
    pub fn ray(&self, x: f32, y: f32, shutter: f32) -> (Vec3, Vec3) {
        let x = (x - self.shift_px) / self.focal_length_px;
        let y = y / self.focal_length_px;
        if self.moves == 0 {
            return (self.position, (self.forward + self.right * x - self.up * y).normalize());
        }
        let to_look_at =
            self.forward * self.focus_distance + (self.look_at_travel - self.travel) * shutter;
        let forward = to_look_at.normalize_or(self.forward);
        // Straight up or down there is no telling what is right: it stays.
        let right = Vec3::new(-forward.z, 0.0, forward.x).normalize_or(self.right);
        let up = right.cross(forward);
        let origin = self.position + self.travel * shutter;
        (origin, (forward + right * x - up * y).normalize())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use shutterlab_stimuli::{Grid, Selection};

    /// Within the interval a moving camera is what a camera at rest in the same place is.
    #[test]
    fn a_moving_camera_is_at_each_instant_one_at_rest() {
        let grid = Grid::load("rolling-sphere-mono").unwrap();
        let stimulus = grid.stimuli(&Selection::default()).unwrap().remove(0);
        let view = stimulus.views(0).remove(0);
        let travel_m = [[0.3, -0.2, 0.1], [-0.4, 0.5, 0.2]];
        let moving = Camera::new(&View { travel_m, ..view.clone() }, 640);
        for shutter in [-0.5, 0.0, 0.3] {
            let mut there = view.clone();
            let places = [&mut there.camera.position_m, &mut there.camera.look_at_m];
            for (place, travel) in places.into_iter().zip(travel_m) {
                place.iter_mut().zip(travel).for_each(|(c, by)| *c += shutter * by);
            }
            let (origin, direction) = moving.ray(30.0, -70.0, shutter as f32);
            let (known_origin, known) = Camera::new(&there, 640).ray(30.0, -70.0, 0.0);
            assert!(origin.abs_diff_eq(known_origin, 1e-6) && direction.abs_diff_eq(known, 1e-6));
        }
    }
}
