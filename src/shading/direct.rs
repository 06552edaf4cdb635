//! Light straight from the lights without extent.

use super::bsdf::Bsdf;
use super::surface::Surface;
use crate::scene::light::Light;
use glam::Vec3;

/// What `lights` send to the viewer by way of `surface`, which scatters as `bsdf` does; `is_lit` tells whether
/// light from a direction and a distance reaches it.
pub fn from_lights(
    lights: &[Light],
    bsdf: &Bsdf,
    surface: &Surface,
    to_viewer: Vec3,
    is_lit: impl Fn(Vec3, f32) -> bool,
) -> Vec3 {
    let mut radiance = Vec3::ZERO;
    for light in lights {
        let arrival = light.at(surface.point);
        let (value, _) =
            bsdf.evaluate(surface.albedo, surface.normal, to_viewer, arrival.direction);
        if value != Vec3::ZERO && is_lit(arrival.direction, arrival.distance) {
            radiance += value * arrival.irradiance;
        }
    }
    radiance
}
