//! What scattering must satisfy: the papers' values, reciprocity, energy, and draws that follow their
//! density.

use super::*;
use crate::sampling::random::StreamKey;
use glam::DVec3;
use std::f64::consts::{PI as PI64, TAU};

const ROUGHNESS: [f64; 5] = [0.02, 0.1, 0.3, 0.6, 1.0];
const COSINES: [f32; 5] = [1.0, 0.8, 0.5, 0.15, 0.01];

/// Lambertian, and every roughness of metal and of coats.
fn bsdfs() -> Vec<(String, Bsdf)> {
    let metal = |roughness| Coat::Metal { roughness };
    let coat = |ior| move |roughness| Coat::Dielectric { roughness, ior };
    let coats = ROUGHNESS.map(metal).into_iter();
    let coats = coats.chain(ROUGHNESS.map(coat(1.5))).chain(ROUGHNESS.map(coat(2.5)));
    let named = |coat: Coat| (format!("{coat:?}"), Bsdf::new(Some(&coat)));
    std::iter::once(("Lambertian".into(), Bsdf::new(None))).chain(coats.map(named)).collect()
}

/// A normal, and a direction of this cosine to it.
fn placed(index: usize, cosine: f32) -> (Vec3, Vec3) {
    let normals = [Vec3::Y, Vec3::NEG_Z, Vec3::new(0.6, 0.48, -0.64), Vec3::X];
    let normal = normals[index % 4];
    let sine = (1.0 - cosine * cosine).sqrt();
    let (sin, cos) = (index as f32).sin_cos();
    let [tangent, bitangent] = tangents(normal);
    (normal, (normal * cosine + (tangent * cos + bitangent * sin) * sine).normalize())
}

/// Random directions all over the sphere, with a part of them close to the plane of the surface
/// and to its normal.
fn directions(count: u32) -> impl Iterator<Item = [Vec3; 3]> {
    let key = StreamKey::new(2, "directions", 0, 0, 0);
    let direction = move |i: u32, block: u32| {
        let [a, b, c, d] = key.words(i, 0, block).map(unit);
        let z = match (4.0 * c) as u32 {
            0 => (2.0 * a - 1.0) * 10_f32.powf(-8.0 * d),
            1 => 1.0 - a * 10_f32.powf(-8.0 * d),
            _ => 2.0 * a - 1.0,
        };
        let (sin, cos) = sin_cos_turns(b);
        let r = (1.0 - z * z).max(0.0).sqrt();
        Vec3::new(r * cos, r * sin, z)
    };
    (0..count).map(move |i| {
        // The normal is the pole of the others.
        let normal = direction(i, 0);
        let [tangent, bitangent] = tangents(normal);
        let about = |d: Vec3| (tangent * d.x + bitangent * d.y + normal * d.z).normalize();
        [normal, about(direction(i, 1)), about(direction(i, 2))]
    })
}

/// The formulas as the papers print them, in double precision: BSDF × cos θ, above the surface.
fn by_the_book(bsdf: &Bsdf, albedo: f64, [n, o, i]: [DVec3; 3]) -> f64 {
    let (viewer, light) = (n.dot(o), n.dot(i));
    let (alpha, eta) = (f64::from(bsdf.alpha), f64::from(bsdf.eta));
    let h = (o + i).normalize();
    // Eq. 33 [Walter2007], with θ from its tangent.
    let tan_squared = n.cross(h).length_squared() / n.dot(h).powi(2);
    let d = alpha.powi(2) / (PI64 * n.dot(h).powi(4) * (alpha.powi(2) + tan_squared).powi(2));
    let lambda = |c: f64| ((1.0 + alpha.powi(2) * (1.0 / (c * c) - 1.0)).sqrt() - 1.0) / 2.0;
    let g = 1.0 / (1.0 + lambda(viewer) + lambda(light));
    // Fresnel by Snell's law, s and p apart.
    let fresnel = |c: f64| {
        let t = (1.0 - (1.0 - c * c) / (eta * eta)).sqrt();
        let s = (c - eta * t) / (c + eta * t);
        let p = (eta * c - t) / (eta * c + t);
        (s * s + p * p) / 2.0
    };
    let mirror = |f: f64| f * d * g / (4.0 * viewer);
    match bsdf.kind {
        LAMBERTIAN => albedo / PI64 * light,
        METAL => mirror(albedo + (1.0 - albedo) * (1.0 - o.dot(h)).powi(5)),
        _ => {
            let below = albedo / (1.0 - albedo * internal_reflectance(eta)) / (eta * eta);
            let enters = (1.0 - fresnel(viewer)) * (1.0 - fresnel(light));
            mirror(fresnel(o.dot(h))) + enters * below / PI64 * light
        }
    }
}

