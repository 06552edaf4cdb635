//! The shutter: which instants of its interval a sample sees. The profile is what the shutter lets
//! through over the interval, from opening to closing; instants are drawn in proportion to it, so every
//! sample weighs the same.

use shutterlab_stimuli::stimulus::ShutterProfile;

/// The profile as both devices read it: its kind, and what the kind needs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shutter {
    /// [`Shutter::BOX`], [`Shutter::TRAPEZOID`] or [`Shutter::GAUSSIAN`].
    pub kind: u32,
    /// Trapezoid: the ramp on either side, as part of the interval. Gaussian: √2·σ.
    pub width: f32,
    /// Gaussian: erf(½/width), the part of the curve that lies within the interval.
    pub reach: f32,
}

impl Shutter {
    /// Open at once, closed at once.
    pub const BOX: u32 = 0;
    /// Opens and closes linearly.
    pub const TRAPEZOID: u32 = 1;
    /// A Gaussian, cut off at the ends of the interval.
    pub const GAUSSIAN: u32 = 2;

    /// The shutter of `profile`.
    pub fn new(profile: ShutterProfile) -> Self {
        match profile {
            ShutterProfile::Box {} => Self { kind: Self::BOX, width: 0.0, reach: 0.0 },
            ShutterProfile::Trapezoid { ramp_fraction } => {
                Self { kind: Self::TRAPEZOID, width: ramp_fraction as f32, reach: 0.0 }
            }
            ShutterProfile::Gaussian { sigma_fraction } => {
                let width = std::f64::consts::SQRT_2 * sigma_fraction;
                let reach = libm::erf(0.5 / width) as f32;
                Self { kind: Self::GAUSSIAN, width: width as f32, reach }
            }
        }
    }

    /// The instant in [−½, ½] of the interval that `u` ∈ [0, 1) draws.
    pub fn instant(&self, u: f32) -> f32 {
        match self.kind {
            Self::TRAPEZOID => {
                let ramp = self.width;
                let from_end = u.min(1.0 - u);
                // Within a ramp the mass grows as t²/(2r(1 − r)), between the ramps as t − r/2.
                let in_ramp = (2.0 * ramp * (1.0 - ramp) * from_end).sqrt();
                let between = from_end * (1.0 - ramp) + 0.5 * ramp;
                let t = if in_ramp < ramp { in_ramp } else { between };
                if u < 0.5 { t - 0.5 } else { 0.5 - t }
            }
            // Where the curve's tails are cut off to nothing, the ends are not to be told from ±∞.
            Self::GAUSSIAN => (self.width * erf_inv(self.reach * (2.0 * u - 1.0))).clamp(-0.5, 0.5),
            _ => u - 0.5,
        }
    }
}

/// The inverse error function to 4·10⁻⁶ for |x| < 1 (Giles, *Approximating the erfinv function*, GPU
/// Computing Gems 2, 2011; single precision).
fn erf_inv(x: f32) -> f32 {
    let w = -((1.0 - x) * (1.0 + x)).max(1e-30).ln();
    let p = if w < 5.0 {
        let w = w - 2.5;
        let p = 2.810_226_4e-8 * w + 3.432_739_4e-7;
        let p = (p * w - 3.523_387_7e-6) * w - 4.391_506_5e-6;
        let p = (p * w + 2.185_808_7e-4) * w - 1.253_725e-3;
        let p = (p * w - 4.177_681_6e-3) * w + 0.246_640_73;
        p * w + 1.501_409_4
    } else {
        let w = w.sqrt() - 3.0;
        let p = -2.002_142_6e-4 * w + 1.009_505_6e-4;
        let p = (p * w + 1.349_343_2e-3) * w - 3.673_428_4e-3;
        let p = (p * w + 5.739_507_7e-3) * w - 7.622_461_3e-3;
        let p = (p * w + 9.438_870_5e-3) * w + 1.001_674;
        p * w + 2.832_976_8
    };
    p * x
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Share of the interval's light that comes before `t` ∈ [−½, ½], by the formulas of the profiles.
    fn share(profile: ShutterProfile, t: f64) -> f64 {
        match profile {
            ShutterProfile::Box {} => t + 0.5,
            ShutterProfile::Trapezoid { ramp_fraction: r } => {
                let height = 1.0 / (1.0 - r);
                let from_end = 0.5 - t.abs();
                let tail = if from_end < r {
                    0.5 * height * from_end * from_end / r
                } else {
                    height * (from_end - 0.5 * r)
                };
                if t < 0.0 { tail } else { 1.0 - tail }
            }
            ShutterProfile::Gaussian { sigma_fraction } => {
                let erf = |t: f64| libm::erf(t / (std::f64::consts::SQRT_2 * sigma_fraction));
                0.5 + 0.5 * erf(t) / erf(0.5)
            }
        }
    }

    /// The instants follow their profile: the share of the light before the instant drawn by u is u.
    #[test]
    fn instants_are_drawn_by_the_profile() {
        for profile in [
            ShutterProfile::Box {},
            ShutterProfile::Trapezoid { ramp_fraction: 0.01 },
            ShutterProfile::Trapezoid { ramp_fraction: 0.3 },
            ShutterProfile::Trapezoid { ramp_fraction: 0.5 },
            ShutterProfile::Gaussian { sigma_fraction: 0.05 },
            ShutterProfile::Gaussian { sigma_fraction: 0.2 },
            ShutterProfile::Gaussian { sigma_fraction: 2.0 },
        ] {
            let shutter = Shutter::new(profile);
            for end in [0.0, 1.0 - f32::EPSILON / 2.0] {
                assert!(shutter.instant(end).abs() <= 0.5, "{profile:?} {end}");
            }
            for step in 0..1000 {
                let u = (step as f32 + 0.5) / 1000.0;
                let t = shutter.instant(u);
                assert!(t.abs() <= 0.5, "{profile:?}: {t}");
                let found = share(profile, f64::from(t));
                assert!((found - f64::from(u)).abs() < 2e-6, "{profile:?} {u}: {found}");
            }
        }
    }
}
