//! Objects of a scene during one frame: where each is at an instant of the shutter interval, and where a
//! ray meets a sphere or a plane. Motion is rigid and exact: what turns goes along arcs, because rays are
//! brought into the object's own space at their own instant.

use crate::sampling::warp::sin_cos_turns;
use bytemuck::{Pod, Zeroable};
use glam::{DMat3, DQuat, DVec3, Mat3, Vec3, Vec4};
use shutterlab_stimuli::Stimulus;
use shutterlab_stimuli::scene::{self, Shape};
use std::f64::consts::TAU;

/// An object during one frame, as both devices read it. Distances are along its path.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Object {
    /// Columns of the rotation that takes the axis it turns about to z; of what does not turn, of that to its
    /// own space.
    pub to_axis: [Vec4; 3],
    /// Columns of the rotation from there to the object's own space; the identity if it does not turn.
    pub from_axis: [Vec4; 3],
    /// Where its origin is at distance 0.
    pub position: Vec3,
    /// Radius of a sphere, half the side of a plane, and the radius of a sphere about a mesh.
    pub size: f32,
    /// Unit vector in which it goes; zero, if it does not.
    pub direction: Vec3,
    /// Distance at the frame's time, in metres, before any bounce.
    pub distance: f32,
    /// Change of the distance while the shutter is open, in metres.
    pub travel: f32,
    /// Distance on either side at which it turns back; so large that it never does, where it does not.
    pub bounce: f32,
    /// Angle turned about its axis at the frame's time, in turns.
    pub turns: f32,
    /// How much it turns per metre of distance.
    pub turns_per_m: f32,
    /// Part of the way from the first pose to the second at the frame's time, and on to 2, back again.
    pub pose: f32,
    /// How much that changes per metre of distance.
    pub poses_per_m: f32,
    /// Fills up to a multiple of 16 bytes.
    pub padding: [u32; 2],
}

/// Where an object is at an instant.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pose {
    /// Its origin.
    pub centre: Vec3,
    /// Angle turned about its axis, in turns.
    pub turns: f32,
    /// Time between its two poses, from 0 to 1.
    pub time: f32,
}

impl Object {
    /// `description` during frame `frame` of `stimulus`; `reach` is how far a mesh reaches from its origin.
    pub fn new(stimulus: &Stimulus, description: &scene::Object, reach: f32, frame: u32) -> Self {
        let path = stimulus.path(description, frame);
        let motion = description.motion.as_ref();
        let rotation = motion.and_then(|motion| motion.rotation);
        let at_rest = description.orientation.map_or(DQuat::IDENTITY, |orientation| {
            about(orientation.axis.into(), orientation.angle_deg.to_radians())
        });
        let to_axis = match rotation {
            Some(rotation) => axis_to_z(rotation.axis.into()),
            None => DMat3::from_quat(at_rest.inverse()),
        };
        let from_axis = match rotation {
            Some(_) => DMat3::from_quat(at_rest.inverse()) * to_axis.transpose(),
            None => DMat3::IDENTITY,
        };
        let columns =
            |matrix: DMat3| matrix.as_mat3().to_cols_array_2d().map(|c| Vec3::from(c).extend(0.0));
        let per_m = |metres: Option<f64>| metres.map_or(0.0, |metres| (1.0 / metres) as f32);
        let distance_between_poses =
            motion.and_then(|motion| motion.deformation.as_ref()).map(|d| d.distance_m);
        Self {
            to_axis: columns(to_axis),
            from_axis: columns(from_axis),
            position: Vec3::from(description.position_m.map(|c| c as f32)),
            size: match description.shape {
                Shape::Sphere { radius_m } => radius_m as f32,
                Shape::Plane { side_m } => (0.5 * side_m) as f32,
                Shape::Mesh { .. } => reach,
            },
            direction: Vec3::from(description.direction().unwrap_or_default().map(|c| c as f32)),
            distance: path.distance_m as f32,
            travel: path.travel_m as f32,
            bounce: path.bounce_m.map_or(1e30, |bounce| bounce as f32),
            turns: (path.angle_rad / TAU) as f32,
            turns_per_m: per_m(rotation.map(|rotation| TAU * rotation.radius_m)),
            pose: path.pose as f32,
            poses_per_m: per_m(distance_between_poses),
            padding: [0; 2],
        }
    }

    /// Whether it ever moves.
    pub fn moves(&self) -> bool {
        self.direction != Vec3::ZERO || self.turns_per_m != 0.0 || self.poses_per_m != 0.0
    }

    /// Whether its own axes are not those of the world.
    pub fn is_turned(&self) -> bool {
        [&self.to_axis, &self.from_axis]
            .into_iter()
            .any(|columns| matrix(columns) != Mat3::IDENTITY)
    }