/// What rounding the unit vectors moves is allowed for: 10⁻⁷ against the cosines, and against the
/// width of the lobe in h.
#[test]
fn values_are_those_of_the_papers() {
    for (name, bsdf) in bsdfs() {
        for [normal, to_viewer, anywhere] in directions(4000) {
            let mirror = 2.0 * normal.dot(to_viewer) * normal - to_viewer;
            for to_light in [anywhere, (mirror + bsdf.alpha * anywhere).normalize()] {
                let cosine = normal.dot(to_viewer).min(normal.dot(to_light));
                // Below that, rounding alone decides what is above the surface.
                if cosine < 1e-6 {
                    continue;
                }
                let (value, _) = bsdf.evaluate(Vec3::splat(0.7), normal, to_viewer, to_light);
                let vectors = [normal, to_viewer, to_light].map(|v| v.as_dvec3().normalize());
                let truth = by_the_book(&bsdf, 0.7, vectors);
                let error = f64::from(value.x) / truth - 1.0;
                let width = bsdf.alpha * (to_viewer + to_light).length();
                let allowed = 1e-6 + 3e-7 / cosine + 2e-6 / width;
                assert!(error.abs() < f64::from(allowed), "{name}: {value} {truth} {vectors:?}");
            }
        }
    }
}

#[test]
fn nothing_comes_from_below() {
    for (name, bsdf) in bsdfs() {
        for [normal, to_viewer, to_light] in directions(1000) {
            let (value, density) = bsdf.evaluate(Vec3::ONE, normal, to_viewer, to_light);
            let is_above = normal.dot(to_light) > 0.0
                && (bsdf.kind == LAMBERTIAN || normal.dot(to_viewer) > 0.0);
            assert_eq!(value != Vec3::ZERO, is_above, "{name}");
            assert_eq!(density != 0.0, is_above, "{name}");
        }
    }
}

/// Helmholtz: without its cosine the BSDF is the same both ways.
#[test]
fn light_goes_both_ways() {
    for (name, bsdf) in bsdfs() {
        for [normal, a, b] in directions(2000) {
            let (a_cosine, b_cosine) = (normal.dot(a), normal.dot(b));
            if a_cosine.min(b_cosine) > 0.0 {
                let there = bsdf.evaluate(Vec3::splat(0.7), normal, a, b).0.x / b_cosine;
                let back = bsdf.evaluate(Vec3::splat(0.7), normal, b, a).0.x / a_cosine;
                assert!((there / back - 1.0).abs() < 1e-5, "{name}: {there} {back}");
            }
        }
    }
}

/// χ² of the draws against the density, in rings and sectors of h about the normal; the rings are
/// equal in ln tan θ_h. What no bin holds, with the draws that lead below the surface, is one more.
#[test]
fn draws_follow_their_density() {
    for (index, (name, bsdf)) in bsdfs().into_iter().enumerate() {
        for cosine in COSINES {
            let (normal, to_viewer) = placed(index, cosine);
            let rings = Rings::new(&bsdf, normal, to_viewer);
            let pairs = rings.expected().into_iter().zip(rings.found());
            let large: Vec<(f64, f64)> = pairs.filter(|(mean, _)| *mean > 20.0).collect();
            let all = large.iter().fold([0.0; 2], |[a, b], (mean, n)| [a + mean, b + n]);
            // Quadrature leaves one draw in a thousand open.
            let open = 0.001 * Rings::DRAWS;
            let [expected, found] = all.map(|n| Rings::DRAWS - n);
            assert!(expected > -open, "{name} {cosine}: {expected}");
            let rest = (found - expected).powi(2) / (expected + 2.0 * open);
            let chi_squared: f64 =
                rest + large.iter().map(|(mean, n)| (n - mean).powi(2) / mean).sum::<f64>();
            // A z above 5 comes once in some ten thousand tests; there are 80.
            let freedom = large.len() as f64;
            let z = (chi_squared - freedom) / (2.0 * freedom).sqrt();
            assert!(z < 5.0, "{name} {cosine}: {chi_squared} of {freedom}");
        }
    }
}

/// The bins of one surface and viewer.
struct Rings<'a> {
    bsdf: &'a Bsdf,
    normal: Vec3,
    to_viewer: Vec3,
    /// ln(tan θ_h / α) where the first ring begins, and the width of each.
    first: f64,
    width: f64,
}

impl<'a> Rings<'a> {
    const RINGS: usize = 8;
    const SECTORS: usize = 6;
    const DRAWS: f64 = 20_000.0;

    fn new(bsdf: &'a Bsdf, normal: Vec3, to_viewer: Vec3) -> Self {
        let first = -2.0;
        let width = (3.0 - f64::from(bsdf.alpha).ln() - first) / Self::RINGS as f64;
        Self { bsdf, normal, to_viewer, first, width }
    }

