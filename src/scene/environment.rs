//! The light around the scene: a latitude–longitude map of radiance, looked up and sampled.
//!
//! Texel (i, j) of a W×H map lies at azimuth φ = (½ − (i+½)/W)·2π and elevation
//! e = (½ − (j+½)/H)·π, in direction (cos e cos φ, sin e, −cos e sin φ). As a light, the map is
//! constant over each texel, and drawn from in 2^12 rectangles of equal flux (median cut). What a
//! light sample is weighed with is the density in exact proportion to the luminance, p̂ = luminance /
//! flux per steradian, which a look-up knows as well; a draw comes with a density p near it (for the
//! clear sky p̂/p has a variance of 0.016) and carries their ratio. The camera sees the map through a tent one texel wide on
//! either side (bilinear, by a random shift of the look-up), without blocks.

use super::import::ImportError;
use super::import::image::{Picture, light_map};
use super::texel::{exponent_base, pack, unpack};
use crate::sampling::median_cut::{Rectangle, median_cut};
use crate::sampling::random::unit;
use crate::sampling::warp::{atan2_turns, sin_cos_turns};
use glam::{DVec3, Vec3};
use shutterlab_stimuli::{assets, scene};
use std::f64::consts::{PI, TAU};
use std::path::Path;

/// The map is drawn from in 2 to the power of this many rectangles of equal flux.
const PART_BITS: u32 = 12;

/// Size of the built-in maps.
const BUILT_IN_SIZE: [usize; 2] = [1024, 512];

/// Direction towards the sun of the clear sky.
pub const SUN_DIRECTION: DVec3 = DVec3::new(-0.4393850, 0.6427876, 0.6275069);
/// Radiance at the centre of the sun.
pub const SUN_RADIANCE: DVec3 = DVec3::new(160.0, 145.0, 120.0);
/// Sharpness k of the sun's lobe e^{k(cos θ − 1)}.
pub const SUN_SHARPNESS: f64 = 600.0;

/// A radiance map and what is needed to sample it.
#[derive(Clone, Debug, PartialEq)]
pub struct Environment {
    /// Texels per row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Radiance (linear Rec. 709) per texel, row by row from the zenith, as [`pack`] gives it.
    pub texels: Vec<u32>,
    /// Exponent of the darkest texels' scale, biased as in a float.
    pub exponent_base: u32,
    /// Rectangles of equal flux, in texels.
    pub parts: Vec<Rectangle>,
    /// 1/∫ luminance over the sphere, 0 for a black map.
    pub inverse_flux: f32,
    /// p̂/p is this × luminance × cos e × a rectangle's area.
    pub part_scale: f32,
}

/// A direction drawn from an environment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightSample {
    /// Unit vector towards the light.
    pub direction: Vec3,
    /// Radiance from there × p̂/p.
    pub radiance: Vec3,
    /// p̂, per steradian.
    pub density: f32,
}

impl Environment {
    /// The map of `description`; one in a file is taken from `assets`, the folder of the sequences.
    ///
    /// # Errors
    /// The file is missing, or is no light map.
    pub fn load(description: &scene::Environment, assets: &Path) -> Result<Self, ImportError> {
        let [width, height] = BUILT_IN_SIZE;
        Ok(match description {
            scene::Environment::BuiltIn(scene::BuiltIn::ClearSky) => {
                Self::from_radiance(width, height, clear_sky)
            }
            scene::Environment::BuiltIn(scene::BuiltIn::SunOnly) => {
                Self::from_radiance(width, height, sun)
            }
            scene::Environment::Uniform(radiance) => {
                let radiance = DVec3::from(*radiance);
                Self::from_radiance(4, 2, |_| radiance)
            }
            scene::Environment::Map(map) => {
                let file = assets::path(assets, Path::new(&map.file), &map.sha256);
                let Picture { width, height, texels } = light_map(&file)?;
                Self::from_texels(width as usize, height as usize, &texels)
            }
        })
    }

    /// The map of the radiance that `radiance` gives for each texel's direction.
    fn from_radiance(width: usize, height: usize, radiance: impl Fn(DVec3) -> DVec3) -> Self {
        let direction = |k: usize| texel_direction(k % width, k / width, width, height);
        let colors: Vec<Vec3> =
            (0..width * height).map(|k| radiance(direction(k)).as_vec3()).collect();
        Self::from_texels(width, height, &colors)
    }