    /// Where it is when the part `shutter` ∈ [−½, ½] of the shutter interval, counted from its middle,
    /// has passed.
    pub fn at(&self, shutter: f32) -> Pose {
        let free = self.distance + self.travel * shutter;
        let distance = if free > self.bounce {
            2.0 * self.bounce - free
        } else if free < -self.bounce {
            -2.0 * self.bounce - free
        } else {
            free
        };
        let moved = distance - self.distance;
        let poses = self.pose + moved * self.poses_per_m;
        Pose {
            centre: self.position + self.direction * distance,
            turns: self.turns + moved * self.turns_per_m,
            time: if self.poses_per_m == 0.0 { 0.0 } else { there_and_back(poses) },
        }
    }

    /// A world-space direction in the object's own space.
    pub fn to_object(&self, pose: &Pose, v: Vec3) -> Vec3 {
        let v = matrix(&self.to_axis) * v;
        if self.turns_per_m == 0.0 {
            return v;
        }
        let (sin, cos) = sin_cos_turns(pose.turns - pose.turns.floor());
        matrix(&self.from_axis) * Vec3::new(cos * v.x + sin * v.y, cos * v.y - sin * v.x, v.z)
    }

    /// A direction of the object's own space in world space.
    pub fn to_world(&self, pose: &Pose, v: Vec3) -> Vec3 {
        if self.turns_per_m == 0.0 {
            return matrix(&self.to_axis).transpose() * v;
        }
        let v = matrix(&self.from_axis).transpose() * v;
        let (sin, cos) = sin_cos_turns(pose.turns - pose.turns.floor());
        matrix(&self.to_axis).transpose()
            * Vec3::new(cos * v.x - sin * v.y, cos * v.y + sin * v.x, v.z)
    }

    /// Distance along a ray to the sphere at `centre`. A ray that begins on it meets it only from inside.
    /// The discriminant is taken from the vector between the ray and the centre, which keeps its
    /// precision far away (Haines et al. 2019).
    pub fn meet_sphere(
        &self,
        centre: Vec3,
        origin: Vec3,
        direction: Vec3,
        on: bool,
    ) -> Option<f32> {
        let to_centre = centre - origin;
        let along = to_centre.dot(direction);
        let across = to_centre - direction * along;
        let discriminant = self.size * self.size - across.length_squared();
        let half_chord = discriminant.max(0.0).sqrt();
        let (near, far) = (along - half_chord, along + half_chord);
        // Rounding moves what begins on the sphere and only touches it by a few 10⁻⁴ radii.
        let least = if on { 1e-3 * self.size } else { 0.0 };
        let distance = if near > least && !on { near } else { far };
        (discriminant > 0.0 && distance > least).then_some(distance)
    }

    /// Unit normal of a plane, in world space.
    pub fn plane_normal(&self, pose: &Pose) -> Vec3 {
        self.to_world(pose, Vec3::Y)
    }

    /// Whether a ray may meet a mesh, which reaches `size` far from its centre: it does so or begins within
    /// that reach.
    pub fn may_meet(&self, centre: Vec3, origin: Vec3, direction: Vec3) -> bool {
        let to_centre = centre - origin;
        let along = to_centre.dot(direction);
        let across = to_centre - direction * along.max(0.0);
        across.length_squared() <= self.size * self.size
    }

    /// Distance along a ray that begins elsewhere to the plane.
    pub fn meet_plane(&self, pose: &Pose, origin: Vec3, direction: Vec3) -> Option<f32> {
        let normal = self.plane_normal(pose);
        let origin = origin - pose.centre;
        let distance = -normal.dot(origin) / normal.dot(direction);
        let at = self.to_object(pose, origin + direction * distance);
        let within = at.x.abs() <= self.size && at.z.abs() <= self.size;
        // Along the plane the distance is infinite or not a number, and no place is within.
        (distance > 0.0 && within).then_some(distance)
    }
}

/// The way from 0 to 1, back to 0 at 2, and so on.
fn there_and_back(way: f32) -> f32 {
    (1.0 - (1.0 - (way - 2.0 * (0.5 * way).floor())).abs()).clamp(0.0, 1.0)
}

fn matrix(columns: &[Vec4; 3]) -> Mat3 {
    Mat3::from_cols(columns[0].truncate(), columns[1].truncate(), columns[2].truncate())
}

/// The rotation by `angle` about `axis`, of any length but 0.
fn about(axis: DVec3, angle: f64) -> DQuat {
    DQuat::from_axis_angle(axis.normalize_or(DVec3::Y), angle)
}

/// A rotation that takes `axis`, of any length but 0, to z. One that points back is first turned by half a turn
/// about x, away from where the shortest arc to z is not told.
fn axis_to_z(axis: DVec3) -> DMat3 {
    let axis = axis.normalize_or(DVec3::Z);
    let turned = if axis.z < 0.0 { DVec3::new(1.0, -1.0, -1.0) } else { DVec3::ONE };
    let arc = DQuat::from_rotation_arc(turned * axis, DVec3::Z);
    DMat3::from_quat(arc) * DMat3::from_diagonal(turned)
}
