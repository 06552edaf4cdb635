//! How surfaces scatter light: Lambertian, a rough metal, or a rough clear coat over a Lambertian base.
//!
//! o points to the viewer, i to the light, h halves the angle between them, n is the normal. The
//! mirrors are microfacets [Walter2007] with the normals of Trowbridge and Reitz (GGX),
//! D = α² / (π(α² + (1 − α²) sin²θ_h)²), and Smith's masking and shadowing, correlated in height
//! [Heitz2014]; what light loses by meeting two of them is gone. With S(c) = √(α² + (1 − α²)c²),
//!
//! | | |
//! |---|---|
//! | Lambertian | f = ρ/π |
//! | metal | f = F·D / (2((n·i)·S(n·o) + (n·o)·S(n·i))), F by Schlick from ρ at normal incidence [Schlick1994] |
//! | coat | the same with the exact F of a dielectric, and below it the base |
//! | its base | f = (1 − F(n·i))(1 − F(n·o))·ρ / (πη²(1 − ρF_i)), light reflected any number of times below the coat, of which F_i returns each time: the nonlinear `plastic` of Mitsuba [Jakob2022] |
//!
//! Directions are drawn by visible normals [Heitz2018], as spherical caps [DupuyBenyoub2023], or about
//! n by the cosine law. The base takes the coat to be smooth, so that a rough white coat does not quite
//! keep the light that comes in: some is lost along the surface, and at middling angles up to a
//! thousandth is won.

use crate::sampling::random::unit;
use crate::sampling::warp::{cosine_hemisphere, sin_cos_turns};
use crate::scene::environment::luminance;
use bytemuck::{Pod, Zeroable};
use glam::Vec3;
use shutterlab_stimuli::scene::Coat;
use std::f32::consts::{FRAC_1_PI, PI};

/// A way to scatter with its parameters, as both devices read it.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Bsdf {
    /// 0 Lambertian, 1 metal, 2 dielectric coat.
    pub kind: u32,
    /// Width of the microfacets' slopes, from 0.0004 to 1.
    pub alpha: f32,
    /// The coat's index of refraction.
    pub eta: f32,
    /// How much of diffuse light from below the coat's surface returns.
    pub internal: f32,
}

/// Where a path goes on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scattered {
    /// Unit vector away from the surface.
    pub direction: Vec3,
    /// Density per steradian, as [`Bsdf::evaluate`] tells it.
    pub density: f32,
    /// BSDF × cos θ over the density: what the path's throughput is multiplied by.
    pub weight: Vec3,
}

const LAMBERTIAN: u32 = 0;
const METAL: u32 = 1;
const DIELECTRIC: u32 = 2;

/// Below this a lobe is too narrow for unit vectors in single precision.
const MIN_ALPHA: f64 = 0.0004;

impl Bsdf {
    /// A surface with `coat`, or a Lambertian one.
    pub fn new(coat: Option<&Coat>) -> Self {
        let alpha = |roughness: f64| roughness.powi(2).clamp(MIN_ALPHA, 1.0) as f32;
        let lambertian = Self { kind: LAMBERTIAN, alpha: 1.0, eta: 1.0, internal: 0.0 };
        match coat {
            None => lambertian,
            Some(&Coat::Metal { roughness }) => {
                Self { kind: METAL, alpha: alpha(roughness), ..lambertian }
            }
            Some(&Coat::Dielectric { roughness, ior }) => Self {
                kind: DIELECTRIC,
                alpha: alpha(roughness),
                eta: ior as f32,
                internal: internal_reflectance(ior) as f32,
            },
        }
    }

    /// BSDF × cos θ for light from `to_light`, per steradian, and the density per steradian with which
    /// [`Bsdf::sample`] draws that direction. Unit vectors, away from the surface; the normal is on the
    /// viewer's side. Nothing comes from below the surface.
    pub fn evaluate(
        &self,
        albedo: Vec3,
        normal: Vec3,
        to_viewer: Vec3,
        to_light: Vec3,
    ) -> (Vec3, f32) {
        let (viewer_cosine, light_cosine) = (normal.dot(to_viewer), normal.dot(to_light));
        let cosine_density = light_cosine.max(0.0) * FRAC_1_PI;
        if self.kind == LAMBERTIAN {
            return (albedo * cosine_density, cosine_density);
        }
        if viewer_cosine <= 0.0 || light_cosine <= 0.0 {
            return (Vec3::ZERO, 0.0);
        }

        // 2(o·h)h. Opposite directions along the surface may leave nothing of it.
        let sum = to_viewer + to_light;
        let length_squared = sum.length_squared().max(1e-30);
        let half_cosine = (0.5 * length_squared.sqrt()).min(1.0);
        // Not 1 − cos²: near the peak that is all rounding.
        let sin_squared = normal.cross(sum).length_squared() / length_squared;

        let alpha_squared = self.alpha * self.alpha;
        let smith = |cosine: f32| (alpha_squared + (1.0 - alpha_squared) * cosine * cosine).sqrt();
        let (viewer_smith, light_smith) = (smith(viewer_cosine), smith(light_cosine));
        let slope = alpha_squared + (1.0 - alpha_squared) * sin_squared;
        let normals = alpha_squared / (PI * slope * slope);
        // Visible normals, per steradian of i: G₁·D / (4 n·o) [Heitz2018].
        let mirror_density = 0.5 * normals / (viewer_cosine + viewer_smith);
        let both = light_cosine * viewer_smith + viewer_cosine * light_smith;
        let mirror = 0.5 * normals * light_cosine / both.max(1e-30);

        if self.kind == METAL {
            let fresnel = albedo + (1.0 - albedo) * (1.0 - half_cosine).powi(5);
            return (fresnel * mirror, mirror_density);
        }
        let enters = (1.0 - fresnel(viewer_cosine, self.eta))
            * (1.0 - fresnel(light_cosine, self.eta))
            / (self.eta * self.eta);
        let base = albedo / (1.0 - albedo * self.internal) * (enters * cosine_density);
        let share = self.mirror_share(albedo, viewer_cosine);
        (
            base + fresnel(half_cosine, self.eta) * mirror,
            share * mirror_density + (1.0 - share) * cosine_density,
        )
    }

