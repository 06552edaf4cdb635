//! How large a triangle may be seen: the perimeter that the level-of-detail law allows at a speed.

use super::SimplifyError;
use super::direction::Seen;
use shutterlab_data_schema::fitted::{FrequencyUnit, LevelOfDetailLaw, VelocityUnit};

/// The largest perimeter of a triangle on the screen: `slope`·v + `intercept_px`, in pixels, where v is the
/// screen velocity in pixels per shutter. It is 1/ρ of Eq. 8 of Zhang et al. 2014, in pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PerimeterLimit {
    /// Pixels of perimeter per pixel per shutter of speed; 0 or more.
    pub slope: f32,
    /// Perimeter at rest, in pixels; 0 or more.
    pub intercept_px: f32,
}

/// What turns pixels and shutters into the units that a law may be in.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Viewing {
    /// Pixels of the image per degree of visual angle.
    pub pixels_per_degree: Option<f64>,
    /// How long the shutter is open, in seconds.
    pub shutter_seconds: Option<f64>,
}

impl PerimeterLimit {
    /// The limit of `law`. What `viewing` tells is asked for only where a unit of the law needs it.
    ///
    /// # Formula
    /// ```text
    /// perimeter = 1/ρ = σ₁·v + σ₂, in the unit of ρ, with v in its own
    /// v in deg/shutter = v in px/shutter ÷ px per deg; in deg/s moreover ÷ shutter time
    /// perimeter in px = perimeter in deg · px per deg
    /// ```
    ///
    /// # Errors
    /// Pixels per degree (0.001 to 1000000) or the shutter time (10⁻⁹ to 10⁶ s) is needed and missing, or out
    /// of range.
    pub fn from_law(law: &LevelOfDetailLaw, viewing: Viewing) -> Result<Self, SimplifyError> {
        let px_per_deg = || {
            let units = [law.velocity_unit.symbol(), law.frequency_unit.symbol()].join(" and ");
            needed("pixels per degree", viewing.pixels_per_degree, [1e-3, 1e6], &units)
        };
        let shutter = || {
            let unit = law.velocity_unit.symbol();
            needed("shutter time in seconds", viewing.shutter_seconds, [1e-9, 1e6], unit)
        };
        let velocity_per_px = match law.velocity_unit {
            VelocityUnit::PixelsPerShutter => 1.0,
            VelocityUnit::DegreesPerShutter => 1.0 / px_per_deg()?,
            VelocityUnit::DegreesPerSecond => 1.0 / (px_per_deg()? * shutter()?),
        };
        let px_per_perimeter = match law.frequency_unit {
            FrequencyUnit::PerPerimeterPixel => 1.0,
            FrequencyUnit::PerPerimeterDegree => px_per_deg()?,
        };
        Ok(Self {
            slope: (law.sigma_1.value * velocity_per_px * px_per_perimeter) as f32,
            intercept_px: (law.sigma_2.value * px_per_perimeter) as f32,
        })
    }

    /// The largest perimeter in pixels at a speed in pixels per shutter.
    pub fn at(&self, speed_px: f32) -> f32 {
        self.slope * speed_px + self.intercept_px
    }
}

/// `value`, which a law in `units` needs.
fn needed(
    field: &'static str,
    value: Option<f64>,
    [low, high]: [f64; 2],
    units: &str,
) -> Result<f64, SimplifyError> {
    value.filter(|value| (low..=high).contains(value)).ok_or_else(|| {
        let found = value.map_or("missing".into(), |value| value.to_string());
        let allowed = format!("the law is in {units}, which needs {low} to {high}");
        SimplifyError::value(field, found, allowed)
    })
}

