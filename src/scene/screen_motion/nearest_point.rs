//! Appendix B's rule for what turns about an axis that is not parallel to the view.

use super::described::{Described, Turn};
use super::{project, to_image};
use glam::{Affine3A, DVec3, Vec3, Vec3A};

/// Half the time over which a speed is taken, in shutters.
const HALF: f64 = 1.0 / 64.0;

/// The sine of the smallest angle to the view at which an axis is not parallel to it.
const PARALLEL: f64 = 1e-3;

/// Tells the speed of each point where the turn takes it nearest to the viewer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct NearestPoint {
    /// World to image shortly before and shortly after.
    to_image: [Affine3A; 2],
    /// A point of the axis.
    through: Vec3A,
    /// Unit vector along it.
    axis: Vec3A,
    /// Unit vector at a right angle to the axis, towards the viewer as far as can be.
    towards: Vec3A,
    /// How far the object goes from before to after.
    translation: Vec3A,
    /// How far a point at distance 1 from the axis goes meanwhile, where it is nearest.
    turn: Vec3A,
}

impl NearestPoint {
    /// None where the axis is parallel to the view: then no point of a circle is nearer than another.
    pub(super) fn new(described: &Described, turn: &Turn) -> Option<Self> {
        let axis = turn.axis.normalize_or(DVec3::Y);
        let forward = DVec3::from(described.view.camera.forward());
        let towards = axis * axis.dot(forward) - forward;
        if towards.length() <= PARALLEL {
            return None;
        }
        let towards = towards.normalize();
        let at = |time| to_image(&described.view, described.width_px, time).as_affine3a();
        Some(Self {
            to_image: [at(-HALF), at(HALF)],
            through: turn.through.as_vec3a(),
            axis: axis.as_vec3a(),
            towards: towards.as_vec3a(),
            translation: (described.translation * 2.0 * HALF).as_vec3a(),
            turn: (axis.cross(towards) * turn.angle * 2.0 * HALF).as_vec3a(),
        })
    }

    /// The speed of the point half way between these keyframes; 0 where it is nearer than `near`.
    pub(super) fn speed_px(&self, [start, end]: [Vec3; 2], near: f32) -> f32 {
        let from_axis = Vec3A::from(start).midpoint(end.into()) - self.through;
        let along = self.axis * self.axis.dot(from_axis);
        let radius = (from_axis - along).length();
        let nearest = self.through + along + self.towards * radius;
        let way =
            self.translation + self.turn * radius + Vec3A::from(end - start) * 2.0 * HALF as f32;
        let [before, after] = self.to_image;
        let before = before.transform_point3a(nearest - 0.5 * way);
        let after = after.transform_point3a(nearest + 0.5 * way);
        if before.is_finite() && after.is_finite() && before.z.min(after.z) > near {
            project(before).distance(project(after)) / (2.0 * HALF as f32)
        } else {
            0.0
        }
    }
}
