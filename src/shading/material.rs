//! Patterns of albedo. How a surface reflects beyond that is [`super::bsdf`]'s.

use crate::sampling::warp::atan2_turns;
use crate::scene::picture::{PictureRef, Pictures};
use bytemuck::{Pod, Zeroable};
use glam::Vec3;
use shutterlab_stimuli::scene;

/// A pattern with its parameters, as both devices read it.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Material {
    /// Albedo of a constant pattern, of light cells, and where the noise is 1.
    pub light: Vec3,
    /// [`Material::CONSTANT`] and so on.
    pub kind: u32,
    /// Albedo of dark cells, and where the noise is 0.
    pub dark: Vec3,
    /// Cells of the checker around the equator; lattice cells per unit of the noise's first octave.
    pub frequency: f32,
    /// Octaves of the noise.
    pub octaves: u32,
    /// Stretch of the noise about ½.
    pub contrast: f32,
    /// Fills up to a multiple of 16 bytes.
    pub padding: [u32; 2],
    /// The picture of an image.
    pub picture: PictureRef,
    /// Fills up to a multiple of 16 bytes.
    pub padding_too: u32,
}

/// A place on a surface, as patterns see it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// See [`scene::Material`].
    pub n: Vec3,
    /// u and v of a plane or of a mesh with texture coordinates; elsewhere they follow from n.
    pub coordinates: Option<[f32; 2]>,
}

/// The coordinates about a sphere: u, and half of v, so that the cells of a checker are square about the
/// equator.
fn about_sphere(n: Vec3) -> [f32; 2] {
    let turns = atan2_turns(-n.z, n.x);
    [turns - turns.floor(), atan2_turns((1.0 - n.y * n.y).max(0.0).sqrt(), n.y)]
}

impl Material {
    /// One albedo.
    pub const CONSTANT: u32 = 0;
    /// A checker.
    pub const CHECKER: u32 = 1;
    /// Value noise.
    pub const NOISE: u32 = 2;
    /// A picture.
    pub const IMAGE: u32 = 3;
    /// Colours and pictures of the mesh's own.
    pub const MODEL: u32 = 4;

    /// The pattern of `description`, with its picture if it has one.
    pub fn new(description: &scene::Material, picture: PictureRef) -> Self {
        let grey = |reflectance: f64| Vec3::splat(reflectance as f32);
        let plain = Self {
            light: Vec3::ONE,
            kind: Self::CONSTANT,
            dark: Vec3::ZERO,
            frequency: 0.0,
            octaves: 0,
            contrast: 0.0,
            padding: [0; 2],
            picture,
            padding_too: 0,
        };
        match *description {
            scene::Material::Constant { albedo, .. } => {
                Self { light: Vec3::from(albedo.map(|a| a as f32)), ..plain }
            }
            scene::Material::Checker { cells, light, dark, .. } => Self {
                kind: Self::CHECKER,
                light: grey(light),
                dark: grey(dark),
                frequency: cells as f32,
                ..plain
            },
            scene::Material::Noise { light, dark, frequency, octaves, contrast, .. } => Self {
                kind: Self::NOISE,
                light: grey(light),
                dark: grey(dark),
                frequency: frequency as f32,
                octaves,
                contrast: contrast as f32,
                ..plain
            },
            scene::Material::Image { .. } => Self { kind: Self::IMAGE, ..plain },
            scene::Material::Model { .. } => Self { kind: Self::MODEL, ..plain },
        }
    }

    /// The albedo at `place`; that of a model is 1 here, its colours being the mesh's.
    pub fn albedo(&self, place: &Place, pictures: &Pictures) -> Vec3 {
        match self.kind {
            Self::CHECKER => {
                let [u, v] = place.coordinates.unwrap_or_else(|| about_sphere(place.n));
                let cell = (self.frequency * u).floor() + (self.frequency * v).floor();
                // Even where half the cell number is whole.
                if 0.5 * cell == (0.5 * cell).floor() { self.light } else { self.dark }
            }
            Self::NOISE => {
                let stretched = 0.5 + self.contrast * (self.fractal_noise(place.n) - 0.5);
                self.dark + (self.light - self.dark) * stretched.clamp(0.0, 1.0)
            }
            Self::IMAGE => {
                let [u, v] = place.coordinates.unwrap_or_else(|| {
                    let [u, half_v] = about_sphere(place.n);
                    [u, 2.0 * half_v]
                });
                pictures.color(self.picture, u, v)
            }
            _ => self.light,
        }
    }

    /// Octaves of value noise, each of twice the frequency and half the amplitude of the one before,
    /// normalised to [0, 1].
    fn fractal_noise(&self, n: Vec3) -> f32 {
        let (mut sum, mut total) = (0.0, 0.0);
        let (mut amplitude, mut frequency) = (1.0, self.frequency);
        for octave in 0..self.octaves {
            sum += amplitude * value_noise(n * frequency, octave);
            total += amplitude;
            amplitude *= 0.5;
            frequency *= 2.0;
        }
        sum / total
    }
}