/// The perimeter of a triangle as seen at its largest, in pixels.
pub fn perimeter_px(corners: &[Seen; 3]) -> f32 {
    let length = |a: usize, b: usize| corners[a].position_px.distance(corners[b].position_px);
    let magnification = corners.iter().map(|corner| corner.magnification).fold(1.0, f32::max);
    (length(0, 1) + length(1, 2) + length(2, 0)) * magnification
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec2;

    /// The paper's display: 86.27 dpi at half a metre.
    fn papers_display() -> Viewing {
        let pixel_m = 0.0254 / 86.27;
        let pixels_per_degree = 1.0 / f64::atan(pixel_m / 0.5).to_degrees();
        Viewing { pixels_per_degree: Some(pixels_per_degree), shutter_seconds: Some(1.0 / 60.0) }
    }

    fn limit(velocity_unit: VelocityUnit, frequency_unit: FrequencyUnit) -> PerimeterLimit {
        let law = LevelOfDetailLaw { velocity_unit, frequency_unit, ..LevelOfDetailLaw::PUBLISHED };
        PerimeterLimit::from_law(&law, papers_display()).unwrap()
    }

    #[test]
    fn the_published_law_needs_no_viewing_geometry() {
        let limit = PerimeterLimit::from_law(&LevelOfDetailLaw::PUBLISHED, Viewing::default());
        assert_eq!(limit, Ok(PerimeterLimit { slope: 7.3, intercept_px: 0.36 }));
        assert!((limit.unwrap().at(270.0) - 1971.36).abs() < 1e-3);
    }

    /// Perimeters at the paper's four speeds, computed by hand: with velocities in degrees per shutter
    /// 2.8, 7.7, 22 and 67 px.
    #[test]
    fn units_are_turned_into_pixels() {
        let (by_pixel, by_degree) =
            (FrequencyUnit::PerPerimeterPixel, FrequencyUnit::PerPerimeterDegree);
        let per_shutter = limit(VelocityUnit::DegreesPerShutter, by_pixel);
        for (speed, perimeter) in [(10.0, 2.8), (30.0, 7.7), (90.0, 22.5), (270.0, 66.9)] {
            assert!((per_shutter.at(speed) - perimeter).abs() < 0.05, "{speed}");
        }
        let near = |a: f32, b: f32| (a - b).abs() < 1e-5 * b;
        let per_second = limit(VelocityUnit::DegreesPerSecond, by_pixel);
        assert!(near(per_second.slope, 60.0 * per_shutter.slope));
        assert_eq!(per_second.intercept_px, per_shutter.intercept_px);
        // In degrees both sides scale alike: the slope has no unit, the intercept is an angle.
        let in_degrees = limit(VelocityUnit::DegreesPerShutter, by_degree);
        assert!(near(in_degrees.slope, 7.3));
        assert!(near(in_degrees.intercept_px, 0.36 * 29.6397), "{in_degrees:?}");
    }

    #[test]
    fn what_a_unit_needs_is_asked_for() {
        let message = |velocity_unit, viewing| {
            let law = LevelOfDetailLaw { velocity_unit, ..LevelOfDetailLaw::PUBLISHED };
            PerimeterLimit::from_law(&law, viewing).unwrap_err().to_string()
        };
        let known = papers_display();
        for (found, expected) in [
            (
                message(VelocityUnit::DegreesPerShutter, Viewing::default()),
                "pixels per degree: missing: the law is in deg/shutter and 1/px of perimeter, which \
                 needs 0.001 to 1000000",
            ),
            (
                message(
                    VelocityUnit::DegreesPerSecond,
                    Viewing { shutter_seconds: Some(0.0), ..known },
                ),
                "shutter time in seconds: 0: the law is in deg/s, which needs 0.000000001 to 1000000",
            ),
            (
                message(
                    VelocityUnit::DegreesPerSecond,
                    Viewing { pixels_per_degree: Some(f64::NAN), ..known },
                ),
                "pixels per degree: NaN: the law is in deg/s and 1/px of perimeter, which needs \
                 0.001 to 1000000",
            ),
        ] {
            assert_eq!(found, expected);
        }
    }

    #[test]
    fn a_perimeter_counts_at_its_largest() {
        let corner = |x, y, magnification| Seen {
            position_px: Vec2::new(x, y),
            magnification,
            ..Seen::default()
        };
        let corners = [corner(0.0, 0.0, 1.0), corner(3.0, 0.0, 2.0), corner(0.0, 4.0, 1.5)];
        assert_eq!(perimeter_px(&corners), 24.0);
    }
}