    /// Draws a direction to go on in, by two random words; `None` where it leads below the surface, and
    /// the path ends.
    pub fn sample(
        &self,
        albedo: Vec3,
        normal: Vec3,
        to_viewer: Vec3,
        words: [u32; 2],
    ) -> Option<Scattered> {
        let [a, b] = words.map(unit);
        if self.kind == LAMBERTIAN {
            let direction = cosine_hemisphere(normal, [a, b]);
            let density = normal.dot(direction).max(0.0) * FRAC_1_PI;
            return Some(Scattered { direction, density, weight: albedo });
        }
        let share = match self.kind {
            METAL => 1.0,
            _ => self.mirror_share(albedo, normal.dot(to_viewer)),
        };
        // The first number chooses between coat and base, and what is left of it is uniform again.
        let direction = if a < share {
            let facet = visible_normal(normal, to_viewer, self.alpha, [a / share, b]);
            2.0 * to_viewer.dot(facet) * facet - to_viewer
        } else {
            cosine_hemisphere(normal, [(a - share) / (1.0 - share), b])
        };
        let (reflected, density) = self.evaluate(albedo, normal, to_viewer, direction);
        (density > 0.0).then(|| Scattered { direction, density, weight: reflected / density })
    }

    /// The part of the samples that the coat gets: its part in what both would reflect if it were
    /// smooth.
    fn mirror_share(&self, albedo: Vec3, viewer_cosine: f32) -> f32 {
        let fresnel = fresnel(viewer_cosine.max(0.0), self.eta);
        let base = luminance(albedo / (1.0 - albedo * self.internal)) * (1.0 - self.internal);
        fresnel / (fresnel + (1.0 - fresnel) * base)
    }
}

/// Reflectance of a dielectric of index η seen from outside at an angle of this cosine, unpolarised.
fn fresnel(cosine: f32, eta: f32) -> f32 {
    // Eq. 22 [Walter2007].
    let g = (eta * eta - 1.0 + cosine * cosine).sqrt();
    let across = (g - cosine) / (g + cosine);
    let along = (cosine * (g + cosine) - 1.0) / (cosine * (g - cosine) + 1.0);
    0.5 * across * across * (1.0 + along * along)
}

/// Reflectance of the surface of index η for diffuse light from inside, F_i. As much passes as from
/// outside, but from a cone that is η² times smaller: 1 − F_i = (1 − F_e)/η².
fn internal_reflectance(eta: f64) -> f64 {
    1.0 - (1.0 - external_reflectance(eta)) / (eta * eta)
}

/// The same from outside, F_e = ∫₀¹ F(c)·2c dc, by the midpoint rule.
fn external_reflectance(eta: f64) -> f64 {
    const STEPS: u32 = 1024;
    let cosines = (0..STEPS).map(|step| (f64::from(step) + 0.5) / f64::from(STEPS));
    let sum: f64 = cosines.map(|c| f64::from(fresnel(c as f32, eta as f32)) * 2.0 * c).sum();
    sum / f64::from(STEPS)
}

/// The normal of a microfacet, as often as the viewer sees its area: the space is stretched until the
/// microfacets are a hemisphere, which mirrors the viewer's direction into a spherical cap evenly
/// [DupuyBenyoub2023].
fn visible_normal(normal: Vec3, to_viewer: Vec3, alpha: f32, u: [f32; 2]) -> Vec3 {
    let [tangent, bitangent] = tangents(normal);
    let (x, y) = (alpha * to_viewer.dot(tangent), alpha * to_viewer.dot(bitangent));
    let z = normal.dot(to_viewer);
    let viewer = Vec3::new(x, y, z) * (1.0 / (x * x + y * y + z * z).sqrt());
    // How far the point of the cap is below the pole: without cancellation in the sine.
    let depth = u[1] * (1.0 + viewer.z);
    let r = (depth * (2.0 - depth)).max(0.0).sqrt();
    let (sin, cos) = sin_cos_turns(u[0]);
    let x = alpha * (viewer.x + r * cos);
    let y = alpha * (viewer.y + r * sin);
    // Positive, since u < 1, so that the sum has a length.
    let z = (1.0 - u[1]) * (1.0 + viewer.z);
    (tangent * x + bitangent * y + normal * z) * (1.0 / (x * x + y * y + z * z).sqrt())
}

/// Two unit vectors that complete the unit vector `n` to a frame [Duff2017].
fn tangents(n: Vec3) -> [Vec3; 2] {
    let sign = if n.z < 0.0 { -1.0 } else { 1.0 };
    let a = -1.0 / (sign + n.z);
    let b = n.x * n.y * a;
    [
        Vec3::new(1.0 + sign * n.x * n.x * a, sign * b, -sign * n.x),
        Vec3::new(b, sign + n.y * n.y * a, -n.y),
    ]
}

#[cfg(test)]
mod tests;
