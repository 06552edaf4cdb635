//! Viewing geometry: what an image and a motion in it are to the eye.

use serde::{Deserialize, Serialize};
use shutterlab_data_schema::definition::DefinitionError;

/// How large the image appears to the participant: by the angle it subtends, or by the display it is
/// shown on, pixel for pixel.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Viewing {
    /// Visual angle that the image's width subtends, in degrees.
    pub image_width_deg: Option<f64>,
    /// The display, in place of the angle.
    pub display: Option<Display>,
}

/// A flat display, looked at in the middle and at a right angle.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Display {
    /// Width of the picture.
    pub width_cm: f64,
    /// Columns and rows of pixels, which are square.
    pub resolution_px: [u32; 2],
    /// Distance of the eyes.
    pub distance_cm: f64,
    /// Luminance of white.
    pub white_luminance_cd_m2: Option<f64>,
    /// Exponent from code value to luminance.
    pub gamma: Option<f64>,
}

impl Viewing {
    /// Visual angle that an image `width_px` wide subtends, in degrees. A grid that was checked has it.
    pub fn image_width_deg(&self, width_px: u32) -> f64 {
        let by_display = |display: &Display| {
            let width_cm =
                display.width_cm / f64::from(display.resolution_px[0]) * f64::from(width_px);
            2.0 * (0.5 * width_cm / display.distance_cm).atan().to_degrees()
        };
        self.image_width_deg.or(self.display.as_ref().map(by_display)).unwrap_or(f64::NAN)
    }

    /// Pixels per degree of visual angle of an image `width_px` wide. The angle is taken as
    /// proportional to the distance on the screen, as the thesis does (Navarro 2012, §5.4).
    pub fn pixels_per_degree(&self, width_px: u32) -> f64 {
        f64::from(width_px) / self.image_width_deg(width_px)
    }

    /// Refuses a geometry that nobody can sit in; `file` is what an error calls the grid.
    ///
    /// # Errors
    /// The first field that does not fit, by name.
    pub(crate) fn check(&self, file: &str) -> Result<(), DefinitionError> {
        let refuse = |field: &str, value: String, allowed: &str| {
            Err(DefinitionError::value(file, format!("viewing{field}"), value, allowed))
        };
        let display = match (&self.image_width_deg, &self.display) {
            (Some(degrees), None) if (0.01..=180.0).contains(degrees) => return Ok(()),
            (Some(degrees), None) => {
                let allowed = "0.01 to 180 degrees are allowed";
                return refuse(".image_width_deg", degrees.to_string(), allowed);
            }
            (None, Some(display)) => display,
            (both, _) => {
                let found = if both.is_some() { "both" } else { "neither" };
                return refuse("", found.into(), "either image_width_deg or display is needed");
            }
        };
        let numbers = [
            (".display.width_cm", Some(display.width_cm), 1.0..=1000.0),
            (".display.distance_cm", Some(display.distance_cm), 1.0..=10000.0),
            (".display.white_luminance_cd_m2", display.white_luminance_cd_m2, 1.0..=100_000.0),
            (".display.gamma", display.gamma, 0.1..=10.0),
        ];
        for (field, value, allowed) in numbers {
            if let Some(value) = value.filter(|value| !allowed.contains(value)) {
                let allowed = format!("{} to {} is allowed", allowed.start(), allowed.end());
                return refuse(field, value.to_string(), &allowed);
            }
        }
        if let Some(side) = display.resolution_px.iter().find(|s| !(1..=100_000).contains(*s)) {
            let allowed = "1 to 100000 pixels are allowed";
            return refuse(".display.resolution_px", side.to_string(), allowed);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn display() -> Display {
        Display {
            width_cm: 50.0,
            resolution_px: [2000, 1000],
            distance_cm: 57.3,
            white_luminance_cd_m2: Some(120.0),
            gamma: Some(2.2),
        }
    }

    /// At 57.3 cm a centimetre is a degree; here 40 pixels are one.
    #[test]
    fn a_display_gives_the_angle() {
        let viewing = Viewing { image_width_deg: None, display: Some(display()) };
        assert!((viewing.image_width_deg(40) - 1.0).abs() < 1e-3);
        assert!((viewing.pixels_per_degree(40) - 40.0).abs() < 0.04);
        // The wide image subtends less than its width in centimetres.
        assert!((viewing.image_width_deg(2000) - 47.14).abs() < 0.01);
    }

    #[test]
    fn a_geometry_is_given_once_and_within_reason() {
        let check = |viewing: Viewing| viewing.check("g.toml").map_err(|e| e.to_string());
        let given = |image_width_deg, display| Viewing { image_width_deg, display };
        assert!(check(given(Some(14.4), None)).is_ok());
        assert!(check(given(None, Some(display()))).is_ok());
        let error = check(given(Some(14.4), Some(display()))).unwrap_err();
        assert!(error.starts_with("g.toml: viewing: both: either"), "{error}");
        assert!(check(given(None, None)).unwrap_err().contains("viewing: neither"));
        let far = Display { distance_cm: 0.0, ..display() };
        let error = check(given(None, Some(far))).unwrap_err();
        assert!(error.contains("viewing.display.distance_cm: 0: 1 to 10000"), "{error}");
    }
}