    /// By the midpoint rule over each bin.
    fn expected(&self) -> Vec<f64> {
        const STEPS: usize = 24;
        let [tangent, bitangent] = tangents(self.normal);
        let sector = TAU / Self::SECTORS as f64;
        let middle = |bin: usize, step: usize| bin as f64 + (step as f64 + 0.5) / STEPS as f64;
        let density = |ring: f64, turn: f64| {
            let tan = f64::from(self.bsdf.alpha) * (self.first + self.width * ring).exp();
            let (sin, cos) = (sector * turn).sin_cos();
            let about = tangent * cos as f32 + bitangent * sin as f32;
            let half = (self.normal + about * tan as f32).normalize();
            let half_cosine = self.to_viewer.dot(half);
            let to_light = 2.0 * half_cosine * half - self.to_viewer;
            let (_, density) = self.bsdf.evaluate(Vec3::ONE, self.normal, self.to_viewer, to_light);
            // From steradians of i to those of h, and to the bins' coordinates.
            let per_half = f64::from(4.0 * half_cosine.max(0.0) * density);
            per_half * tan * tan / (1.0 + tan * tan).powf(1.5)
        };
        let bin = |bin: usize| {
            let steps = (0..STEPS * STEPS).map(|step| {
                density(
                    middle(bin / Self::SECTORS, step / STEPS),
                    middle(bin % Self::SECTORS, step % STEPS),
                )
            });
            let mean = steps.sum::<f64>() / (STEPS * STEPS) as f64;
            Self::DRAWS * self.width * sector * mean
        };
        (0..Self::RINGS * Self::SECTORS).map(bin).collect()
    }

    fn found(&self) -> Vec<f64> {
        let key = StreamKey::new(3, "draws", 0, 0, 0);
        let [tangent, bitangent] = tangents(self.normal);
        let mut found = vec![0.0; Self::RINGS * Self::SECTORS];
        for i in 0..Self::DRAWS as u32 {
            let [a, b, ..] = key.words(i, 0, 0);
            let drawn = self.bsdf.sample(Vec3::ONE, self.normal, self.to_viewer, [a, b]);
            let Some(Scattered { direction, .. }) = drawn else { continue };
            let half = self.to_viewer + direction;
            let [x, y, z] = [tangent, bitangent, self.normal].map(|v| f64::from(half.dot(v)));
            let tan = x.hypot(y) / z / f64::from(self.bsdf.alpha);
            let ring = (tan.ln() - self.first) / self.width;
            let turn = (y.atan2(x) / TAU).rem_euclid(1.0);
            if (0.0..Self::RINGS as f64).contains(&ring) {
                let sector = (turn * Self::SECTORS as f64) as usize % Self::SECTORS;
                found[ring as usize * Self::SECTORS + sector] += 1.0;
            }
        }
        found
    }
}

/// Where light comes from everywhere, a white surface sends back what it gets and no more. Rough
/// microfacets lose what they mirror into one another, nearly smooth ones nothing; that a rough coat
/// wins up to a thousandth is the model's doing.
#[test]
fn white_furnace() {
    const DRAWS: u32 = 20_000;
    let key = StreamKey::new(4, "furnace", 0, 0, 0);
    for (index, (name, bsdf)) in bsdfs().into_iter().enumerate() {
        for cosine in COSINES {
            let (normal, to_viewer) = placed(index, cosine);
            let weight = |i: u32| {
                let [a, b, ..] = key.words(i, 0, 0);
                let drawn = bsdf.sample(Vec3::ONE, normal, to_viewer, [a, b]);
                drawn.map_or(0.0, |drawn| f64::from(drawn.weight.x))
            };
            let (sum, squares) = (0..DRAWS)
                .map(weight)
                .fold((0.0, 0.0), |(sum, squares), w| (sum + w, squares + w * w));
            let mean = sum / f64::from(DRAWS);
            let variance = (squares / f64::from(DRAWS) - mean * mean).max(0.0);
            let noise = 5.0 * (variance / f64::from(DRAWS)).sqrt() + 1e-5;
            let won = if bsdf.kind == DIELECTRIC { 0.001 } else { 0.0 };
            assert!(mean < 1.0 + won + noise, "{name} {cosine}: {mean}");
            let is_smooth = bsdf.kind == LAMBERTIAN || 20.0 * bsdf.alpha < cosine.min(0.2);
            assert!(!is_smooth || mean > 0.99, "{name} {cosine}: {mean}");
        }
    }
}