/// Random values at the points of the integer lattice, joined by smoothsteps.
fn value_noise(p: Vec3, octave: u32) -> f32 {
    let base = p.floor();
    let f = p - base;
    let w = f * f * (3.0 - 2.0 * f);
    let [x, y, z] = base.to_array().map(|v| v as i32 as u32);
    let corner = |dx: u32, dy: u32, dz: u32| {
        lattice_value(x.wrapping_add(dx), y.wrapping_add(dy), z.wrapping_add(dz), octave)
    };
    let along_x = |dy: u32, dz: u32| {
        let (a, b) = (corner(0, dy, dz), corner(1, dy, dz));
        a + (b - a) * w.x
    };
    let along_y = |dz: u32| {
        let (a, b) = (along_x(0, dz), along_x(1, dz));
        a + (b - a) * w.y
    };
    let (a, b) = (along_y(0), along_y(1));
    a + (b - a) * w.z
}

/// The lattice's hash: the coordinates times large primes and the octave times 2³²/φ, joined by
/// exclusive or (Teschner et al. 2003), finished by the mixer `lowbias32` (Wellons 2018); its upper
/// 24 bits are a number in [0, 1).
fn lattice_value(x: u32, y: u32, z: u32, octave: u32) -> f32 {
    let mut h = x.wrapping_mul(73_856_093)
        ^ y.wrapping_mul(19_349_663)
        ^ z.wrapping_mul(83_492_791)
        ^ octave.wrapping_mul(0x9e37_79b9);
    h = (h ^ (h >> 16)).wrapping_mul(0x7feb_352d);
    h = (h ^ (h >> 15)).wrapping_mul(0x846c_a68b);
    crate::sampling::random::unit(h ^ (h >> 16))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f32::consts::TAU;

    fn material(description: scene::Material) -> Material {
        Material::new(&description, PictureRef::default())
    }

    fn albedo(material: &Material, n: Vec3) -> f32 {
        material.albedo(&Place { n, coordinates: None }, &Pictures::default()).x
    }

    fn directions() -> impl Iterator<Item = Vec3> {
        // A Fibonacci spiral: even cover of the sphere.
        (0..20_000).map(|i| {
            let y = 1.0 - 2.0 * (i as f32 + 0.5) / 20_000.0;
            let phi = i as f32 * 2.399_963;
            let r = (1.0 - y * y).sqrt();
            Vec3::new(r * phi.cos(), y, r * phi.sin())
        })
    }

    #[test]
    fn the_checker_has_its_cells() {
        let checker =
            material(scene::Material::Checker { cells: 8, light: 0.8, dark: 0.1, coat: None });
        // Half the sphere is light: cells of one ring are equal in area.
        let light = directions().filter(|&n| albedo(&checker, n) > 0.5).count();
        assert!((light as f64 / 20_000.0 - 0.5).abs() < 0.01, "{light}");
        // Eight changes around the equator's upper ring, and the first cell, u and v just above 0, is light.
        let ring: Vec<f32> = (0..800)
            .map(|i| (i as f32 + 0.5) / 800.0 * TAU)
            .map(|phi| albedo(&checker, Vec3::new(0.8 * phi.cos(), 0.6, -0.8 * phi.sin())))
            .collect();
        assert_eq!((0..800).filter(|&i| ring[i] != ring[(i + 1) % 800]).count(), 8);
        assert_eq!(albedo(&checker, Vec3::new(0.02, 1.0, -0.001).normalize()), 0.8);
    }

    #[test]
    fn the_noise_stays_in_range_with_its_mean_in_the_middle() {
        let noise = material(scene::Material::Noise {
            light: 0.8,
            dark: 0.1,
            frequency: 4.0,
            octaves: 4,
            contrast: 2.2,
            coat: None,
        });
        let values: Vec<f32> = directions().map(|n| albedo(&noise, n)).collect();
        assert!(values.iter().all(|v| (0.1..=0.8).contains(v)));
        let mean = values.iter().sum::<f32>() / values.len() as f32;
        assert!((mean - 0.45).abs() < 0.05, "{mean}");
        let deviation =
            (values.iter().map(|v| (v - mean).powi(2)).sum::<f32>() / values.len() as f32).sqrt();
        assert!(deviation > 0.1, "{deviation}");
    }

    /// Value noise is continuous across lattice planes; its hash is not.
    #[test]
    fn the_noise_has_no_seams() {
        for plane in -3..=3 {
            for along in 0..50 {
                let other = along as f32 * 0.137 - 3.0;
                let below = value_noise(Vec3::new(plane as f32 - 1e-5, other, 0.3), 1);
                let above = value_noise(Vec3::new(plane as f32 + 1e-5, other, 0.3), 1);
                assert!((below - above).abs() < 1e-3);
            }
        }
    }
}
