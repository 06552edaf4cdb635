//! The light around the scene: a latitude–longitude map of radiance, looked up and sampled.
//!
//! Texel (i, j) of a W×H map lies at azimuth φ = (½ − (i+½)/W)·2π and elevation
//! e = (½ − (j+½)/H)·π, in direction (cos e cos φ, sin e, −cos e sin φ). As a light, the map is
//! constant over each texel, so that its texels can be drawn with probabilities in exact proportion
//! to what they give: first the row, then the texel in it (alias method), then a point in the texel,
//! uniform in solid angle. The density of a direction per steradian is then the luminance found
//! there over the luminance of the whole map, and needs no table. The camera sees the map through
//! a tent one texel wide on either side (bilinear, by a random shift of the look-up), without blocks.
//!
//! The look-ups are what the path tracer spends most of its time on: they miss the caches. So a
//! texel is two words, three mantissas of 18 bits under a common exponent (relative error 2⁻¹⁹ of
//! the largest channel), and an alias slot is one.

use crate::sampling::alias;
use crate::sampling::warp::{atan2_turns, sin_cos_turns};
use glam::{DVec3, Vec3};
use shutterlab_stimuli::scene;
use std::f64::consts::{PI, TAU};

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
    pub texels: Vec<[u32; 2]>,
    /// Sine of the elevation of the upper border of each row, and of the lower border of the last.
    pub row_sines: Vec<f32>,
    /// One alias table that draws a row, then one for each row that draws a texel in it.
    pub alias_slots: Vec<u32>,
    /// ∫ luminance over the sphere.
    pub flux: f32,
}

/// A direction drawn from an environment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightSample {
    /// Unit vector towards the light.
    pub direction: Vec3,
    /// Radiance from there.
    pub radiance: Vec3,
    /// Density with which it was drawn, per steradian.
    pub density: f32,
}

impl Environment {
    /// The map of `description`.
    pub fn new(description: &scene::Environment) -> Self {
        let [width, height] = BUILT_IN_SIZE;
        match description {
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
        }
    }

    /// The map of the radiance that `radiance` gives for each texel's direction.
    fn from_radiance(width: usize, height: usize, radiance: impl Fn(DVec3) -> DVec3) -> Self {
        let row_sines: Vec<f64> =
            (0..=height).map(|j| ((0.5 - j as f64 / height as f64) * PI).sin()).collect();
        let (mut texels, mut row_weights, mut column_slots) = (vec![], vec![], vec![]);
        for j in 0..height {
            let row: Vec<[u32; 2]> = (0..width)
                .map(|i| pack(radiance(texel_direction(i, j, width, height)).as_vec3()))
                .collect();
            // The weights are those of the packed texels, which is what look-ups find.
            let weights: Vec<f64> =
                row.iter().map(|&texel| f64::from(luminance(unpack(texel)))).collect();
            let solid_angle = (row_sines[j] - row_sines[j + 1]) * TAU / width as f64;
            row_weights.push(weights.iter().sum::<f64>() * solid_angle);
            alias::push_table(&mut column_slots, &weights);
            texels.extend(row);
        }
        let mut alias_slots = vec![];
        alias::push_table(&mut alias_slots, &row_weights);
        alias_slots.extend(column_slots);
        Self {
            width: width as u32,
            height: height as u32,
            texels,
            row_sines: row_sines.iter().map(|&sine| sine as f32).collect(),
            alias_slots,
            flux: row_weights.iter().sum::<f64>() as f32,
        }
    }

    /// Bits of a slot number of the table of rows, and of each table of texels in a row.
    pub fn slot_bits(&self) -> [u32; 2] {
        [self.height, self.width].map(|count| alias::slot_bits(count as usize))
    }

    /// Draws a direction, by the four words of a block of random numbers.
    pub fn sample(&self, words: [u32; 4]) -> LightSample {
        let unit = crate::sampling::random::unit;
        let [row_bits, column_bits] = self.slot_bits();
        let j = alias::draw(&self.alias_slots, 0, row_bits, words[0]);
        let first = (1 << row_bits) + (j << column_bits);
        let i = alias::draw(&self.alias_slots, first, column_bits, words[1]);

        let (upper, lower) = (self.row_sines[j as usize], self.row_sines[j as usize + 1]);
        let sin_elevation = upper + (lower - upper) * unit(words[3]);
        let cos_elevation = (1.0 - sin_elevation * sin_elevation).max(0.0).sqrt();
        // φ = (½ − x/W) turns, and half a turn more changes both signs.
        let (sin_turns, cos_turns) = sin_cos_turns((i as f32 + unit(words[2])) / self.width as f32);
        let direction =
            Vec3::new(-cos_elevation * cos_turns, sin_elevation, -cos_elevation * sin_turns);
        let radiance = unpack(self.texels[(j * self.width + i) as usize]);
        LightSample { direction, radiance, density: luminance(radiance) / self.flux }
    }

