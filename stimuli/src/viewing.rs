//! Viewing geometry: what an image and a motion in it are to the eye.

use serde::{Deserialize, Serialize};

/// How large the image appears to the participant.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Viewing {
    /// Visual angle that the image's width subtends, in degrees.
    pub image_width_deg: f64,
}

impl Viewing {
    /// Pixels per degree of visual angle of an image `width_px` wide. The angle is taken as
    /// proportional to the distance on the screen, as the thesis does (Navarro 2012, §5.4).
    pub fn pixels_per_degree(&self, width_px: u32) -> f64 {
        f64::from(width_px) / self.image_width_deg
    }
}
