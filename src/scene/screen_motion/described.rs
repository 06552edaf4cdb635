//! The motion of an object before a camera, by plain numbers.

use super::nearest_point::NearestPoint;
use super::{Instant, NEAR, ScreenPaths, camera_turn, steps_of, to_image};
use glam::{DAffine3, DQuat, DVec3};
use shutterlab_stimuli::scene::Camera;
use shutterlab_stimuli::stimulus::View;

/// An object, a camera and how they move. Lengths are in the mesh's unit, motions per shutter interval. Places
/// are those of half the window; the mesh is then where its file has it, and so are keyframes half way from the
/// first to the second, on a straight line that goes on before and after.
#[derive(Clone, Debug, PartialEq)]
pub struct Described {
    /// The camera, without a motion of its own, and how far it goes per shutter.
    pub view: View,
    /// Width of the image.
    pub width_px: u32,
    /// How far the object goes.
    pub translation: DVec3,
    /// How it turns, if it does. The axis goes along with the translation.
    pub turn: Option<Turn>,
    /// How many shutter intervals the window has, one after another; 1 or more.
    pub window: u32,
    /// What its speed is.
    pub rule: Rule,
}

/// A rotation by the right-hand rule.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Turn {
    /// The axis, of any length but 0.
    pub axis: DVec3,
    /// A point of the axis.
    pub through: DVec3,
    /// Radians.
    pub angle: f64,
}

/// What the speed of a point is over a time window.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Rule {
    /// The shortest path that it sweeps in any shutter interval of the window.
    #[default]
    Least,
    /// Appendix B of Zhang et al. 2014: translations along the view do not count, and what turns about an axis
    /// that is not parallel to the view has the speed that it has where it is nearest to the viewer. The paper
    /// takes this for the least speed of the turn; it is near the greatest.
    AppendixB,
}

impl Described {
    /// The paths over the image. They are finite for any finite numbers.
    pub fn paths(&self) -> ScreenPaths {
        let flattened;
        let described = match self.rule {
            Rule::Least => self,
            Rule::AppendixB => {
                flattened = self.without_depth();
                &flattened
            }
        };
        let paths = described.sampled();
        let nearest = match (self.rule, self.turn) {
            (Rule::AppendixB, Some(turn)) => NearestPoint::new(described, &turn),
            _ => None,
        };
        ScreenPaths { nearest, ..paths }
    }

    fn sampled(&self) -> ScreenPaths {
        let angle = self.turn.map_or(0.0, |turn| turn.angle.abs()) + camera_turn(&self.view);
        let steps = steps_of(angle);
        let count = steps * self.window.max(1) as usize;
        let instants = (0..=count).map(|k| {
            let time = (k as f64 - 0.5 * count as f64) / steps as f64;
            Instant { to_image: self.to_image(time).as_affine3a(), pose: (0.5 + time) as f32 }
        });
        let near = NEAR * self.view.camera.look_at_distance_m();
        ScreenPaths::new(vec![instants.collect()], 0, steps, near)
    }

    /// Takes a point of the object to (x·z, y·z, z), `time` shutters after half the window: x and y in pixels from
    /// the centre of the image, to the right and downwards; z the distance along the view.
    pub fn to_image(&self, time: f64) -> DAffine3 {
        let moved = DAffine3::from_translation(self.translation * time);
        let turned = self.turn.map_or(DAffine3::IDENTITY, |Turn { axis, through, angle }| {
            let turned = DQuat::from_axis_angle(axis.normalize_or(DVec3::Y), angle * time);
            DAffine3::from_translation(through)
                * DAffine3::from_quat(turned)
                * DAffine3::from_translation(-through)
        });
        to_image(&self.view, self.width_px, time) * moved * turned
    }

    /// The same without what goes along the view.
    fn without_depth(&self) -> Self {
        let forward = DVec3::from(self.view.camera.forward());
        let across = |v: DVec3| v - forward * forward.dot(v);
        let travel_m = self.view.travel_m.map(|travel| across(travel.into()).into());
        Self {
            view: View { travel_m, ..self.view.clone() },
            translation: across(self.translation),
            ..self.clone()
        }
    }
}

/// A camera that looks along −z at `middle`, so far away that a sphere of `radius` about it touches the borders
/// of the image, the upper and lower ones of one wider than high. `field_of_view_deg` is that of the image's
/// height, as `gluPerspective` has it: the paper's images are 800×600 with 33.33°.
pub fn framing(middle: DVec3, radius: f64, size_px: [u32; 2], field_of_view_deg: f64) -> Camera {
    let camera = camera(middle + DVec3::Z, middle, size_px, field_of_view_deg);
    let [width, height] = size_px.map(f64::from);
    let half_angle = (0.5 * width.min(height) / camera.focal_length_px(size_px[0])).atan();
    let position_m = (middle + DVec3::Z * (radius / half_angle.sin())).into();
    Camera { position_m, ..camera }
}

/// The camera at `position` that looks at `look_at`; the field of view is as in [`framing`].
pub fn camera(
    position: DVec3,
    look_at: DVec3,
    [width, height]: [u32; 2],
    field_of_view_deg: f64,
) -> Camera {
    // 36 mm is the width of the usual film; only the ratio matters.
    let sensor_width_mm = 36.0;
    let focal_length_px = 0.5 * f64::from(height) / (0.5 * field_of_view_deg.to_radians()).tan();
    Camera {
        position_m: position.into(),
        look_at_m: look_at.into(),
        focal_length_mm: sensor_width_mm * focal_length_px / f64::from(width),
        sensor_width_mm,
        aperture_f_number: None,
        focus_distance_m: None,
        motion: None,
    }
}
