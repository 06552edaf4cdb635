//! Lights without extent. No path meets them by chance, so every hit looks at each.

use bytemuck::{Pod, Zeroable};
use glam::{DVec3, Vec3};
use shutterlab_stimuli::scene;

/// A light, as both devices read it.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Light {
    /// Place of a point light; unit vector towards a directional one.
    pub place: Vec3,
    /// 1 for a point light, 0 for a directional one.
    pub is_point: u32,
    /// Radiant intensity of a point light, irradiance from a directional one.
    pub color: Vec3,
    /// Fills up to a multiple of 16 bytes.
    pub padding: u32,
}

/// The light that comes to a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Arrival {
    /// Unit vector towards the light.
    pub direction: Vec3,
    /// How far away it is.
    pub distance: f32,
    /// Irradiance of a surface that faces it.
    pub irradiance: Vec3,
}

impl Light {
    /// The light of `description`.
    pub fn new(description: &scene::Light) -> Self {
        let single = |v: [f64; 3]| DVec3::from(v).as_vec3();
        let (place, is_point, color) = match *description {
            scene::Light::Point { position_m, intensity } => (single(position_m), 1, intensity),
            scene::Light::Directional { direction, irradiance } => {
                ((-DVec3::from(direction)).normalize_or_zero().as_vec3(), 0, irradiance)
            }
        };
        Self { place, is_point, color: single(color), padding: 0 }
    }

    /// Its light at `point`, if nothing is in the way.
    pub fn at(&self, point: Vec3) -> Arrival {
        if self.is_point == 0 {
            return Arrival { direction: self.place, distance: f32::MAX, irradiance: self.color };
        }
        let offset = self.place - point;
        // At the light itself there is no direction to it, and the surface is black.
        let squared = offset.length_squared().max(1e-12);
        let distance = squared.sqrt();
        Arrival { direction: offset / distance, distance, irradiance: self.color / squared }
    }
}
