//! The camera, a pinhole or a thin lens, which may move while the shutter is open.

use bytemuck::{Pod, Zeroable};
use glam::{DVec3, Vec2, Vec3};
use shutterlab_stimuli::stimulus::View;

/// A pinhole, or the middle of a lens, and the frame about it, in world space, as both devices read it. Metres.
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
    pub look_at_distance: f32,
    /// How far the pinhole goes while the shutter is open.
    pub travel: Vec3,
    /// Radius of the lens; 0 of a pinhole.
    pub lens_radius: f32,
    /// How far the point in the centre of the image goes meanwhile.
    pub look_at_travel: Vec3,
    /// Distance from the lens to the plane that it is focused on.
    pub focus_distance: f32,
}

impl Camera {
    /// The camera of `view` with an image `width_px` wide. It holds y up.
    pub fn new(view: &View, width_px: u32) -> Self {
        let single = |v: [f64; 3]| DVec3::from(v).as_vec3();
        let description = &view.camera;
        let forward = DVec3::from(description.forward());
        let right = DVec3::from(description.right());
        let [travel, look_at_travel] = view.travel_m.map(single);
        let look_at_distance = description.look_at_distance_m();
        Self {
            position: single(description.position_m),
            focal_length_px: description.focal_length_px(width_px) as f32,
            forward: forward.as_vec3(),
            shift_px: view.shift_px as f32,
            right: right.as_vec3(),
            moves: u32::from(travel != Vec3::ZERO || look_at_travel != Vec3::ZERO),
            up: right.cross(forward).as_vec3(),
            look_at_distance: look_at_distance as f32,
            travel,
            lens_radius: description.lens_radius_m() as f32,
            look_at_travel,
            focus_distance: description.focus_distance_m.unwrap_or(look_at_distance) as f32,
        }
    }

    /// Origin and unit direction of the ray through the point of the image `x` pixels to the right of its
    /// centre and `y` below, when the part `shutter` ∈ [−½, ½] of the shutter interval, counted from its
    /// middle, has passed. It begins at the point `lens` of the lens, a unit disk with its axes to the right and up.
    pub fn ray(&self, x: f32, y: f32, shutter: f32, lens: Vec2) -> (Vec3, Vec3) {
        let x = (x - self.shift_px) / self.focal_length_px;
        let y = y / self.focal_length_px;
        let mut middle = self.position;
        let [mut forward, mut right, mut up] = [self.forward, self.right, self.up];
        if self.moves != 0 {
            let to_look_at =
                forward * self.look_at_distance + (self.look_at_travel - self.travel) * shutter;
            forward = to_look_at.normalize_or(forward);
            // Straight up or down there is no telling what is right: it stays.
            right = Vec3::new(-forward.z, 0.0, forward.x).normalize_or(right);
            up = right.cross(forward);
            middle += self.travel * shutter;
        }
        let direction = forward + right * x - up * y;
        // All rays of a point of the image meet in the plane of focus.
        let aside = (right * lens.x + up * lens.y) * self.lens_radius;
        (middle + aside, (direction - aside / self.focus_distance).normalize())
    }

    /// Where the point `lens` of the lens sees a point of the world, if the middle sees it at (x·z, y·z, z), y down: to
    /// the first two come the first of these and z times the second. In the image this is the lens's radius times
    /// the focal length in pixels times 1/focus_distance − 1/z, the radius of the circle of confusion.
    pub fn parallax(&self, lens: Vec2) -> [Vec2; 2] {
        let near = Vec2::new(-lens.x, lens.y) * (self.lens_radius * self.focal_length_px);
        [near, -near / self.focus_distance]
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
        let mut view = stimulus.views(0).remove(0);
        (view.camera.aperture_f_number, view.camera.focus_distance_m) = (Some(1.4), Some(2.5));
        let travel_m = [[0.3, -0.2, 0.1], [-0.4, 0.5, 0.2]];
        let moving = Camera::new(&View { travel_m, ..view.clone() }, 640);
        let lens = Vec2::new(0.6, -0.4);
        for shutter in [-0.5, 0.0, 0.3] {
            let mut there = view.clone();
            let places = [&mut there.camera.position_m, &mut there.camera.look_at_m];
            for (place, travel) in places.into_iter().zip(travel_m) {
                place.iter_mut().zip(travel).for_each(|(c, by)| *c += shutter * by);
            }
            let (origin, direction) = moving.ray(30.0, -70.0, shutter as f32, lens);
            let (known_origin, known) = Camera::new(&there, 640).ray(30.0, -70.0, 0.0, lens);
            assert!(origin.abs_diff_eq(known_origin, 1e-6) && direction.abs_diff_eq(known, 1e-6));
        }
    }

    /// By the thin lens: a point at distance z is a disk of the diameter (aperture · image distance) · |1/f − 1/z| on the
    /// sensor for a focus at f, with the aperture focal length / f-number. By similar triangles, not by our rays.
    #[test]
    fn a_point_out_of_focus_is_a_circle_of_confusion() {
        let grid = Grid::load("rolling-sphere-mono").unwrap();
        let stimulus = grid.stimuli(&Selection::default()).unwrap().remove(0);
        let mut view = stimulus.views(0).remove(0);
        (view.camera.aperture_f_number, view.camera.focus_distance_m) = (Some(2.0), Some(4.0));
        let camera = Camera::new(&view, 640);
        // 50 mm at f/2 on 36 mm: 25 mm wide, 888.9 px away.
        for (z, diameter_px) in [(4.0, 0.0), (2.0, 5.5556), (8.0, 2.7778), (1.0, 16.6667)] {
            let seen = |lens: Vec2| {
                let [near, with_depth] = camera.parallax(lens);
                near / z + with_depth
            };
            let found = [Vec2::X, Vec2::Y].map(|side| seen(side).distance(seen(-side)));
            assert!(found.iter().all(|d| (d - diameter_px).abs() < 1e-3), "{z}: {found:?}");
            // The ray through the place where the point is seen comes from the lens to the point.
            let lens = Vec2::new(0.3, -0.8);
            let middle = Vec2::new(40.0, 25.0);
            let (eye, along) = camera.ray(middle.x, middle.y, 0.0, Vec2::ZERO);
            let point = eye + along * (z / along.dot(camera.forward));
            let at = middle + seen(lens);
            let (origin, direction) = camera.ray(at.x, at.y, 0.0, lens);
            let met = origin
                + direction
                    * ((point - origin).dot(camera.forward) / direction.dot(camera.forward));
            assert!(met.abs_diff_eq(point, 1e-5), "{z}: {met} {point}");
        }
    }
}