    /// The map of `colors`, row by row from the zenith.
    fn from_texels(width: usize, height: usize, colors: &[Vec3]) -> Self {
        let brightest = colors.iter().fold(0.0, |max: f32, color| max.max(color.max_element()));
        let base = exponent_base(brightest);
        let texels: Vec<u32> = colors.iter().map(|&color| pack(color, base)).collect();
        let row_sine = |j: usize| ((0.5 - j as f64 / height as f64) * PI).sin();
        let solid_angle = |j: usize| (row_sine(j) - row_sine(j + 1)) * TAU / width as f64;
        // The weights are those of the packed texels, which is what look-ups find.
        let weight =
            |(k, &texel)| f64::from(luminance(unpack(texel, base))) * solid_angle(k / width);
        let weights: Vec<f64> = texels.iter().enumerate().map(weight).collect();
        let flux: f64 = weights.iter().sum();
        let inverse_flux = if flux > 0.0 { 1.0 / flux } else { 0.0 };
        // The area of the map in (φ, e) over that of one of the parts if all were equal.
        let steradians_per_texel = 2.0 * PI * PI / (width * height) as f64;
        Self {
            width: width as u32,
            height: height as u32,
            texels,
            exponent_base: base,
            parts: median_cut(&weights, width, PART_BITS),
            inverse_flux: inverse_flux as f32,
            part_scale: (inverse_flux * steradians_per_texel * f64::from(1 << PART_BITS)) as f32,
        }
    }

    /// The radiance from everywhere, if it is the same.
    pub fn uniform(&self) -> Option<Vec3> {
        let (first, others) = self.texels.split_first()?;
        // Maps that are not small do not repeat one texel.
        let is_one = others.len() < 8 && others.iter().all(|texel| texel == first);
        is_one.then(|| unpack(*first, self.exponent_base))
    }

    /// Draws a direction by two random words.
    pub fn sample(&self, words: [u32; 2]) -> LightSample {
        let part = self.parts[(words[0] >> (32 - PART_BITS)) as usize];
        let x = part.x + part.width * unit(words[0] << PART_BITS);
        let y = part.y + part.height * unit(words[1]);
        // From the zenith half a turn down; φ = (½ − x/W) turns, and half a turn more changes signs.
        let (cos_elevation, sin_elevation) = sin_cos_turns(0.5 * y / self.height as f32);
        let (sin_turns, cos_turns) = sin_cos_turns(x / self.width as f32);
        let direction =
            Vec3::new(-cos_elevation * cos_turns, sin_elevation, -cos_elevation * sin_turns);
        let radiance = self.texel(x, y);
        let density = luminance(radiance);
        let ratio = density * cos_elevation * (part.width * part.height) * self.part_scale;
        LightSample { direction, radiance: radiance * ratio, density: density * self.inverse_flux }
    }

    /// Radiance from `direction`, and p̂ there, per steradian. `shift` moves the look-up, in texels.
    pub fn evaluate(&self, direction: Vec3, shift: [f32; 2]) -> (Vec3, f32) {
        let (width, height) = (self.width as f32, self.height as f32);
        let cos_elevation = (1.0 - direction.y * direction.y).max(0.0).sqrt();
        let x = (0.5 - atan2_turns(-direction.z, direction.x)) * width + shift[0];
        let y = (0.5 - 2.0 * atan2_turns(direction.y, cos_elevation)) * height + shift[1];
        // Around in azimuth, and constant beyond the poles.
        let around = if x < 0.0 {
            x + width
        } else if x >= width {
            x - width
        } else {
            x
        };
        let radiance = self.texel(around, y.clamp(0.0, height));
        (radiance, luminance(radiance) * self.inverse_flux)
    }

    /// Radiance at a place of the map, in texels.
    fn texel(&self, x: f32, y: f32) -> Vec3 {
        let i = (x as u32).min(self.width - 1);
        let j = (y as u32).min(self.height - 1);
        unpack(self.texels[(j * self.width + i) as usize], self.exponent_base)
    }
}

/// Luminance of linear Rec. 709.
pub fn luminance(radiance: Vec3) -> f32 {
    radiance.dot(Vec3::new(0.2126, 0.7152, 0.0722))
}

fn texel_direction(i: usize, j: usize, width: usize, height: usize) -> DVec3 {
    let (sin_phi, cos_phi) = ((0.5 - (i as f64 + 0.5) / width as f64) * TAU).sin_cos();
    let (sin_elevation, cos_elevation) = ((0.5 - (j as f64 + 0.5) / height as f64) * PI).sin_cos();
    DVec3::new(cos_elevation * cos_phi, sin_elevation, -cos_elevation * sin_phi)
}

/// A clear sky over a brownish ground, with a soft sun and its aureole.
fn clear_sky(d: DVec3) -> DVec3 {
    let zenith = 1.0 - (-5.0 * d.y.max(0.0)).exp();
    let above = smoothstep(-0.02, 0.02, d.y);
    let ground = DVec3::new(0.22, 0.19, 0.15);
    let sky = DVec3::new(0.85, 0.92, 1.0) * (1.0 - zenith) + DVec3::new(0.18, 0.32, 0.75) * zenith;
    let aureole = DVec3::new(0.8, 0.7, 0.5) * (20.0 * (d.dot(SUN_DIRECTION) - 1.0)).exp();
    ground * (1.0 - above) + sky * above + sun(d) + aureole
}

