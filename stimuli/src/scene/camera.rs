//! The description of the camera: its place, lens and motion.

use super::object::{dot, unit};
use serde::{Deserialize, Serialize};
use shutterlab_data_schema::definition::DefinitionError;

/// A camera: a pinhole, or a thin lens if it has an aperture.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Camera {
    /// Where the pinhole, or the lens, is; if it moves, when half of the sequence has passed.
    pub position_m: [f64; 3],
    /// The point in the centre of the image, at the same time.
    pub look_at_m: [f64; 3],
    /// Focal length of the lens.
    pub focal_length_mm: f64,
    /// Width of the sensor, which the image's width fills.
    pub sensor_width_mm: f64,
    /// Focal length over the diameter of the lens, which blurs what is out of focus; without it the camera is a
    /// pinhole. What is in the image and how large depends neither on it nor on the focus.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub aperture_f_number: Option<f64>,
    /// How far ahead the plane is that the lens is focused on; if nothing is said, as far as the point looked at
    /// is at the frame's time.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub focus_distance_m: Option<f64>,
    /// How it moves, if it does.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub motion: Option<CameraMotion>,
}

/// A motion of the camera. Both vectors are multiplied by the speed: a vector of length 1 moves at it.
/// The same for both is a tracking shot, the point's alone a pan.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CameraMotion {
    /// The speed; if nothing is said, the stimulus's.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub speed_m_per_s: Option<f64>,
    /// Motion of the pinhole, in metres per metre.
    #[serde(default)]
    pub position: [f64; 3],
    /// Motion of the point looked at, in metres per metre.
    #[serde(default)]
    pub look_at: [f64; 3],
}

impl Camera {
    /// Refuses values that make no picture; `file` is what an error calls the scene.
    pub(super) fn check(&self, file: &str) -> Result<(), DefinitionError> {
        let numbers = [
            ("camera.focal_length_mm", self.focal_length_mm),
            ("camera.sensor_width_mm", self.sensor_width_mm),
        ];
        for (field, value) in numbers {
            if !(1e-3..=1e6).contains(&value) {
                let allowed = "0.001 to 1000000 mm are allowed";
                return Err(DefinitionError::value(file, field, value, allowed));
            }
        }
        let lens = [
            ("camera.aperture_f_number", self.aperture_f_number, "f-numbers of 0.01 to 1000000"),
            ("camera.focus_distance_m", self.focus_distance_m, "0.01 to 1000000 m"),
        ];
        for (field, value, range) in lens {
            if let Some(value) = value.filter(|value| !(1e-2..=1e6).contains(value)) {
                let allowed = format!("{range} are allowed");
                return Err(DefinitionError::value(file, field, value, allowed));
            }
        }
        if let (None, Some(distance)) = (self.aperture_f_number, self.focus_distance_m) {
            let allowed = "only with camera.aperture_f_number: a pinhole has no focus";
            return Err(DefinitionError::value(file, "camera.focus_distance_m", distance, allowed));
        }
        super::check_point("camera.position_m", self.position_m, file)?;
        super::check_point("camera.look_at_m", self.look_at_m, file)?;
        if self.position_m == self.look_at_m {
            let (value, allowed) =
                (format!("{:?}", self.position_m), "another point than camera.look_at_m is needed");
            return Err(DefinitionError::value(file, "camera.position_m", value, allowed));
        }
        let Some(motion) = self.motion else { return Ok(()) };
        super::check_speed("camera.motion.speed_m_per_s", motion.speed_m_per_s, file)?;
        super::check_point("camera.motion.position", motion.position, file)?;
        super::check_point("camera.motion.look_at", motion.look_at, file)
    }

    /// Unit vector from the pinhole to the point it looks at.
    pub fn forward(&self) -> [f64; 3] {
        unit(std::array::from_fn(|i| self.look_at_m[i] - self.position_m[i]))
    }

    /// Unit vector towards the right of the image, which holds y up; of a camera that looks straight
    /// up or down it is x.
    pub fn right(&self) -> [f64; 3] {
        let [x, _, z] = std::array::from_fn(|i| self.look_at_m[i] - self.position_m[i]);
        let length = x.hypot(z);
        if length > 0.0 { [-z / length, 0.0, x / length] } else { [1.0, 0.0, 0.0] }
    }

    /// Distance from the pinhole to the point it looks at, in metres.
    pub fn look_at_distance_m(&self) -> f64 {
        let squares = (0..3).map(|i| (self.position_m[i] - self.look_at_m[i]).powi(2));
        squares.sum::<f64>().sqrt()
    }

    /// Radius of the lens in metres; 0 of a pinhole.
    pub fn lens_radius_m(&self) -> f64 {
        self.aperture_f_number.map_or(0.0, |f_number| 0.5e-3 * self.focal_length_mm / f_number)
    }

    /// Focal length in pixels of an image `width_px` wide.
    pub fn focal_length_px(&self, width_px: u32) -> f64 {
        self.focal_length_mm / self.sensor_width_mm * f64::from(width_px)
    }

    /// Pixels per metre, across the view, at the distance of the point it looks at.
    pub fn pixels_per_metre(&self, width_px: u32) -> f64 {
        self.focal_length_px(width_px) / self.look_at_distance_m()
    }

    /// How far `point` lies ahead of the pinhole, and how far to the right of the camera's axis, in
    /// metres.
    pub fn ahead_and_aside_m(&self, point: [f64; 3]) -> [f64; 2] {
        let offset = std::array::from_fn(|i| point[i] - self.position_m[i]);
        [dot(offset, self.forward()), dot(offset, self.right())]
    }
}
