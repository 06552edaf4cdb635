//! How visible detail is that moves over the retina: the spatiovelocity contrast sensitivity of Kelly (1979) and
//! Daly (1998).
//!
//! Spatial frequencies are in cycles per degree of visual angle, velocities in degrees per second **on the
//! retina**: what the eye pursues moves little there, see [`retinal_velocity`]. A grating is seen if its contrast is
//! above the reciprocal of the sensitivity, so that no grating is where the sensitivity is below 1.

use std::f64::consts::PI;

/// The slowest motion over the retina that there is, the eye's own drift (Daly 1998). At 0 Kelly's function would
/// be 0 at every frequency.
pub const LEAST_VELOCITY: f64 = 0.1;

/// Sensitivity to contrast as a function of spatial frequency and retinal velocity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContrastSensitivity {
    /// Scale of the sensitivity.
    pub c0: f64,
    /// Scale of the spatial frequency.
    pub c1: f64,
    /// Scale of the velocity.
    pub c2: f64,
}

impl ContrastSensitivity {
    /// As Kelly measured it, with the image held still on the retina but for the motion shown.
    pub const KELLY_1979: Self = Self { c0: 1.0, c1: 1.0, c2: 1.0 };

    /// As Daly fitted it to eyes that look freely at a display. Zhang et al. (2014) print these constants.
    pub const DALY_1998: Self = Self { c0: 1.14, c1: 0.67, c2: 1.7 };

    /// The sensitivity at a spatial frequency of 0 or more.
    ///
    /// # Formula
    /// Eqs. 5–7 of Zhang et al. (2014), where the logarithm has to be that to base 10:
    /// ```text
    /// CSF(ρ, v) = k·c₀·c₂·v·(2πρc₁)²·exp(−4πc₁ρ/ρ_max)
    /// k = 6.1 + 7.3·|log₁₀(c₂v/3)|³
    /// ρ_max = 45.9/(c₂v + 2)
    /// ```
    /// Velocities below [`LEAST_VELOCITY`] count as that.
    pub fn at(&self, frequency: f64, velocity: f64) -> f64 {
        let v = self.c2 * velocity.max(LEAST_VELOCITY);
        let k = 6.1 + 7.3 * (v / 3.0).log10().abs().powi(3);
        let radians = 2.0 * PI * self.c1 * frequency;
        self.c0 * k * v * radians * radians * (-2.0 * radians * (v + 2.0) / 45.9).exp()
    }

    /// The spatial frequency at which the sensitivity is greatest: ρ_max/(2πc₁).
    pub fn peak_frequency(&self, velocity: f64) -> f64 {
        let v = self.c2 * velocity.max(LEAST_VELOCITY);
        45.9 / ((v + 2.0) * 2.0 * PI * self.c1)
    }

    /// The highest spatial frequency that is seen with at least this `sensitivity`, above 0; none if no frequency
    /// is.
    pub fn limit_frequency(&self, sensitivity: f64, velocity: f64) -> Option<f64> {
        let is_seen = |frequency| self.at(frequency, velocity) >= sensitivity;
        let mut seen = self.peak_frequency(velocity);
        if !is_seen(seen) {
            return None;
        }
        // Beyond its peak the sensitivity falls for ever.
        let mut unseen = 2.0 * seen;
        while is_seen(unseen) {
            unseen *= 2.0;
        }
        // Halving a double's digits away.
        for _ in 0..60 {
            let middle = 0.5 * (seen + unseen);
            *(if is_seen(middle) { &mut seen } else { &mut unseen }) = middle;
        }
        Some(seen)
    }
}

/// Velocity over the retina of what moves at `velocity` before an eye that pursues it (Daly 1998): the eye
/// follows 82 % of it, up to 80 degrees per second, and drifts by 0.15.
pub fn retinal_velocity(velocity: f64) -> f64 {
    (velocity - (0.82 * velocity + 0.15).min(80.0)).abs().max(LEAST_VELOCITY)
}

#[cfg(test)]
mod tests {
    use super::*;

    const KELLY: ContrastSensitivity = ContrastSensitivity::KELLY_1979;
    const DALY: ContrastSensitivity = ContrastSensitivity::DALY_1998;
    const VELOCITIES: [f64; 4] = [0.15, 1.0, 3.0, 10.0];

    /// Peaks by hand from the published formulas.
    #[test]
    fn the_peaks_are_where_the_formulas_have_them() {
        let kelly = [(3.398, 205.0), (2.435, 218.0), (1.461, 209.0), (0.609, 141.0)];
        let daly = [(4.835, 245.0), (2.947, 250.0), (1.536, 203.0), (0.574, 141.0)];
        for (eye, peaks) in [(KELLY, kelly), (DALY, daly)] {
            for (velocity, (frequency, sensitivity)) in VELOCITIES.into_iter().zip(peaks) {
                let peak = eye.peak_frequency(velocity);
                assert!((peak - frequency).abs() < 6e-4, "{velocity}: {peak}");
                let found = eye.at(peak, velocity);
                assert!((found - sensitivity).abs() < 1.0, "{velocity}: {found}");
                assert!(eye.at(0.99 * peak, velocity) < found);
                assert!(eye.at(1.01 * peak, velocity) < found);
            }
        }
    }

    #[test]
    fn the_limit_is_beyond_the_peak_and_has_the_sensitivity() {
        for velocity in VELOCITIES {
            for sensitivity in [1.0, 10.0, 100.0] {
                let limit = DALY.limit_frequency(sensitivity, velocity).unwrap();
                assert!(limit > DALY.peak_frequency(velocity));
                assert!((DALY.at(limit, velocity) / sensitivity - 1.0).abs() < 1e-9);
            }
        }
        assert_eq!(DALY.limit_frequency(1e4, 3.0), None);
        assert_eq!(DALY.limit_frequency(1.0, f64::NAN), DALY.limit_frequency(1.0, 0.0));
        assert_eq!(DALY.limit_frequency(1.0, f64::INFINITY), None);
    }

    /// The faster it moves over the retina, the coarser what can be seen has to be.
    #[test]
    fn detail_vanishes_with_velocity() {
        let limits = (1..=40).map(|v| DALY.limit_frequency(1.0, f64::from(v)).unwrap());
        assert!(limits.collect::<Vec<_>>().is_sorted_by(|slow, fast| slow > fast));
    }

    #[test]
    fn nothing_rests_on_the_retina() {
        assert_eq!(DALY.at(2.0, 0.0), DALY.at(2.0, LEAST_VELOCITY));
        assert_eq!(DALY.at(0.0, 3.0), 0.0);
        // At rest the eye drifts by 0.15; it keeps up with 0.18 of what it follows; above 97.4 it is left behind.
        assert!((retinal_velocity(0.0) - 0.15).abs() < 1e-12);
        assert!((retinal_velocity(10.0) - 1.65).abs() < 1e-12);
        assert!((retinal_velocity(200.0) - 120.0).abs() < 1e-12);
    }
}