fn sun(d: DVec3) -> DVec3 {
    SUN_RADIANCE * (SUN_SHARPNESS * (d.dot(SUN_DIRECTION) - 1.0)).exp()
}

fn smoothstep(low: f64, high: f64, x: f64) -> f64 {
    let t = ((x - low) / (high - low)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::random::StreamKey;

    fn clear_sky_map() -> Environment {
        let sky = scene::Environment::BuiltIn(scene::BuiltIn::ClearSky);
        Environment::load(&sky, Path::new("")).unwrap()
    }

    fn draws(map: &Environment, count: u32) -> impl Iterator<Item = LightSample> + '_ {
        let key = StreamKey::new(3, "environment", 0, 0, 0);
        (0..count).map(move |i| {
            let [a, b, ..] = key.words(i, 0, 0);
            map.sample([a, b])
        })
    }

    /// p̂/p of a draw.
    fn ratio(map: &Environment, sample: &LightSample) -> f64 {
        f64::from(luminance(sample.radiance) * map.inverse_flux / sample.density)
    }

    /// What is drawn and what is looked up in the drawn direction are one and the same, but for
    /// directions that rounding puts across the border of their texel.
    #[test]
    fn sampling_agrees_with_evaluation() {
        for map in [
            clear_sky_map(),
            Environment::from_radiance(37, 11, |d| DVec3::new(1.0, 2.0, 3.0) * (1.5 + d.x)),
        ] {
            let agrees = |s: &LightSample| {
                let (radiance, density) = map.evaluate(s.direction, [0.0; 2]);
                let drawn = s.radiance / ratio(&map, s) as f32;
                density == s.density && drawn.abs_diff_eq(radiance, 1e-5 * radiance.max_element())
            };
            let others = draws(&map, 20_000).filter(|sample| !agrees(sample)).count();
            assert!(others < 60, "{others}");
        }
    }

    /// The mean over draws of 1/p is the whole sphere, 4π; that of p̂/p is ∫ p̂ = 1. And p is near
    /// enough to p̂ that their ratio adds at most 2 % to the variance.
    #[test]
    fn the_densities_integrate_to_one() {
        let map = clear_sky_map();
        const DRAWS: u32 = 400_000;
        let mean = |value: &dyn Fn(&LightSample) -> f64| {
            draws(&map, DRAWS).map(|s| value(&s)).sum::<f64>() / f64::from(DRAWS)
        };
        let sphere = mean(&|s| ratio(&map, s) / f64::from(s.density));
        assert!((sphere / (4.0 * PI) - 1.0).abs() < 0.02, "{sphere}");
        let whole = mean(&|s| ratio(&map, s));
        assert!((whole - 1.0).abs() < 1e-3, "{whole}");
        let variance = mean(&|s| (ratio(&map, s) - 1.0).powi(2));
        assert!(variance < 0.02, "{variance}");
    }

    /// The radiance of unshadowed floor, albedo/π · E with albedo ½, from an outside computation.
    #[test]
    fn irradiance_of_the_clear_sky_meets_the_known_value() {
        let map = clear_sky_map();
        let mut radiance = DVec3::ZERO;
        const DRAWS: u32 = 400_000;
        for sample in draws(&map, DRAWS) {
            let cosine = f64::from(sample.direction.y.max(0.0));
            radiance += sample.radiance.as_dvec3()
                * (0.5 / PI * cosine / f64::from(sample.density) / f64::from(DRAWS));
        }
        let known = DVec3::new(0.31126, 0.35947, 0.52819);
        assert!((radiance / known - 1.0).abs().max_element() < 5e-3, "{radiance}");
    }

    /// Seen through a random shift of one texel the map is its bilinear interpolation.
    #[test]
    fn a_shifted_look_up_is_bilinear_on_average() {
        let map = Environment::from_radiance(8, 4, |d| DVec3::splat(2.0 + d.x));
        let (a, b) = (texel_direction(2, 1, 8, 4), texel_direction(3, 1, 8, 4));
        // A quarter of the way from one texel's centre to the next.
        let phi = TAU * (0.5 - 2.75 / 8.0);
        let direction =
            DVec3::new(phi.cos() * (PI / 8.0).cos(), a.y, -phi.sin() * (PI / 8.0).cos()).as_vec3();
        let mean = (0..4096)
            .map(|k| [(k % 64) as f32 / 64.0 - 0.492, (k / 64) as f32 / 64.0 - 0.492])
            .map(|shift| f64::from(map.evaluate(direction, shift).0.x) / 4096.0)
            .sum::<f64>();
        assert!((mean - (2.0 + 0.75 * a.x + 0.25 * b.x)).abs() < 0.01, "{mean}");
    }
}