    /// Radiance from `direction`, and the density with which [`Environment::sample`] draws it, per
    /// steradian. `shift` moves the look-up, in texels.
    pub fn evaluate(&self, direction: Vec3, shift: [f32; 2]) -> (Vec3, f32) {
        let (width, height) = (self.width as f32, self.height as f32);
        let cos_elevation = (1.0 - direction.y * direction.y).max(0.0).sqrt();
        let x = (0.5 - atan2_turns(-direction.z, direction.x)) * width + shift[0];
        let y = (0.5 - 2.0 * atan2_turns(direction.y, cos_elevation)) * height + shift[1];
        // Around in azimuth, and constant beyond the poles.
        let i = (x - width * (x / width).floor()).min(width - 1.0) as u32;
        let j = y.clamp(0.0, height - 1.0) as u32;
        let radiance = unpack(self.texels[(j * self.width + i) as usize]);
        (radiance, luminance(radiance) / self.flux)
    }
}

/// Luminance of linear Rec. 709.
pub fn luminance(radiance: Vec3) -> f32 {
    radiance.dot(Vec3::new(0.2126, 0.7152, 0.0722))
}

/// Three channels in two words: mantissas of 18 bits under a common power of two 2^(e−127), of
/// which the biased exponent e is kept in the lowest 10 bits.
fn pack(radiance: Vec3) -> [u32; 2] {
    let radiance = radiance.max(Vec3::ZERO);
    let largest = radiance.max_element();
    // The scale is the power of two at or above the largest channel over 2¹⁸.
    let exponent = ((largest.to_bits() >> 23) + 1).saturating_sub(18).clamp(1, 254);
    let scale = f32::from_bits(exponent << 23);
    let [r, g, b] = (radiance / scale).to_array().map(|v| (v.round() as u32).min(0x3_ffff));
    [r << 14 | g >> 4, g << 28 | b << 10 | exponent]
}

/// The channels that [`pack`] packed.
fn unpack([high, low]: [u32; 2]) -> Vec3 {
    let scale = f32::from_bits((low & 0x3ff) << 23);
    let mantissas = [high >> 14, (high & 0x3fff) << 4 | low >> 28, (low >> 10) & 0x3_ffff];
    Vec3::from(mantissas.map(|m| m as f32)) * scale
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
        Environment::new(&scene::Environment::BuiltIn(scene::BuiltIn::ClearSky))
    }

    fn draws(map: &Environment, count: u32) -> impl Iterator<Item = LightSample> + '_ {
        let key = StreamKey::new(3, "environment", 0, 0, 0);
        (0..count).map(move |i| map.sample(key.words(i, 0, 0)))
    }

    #[test]
    fn packing_keeps_eighteen_bits_of_the_largest_channel() {
        for radiance in [
            [160.0, 145.0, 120.0],
            [0.22, 0.19, 1e-3],
            [1e5, 3.0, 0.0],
            [2e-9, 1e-9, 0.0],
            [1.0; 3],
        ] {
            let radiance = Vec3::from(radiance);
            let error = (unpack(pack(radiance)) - radiance).abs().max_element();
            assert!(error <= radiance.max_element() / 262_144.0, "{radiance}: {error}");
        }
        assert_eq!(unpack(pack(Vec3::ZERO)), Vec3::ZERO);
    }

    /// What is drawn and what is looked up in the drawn direction are one and the same, but for
    /// directions that rounding puts across the border of their texel.
    #[test]
    fn sampling_agrees_with_evaluation() {
        for map in [
            clear_sky_map(),
            Environment::from_radiance(37, 11, |d| DVec3::new(1.0, 2.0, 3.0) * (1.5 + d.x)),
        ] {
            let agrees =
                |s: &LightSample| map.evaluate(s.direction, [0.0; 2]) == (s.radiance, s.density);
            let others = draws(&map, 20_000).filter(|sample| !agrees(sample)).count();
            assert!(others < 60, "{others}");
        }
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

    /// ∫ density dω = 1: the mean of 1/density over the draws is 4π.
    #[test]
    fn the_density_integrates_to_one() {
        let map = clear_sky_map();
        let mean =
            draws(&map, 400_000).map(|s| 1.0 / f64::from(s.density)).sum::<f64>() / 400_000.0;
        assert!((mean / (4.0 * PI) - 1.0).abs() < 0.02, "{mean}");
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