#[test]
fn nothing_is_infinite_or_negative() {
    let key = StreamKey::new(5, "words", 0, 0, 0);
    for (name, bsdf) in bsdfs() {
        for (i, [normal, to_viewer, to_light]) in (0..).zip(directions(10_000)) {
            let [a, b, c, ..] = key.words(i, 0, 0);
            let albedo = [Vec3::ZERO, Vec3::ONE, Vec3::new(0.9, 0.5, 0.1)][i as usize % 3];
            // At random, from straight above, and against the light.
            for to_viewer in [to_viewer, normal, -to_light] {
                let is_sane = |value: Vec3, density: f32| {
                    let all = value.extend(density);
                    all.is_finite() && all.min_element() >= 0.0
                };
                let (value, density) = bsdf.evaluate(albedo, normal, to_viewer, to_light);
                assert!(is_sane(value, density), "{name}: {value} {density}");
                for words in [[a, b], [0; 2], [u32::MAX; 2], [0, c], [c, u32::MAX]] {
                    let Some(drawn) = bsdf.sample(albedo, normal, to_viewer, words) else {
                        continue;
                    };
                    let Scattered { direction, density, weight } = drawn;
                    assert!(is_sane(weight, density), "{name}: {drawn:?}");
                    assert!((direction.length() - 1.0).abs() < 1e-5, "{name}: {drawn:?}");
                    // F·G₂/G₁, which is at most 1.
                    let is_metal = bsdf.kind == METAL;
                    assert!(!is_metal || weight.max_element() < 1.0001, "{name}: {drawn:?}");
                    let (value, again) = bsdf.evaluate(albedo, normal, to_viewer, direction);
                    assert_eq!(density, again, "{name}");
                    let error = (weight * density - value).abs().max_element();
                    assert!(error <= 1e-6 * value.max_element(), "{name}: {drawn:?} {value}");
                }
            }
        }
    }
}

/// As the pipeline has always drawn them.
#[test]
fn lambertian_draws_by_the_cosine_law() {
    let key = StreamKey::new(6, "cosine", 0, 0, 0);
    let (albedo, bsdf) = (Vec3::new(0.9, 0.5, 0.1), Bsdf::new(None));
    for (i, [normal, to_viewer, _]) in (0..).zip(directions(1000)) {
        let [a, b, ..] = key.words(i, 0, 0);
        let direction = cosine_hemisphere(normal, [unit(a), unit(b)]);
        let density = normal.dot(direction).max(0.0) * FRAC_1_PI;
        let expected = Some(Scattered { direction, density, weight: albedo });
        assert_eq!(bsdf.sample(albedo, normal, to_viewer, [a, b]), expected);
    }
}

/// Straight above a mirror, D = 1/(πα²) and f = D/4.
#[test]
fn the_peak_has_its_height() {
    for roughness in ROUGHNESS {
        let bsdf = Bsdf::new(Some(&Coat::Metal { roughness }));
        let (value, density) = bsdf.evaluate(Vec3::ONE, Vec3::Y, Vec3::Y, Vec3::Y);
        let peak = 1.0 / (4.0 * PI64 * roughness.powi(4)) as f32;
        assert!((value.x / peak - 1.0).abs() < 1e-6, "{roughness}: {value}");
        assert!((density / peak - 1.0).abs() < 1e-6, "{roughness}: {density}");
    }
}

/// 4 % straight above glass, all of it along the surface, nothing at Brewster's angle of the light
/// that swings in the plane; and the diffuse reflectance by Walsh's closed form [Walsh1926].
#[test]
fn fresnel_has_its_known_values() {
    assert!((fresnel(1.0, 1.5) - 0.04).abs() < 1e-7);
    assert!((fresnel(0.0, 1.5) - 1.0).abs() < 1e-7);
    // There the rest is ½((η² − 1)/(η² + 1))².
    let brewster = fresnel((1.0 + 1.5_f32 * 1.5).sqrt().recip(), 1.5);
    assert!((brewster - 0.5 * (1.25_f32 / 3.25).powi(2)).abs() < 1e-7, "{brewster}");

    assert!((external_reflectance(1.5) - 0.0918).abs() < 5e-5);
    assert!((internal_reflectance(1.5) - 0.596).abs() < 5e-4);
    for n in [1.01, 1.2, 1.5, 2.0, 3.0_f64] {
        let (n2, n4) = (n * n, n.powi(4));
        let walsh = 0.5
            + (n - 1.0) * (3.0 * n + 1.0) / (6.0 * (n + 1.0).powi(2))
            + n2 * (n2 - 1.0).powi(2) / (n2 + 1.0).powi(3) * ((n - 1.0) / (n + 1.0)).ln()
            - 2.0 * n.powi(3) * (n2 + 2.0 * n - 1.0) / ((n2 + 1.0) * (n4 - 1.0))
            + 8.0 * n4 * (n4 + 1.0) / ((n2 + 1.0) * (n4 - 1.0).powi(2)) * n.ln();
        let ours = external_reflectance(n);
        assert!((ours - walsh).abs() < 1e-6, "{n}: {ours} {walsh}");
    }
}
