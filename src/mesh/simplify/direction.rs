//! How an edge's direction weighs its cost: Eq. 4 of Zhang et al. 2014, as printed and mirrored.
//!
//! α is the angle on the screen between the edge and the motion. As printed,
//! f(α) = 1 − (1 − cos α)^r + ε is 1 + ε along the motion and ε across it, so that edges across the motion
//! go first; f(90° − α), the mirror, is what the paper's words and its Fig. 2 (c) describe: what varies
//! along the motion goes first, what varies across it stays.

use super::SimplifyError;
use glam::{Vec2, Vec3};

/// How the cost of an edge depends on its direction.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Weight {
    /// Not at all.
    #[default]
    Isotropic,
    /// f(α) of Eq. 4 as printed: edges across the motion are cheap.
    Printed {
        /// The exponent r, 0 or more. With 0 all directions weigh alike.
        r: f32,
        /// The constant ε, 0 or more, and above 0 if r is 0.
        epsilon: f32,
    },
    /// f(90° − α): edges along the motion are cheap.
    Mirrored {
        /// The exponent r, 0 or more. With 0 all directions weigh alike.
        r: f32,
        /// The constant ε, 0 or more, and above 0 if r is 0.
        epsilon: f32,
    },
}

/// A point of the object as the camera sees it. Pixels; y downwards, as in the image.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Seen {
    /// Where it is in the image in the middle of the time window.
    pub position_px: Vec2,
    /// How far it goes there while the shutter is open.
    pub velocity_px: Vec2,
    /// The least speed during the time window, in pixels per shutter.
    pub speed_px: f32,
    /// The largest size at which a small piece about the point is seen during the time window, over its
    /// size in the middle. 1 or more.
    pub magnification: f32,
}

/// Where the points of an object are seen and how they move.
pub trait ScreenMotion: Sync {
    /// The point that is at `keyframes[0]` of the object's space as the mesh's first keyframe has it, and at
    /// `keyframes[1]` in its second; both are the same where the mesh does not deform. All values are
    /// finite, whatever the point.
    fn seen(&self, keyframes: [Vec3; 2]) -> Seen;
}

impl Weight {
    /// Refuses parameters without a meaning.
    ///
    /// # Errors
    /// r or ε is not finite or negative, or both are 0, which would make every cost 0.
    pub fn check(self) -> Result<(), SimplifyError> {
        let (Self::Printed { r, epsilon } | Self::Mirrored { r, epsilon }) = self else {
            return Ok(());
        };
        for (field, value) in [("r", r), ("epsilon", epsilon)] {
            if !(value.is_finite() && value >= 0.0) {
                return Err(SimplifyError::value(
                    field,
                    value,
                    "finite numbers from 0 are allowed",
                ));
            }
        }
        if r == 0.0 && epsilon == 0.0 {
            let allowed = "above 0 where r is 0, or every cost would be 0";
            return Err(SimplifyError::value("epsilon", epsilon, allowed));
        }
        Ok(())
    }

    /// The factor of the cost of an edge whose angle to the motion has the cosine `cosine` ∈ [0, 1].
    ///
    /// # Formula
    /// ```text
    /// f(α) = 1 − (1 − cos α)^r + ε        mirrored: f(90° − α); r = 0: ε, as 0⁰ is taken as 1
    /// ```
    pub fn factor(self, cosine: f32) -> f32 {
        let f = |cosine: f32, r: f32, epsilon: f32| 1.0 - (1.0 - cosine).powf(r) + epsilon;
        match self {
            Self::Isotropic => 1.0,
            Self::Printed { r, epsilon } => f(cosine, r, epsilon),
            Self::Mirrored { r, epsilon } => f((1.0 - cosine * cosine).max(0.0).sqrt(), r, epsilon),
        }
    }

    /// Whether all directions weigh alike.
    pub fn is_isotropic(self) -> bool {
        match self {
            Self::Isotropic => true,
            Self::Printed { r, .. } | Self::Mirrored { r, .. } => r == 0.0,
        }
    }

    /// The factor of the edge between two points. Where an edge is seen as a point, or nothing moves, there is
    /// no angle: such an edge costs the most that any does.
    pub(super) fn of_edge(self, a: &Seen, b: &Seen) -> f32 {
        if self.is_isotropic() {
            return 1.0;
        }
        let edge = b.position_px - a.position_px;
        let motion = a.velocity_px + b.velocity_px;
        let lengths = edge.length() * motion.length();
        if lengths > 0.0 {
            self.factor((edge.dot(motion).abs() / lengths).min(1.0))
        } else {
            self.factor(0.0).max(self.factor(1.0))
        }
    }
}
