//! What the methods have in common: in local illumination all show the same.

#[cfg(feature = "gpu")]
mod adapters;
mod golden;
mod lens;

use super::{OpenDevice, Pipeline};
use glam::Vec3;
use shutterlab_stimuli::assets::{Asset, Kind};
use shutterlab_stimuli::scene::{
    CameraMotion, Environment, Illumination, Light, Material, Motion, Object, Rotation, Shape,
};
use shutterlab_stimuli::stimulus::{Method, Sampler, Trajectory};
use shutterlab_stimuli::{Grid, LinearImage, Selection, Stimulus};
use std::fmt::Write;
use std::path::Path;

const WIDTH: u32 = 64;
const HEIGHT: u32 = 48;

const STILL: Motion =
    Motion { speed_m_per_s: None, translation: None, rotation: None, deformation: None };

/// A model as OBJ: squares of a grid of `n` by `n`, bent by `shape`, with texture coordinates.
fn sheet(n: usize, shape: impl Fn(f32, f32) -> Vec3) -> String {
    let mut text = String::new();
    for j in 0..=n {
        for i in 0..=n {
            let (u, v) = (i as f32 / n as f32, j as f32 / n as f32);
            let Vec3 { x, y, z } = shape(u, v);
            writeln!(text, "v {x} {y} {z}\nvt {u} {v}").unwrap();
        }
    }
    for j in 0..n {
        for i in 0..n {
            let at = 1 + i + j * (n + 1);
            let corners = [at, at + 1, at + n + 2, at + n + 1];
            let [a, b, c, d] = corners.map(|corner| format!("{corner}/{corner}"));
            writeln!(text, "f {a} {b} {c} {d}").unwrap();
        }
    }
    text
}

fn ball(radius: f32) -> String {
    sheet(24, |u, v| {
        let (sin_phi, cos_phi) = (u * std::f32::consts::TAU).sin_cos();
        let (sin_theta, cos_theta) = (v * std::f32::consts::PI).sin_cos();
        radius * Vec3::new(sin_theta * cos_phi, -cos_theta, -sin_theta * sin_phi)
    })
}

/// Thin needles side by side.
fn comb() -> String {
    let mut text = String::new();
    for k in 0..40 {
        let x = -0.6 + 0.03 * k as f32;
        let first = 3 * k + 1;
        writeln!(text, "v {x} -0.5 0\nv {} -0.5 0\nv {} 0.5 0.1", x + 0.012, x + 0.006).unwrap();
        writeln!(text, "vt 0 0\nvt 1 0\nvt 0 1").unwrap();
        writeln!(text, "f {first}/{first} {}/{} {}/{}", first + 1, first + 1, first + 2, first + 2)
            .unwrap();
    }
    text
}

/// A moving model before black, lit by two lamps, in a checker that follows its texture coordinates.
fn scene(assets: &Path, name: &str, model: &str, motion: Motion) -> Stimulus {
    let mut grid = Grid::load("rolling-sphere-mono").unwrap();
    (grid.image.width_px, grid.image.height_px) = (WIDTH, HEIGHT);
    let selection =
        Selection::parse(&["material=checker,speed=S2,shutter=T5,samples=A1"], &grid).unwrap();
    let mut stimulus = grid.stimuli(&selection).unwrap().remove(0);
    let source = assets.join(name);
    std::fs::write(&source, model).unwrap();
    let asset = Asset::open(&source, Kind::Model).unwrap();
    asset.keep(assets).unwrap();
    let scene = &mut stimulus.scene;
    scene.illumination = Illumination::Local;
    scene.environment = Environment::Uniform([0.0; 3]);
    scene.lights = vec![
        Light::Directional { direction: [0.3, -0.5, -1.0], irradiance: [2.0, 1.8, 1.5] },
        Light::Point { position_m: [2.0, 1.0, 2.0], intensity: [1.0, 2.0, 4.0] },
    ];
    scene.camera.position_m = [0.0, 0.0, 3.0];
    scene.camera.look_at_m = [0.0, 0.0, 0.0];
    scene.objects = vec![Object {
        name: "model".into(),
        shape: Shape::Mesh { file: name.into(), sha256: asset.sha256, radius_m: None },
        position_m: [0.0; 3],
        orientation: None,
        material: Some(Material::Checker { cells: 6, light: 0.8, dark: 0.1, coat: None }),
        motion: Some(motion),
    }];
    stimulus.trajectory = Trajectory::Once;
    stimulus.sampler = Sampler::Sobol;
    stimulus
}

/// Translation, rotation, approach, what goes through the camera's plane, what is thinner than a pixel, and the first
/// before a lens.
fn scenes(assets: &Path) -> Vec<(&'static str, Stimulus)> {
    let along = |direction: [f64; 3], speed: f64| Motion {
        speed_m_per_s: Some(speed),
        translation: Some(direction),
        ..STILL
    };
    let turning = Motion {
        speed_m_per_s: Some(20.0),
        rotation: Some(Rotation { axis: [0.2, 0.1, 1.0], radius_m: 0.6 }),
        ..STILL
    };
    let ground = sheet(8, |u, v| Vec3::new(4.0 * u - 2.0, -0.3 - 0.1 * u, 8.0 * v - 4.0));
    let mut passing = scene(assets, "ground.obj", &ground, along([0.0, 0.0, 1.0], 15.0));
    passing.scene.camera.motion = Some(CameraMotion {
        speed_m_per_s: Some(1.0),
        position: [0.5, 0.0, 0.0],
        look_at: [0.0, 2.0, 0.0],
    });
    let crossing = scene(assets, "ball.obj", &ball(0.6), along([1.0, 0.3, 0.0], 20.0));
    // Circles of confusion of up to five pixels, at the rim of the ball; its front is in focus.
    let mut lens = crossing.clone();
    let camera = &mut lens.scene.camera;
    (camera.aperture_f_number, camera.focus_distance_m) = (Some(0.05), Some(2.4));
    vec![
        ("translation", crossing),
        (
            "rotation",
            scene(
                assets,
                "bar.obj",
                &sheet(6, |u, v| Vec3::new(1.6 * u - 0.8, 0.5 * v - 0.25, 0.1 * u)),
                turning,
            ),
        ),
        ("approach", scene(assets, "near.obj", &ball(0.5), along([0.1, 0.0, 1.0], 40.0))),
        ("near plane", passing),
        ("thin", scene(assets, "comb.obj", &comb(), along([0.4, 0.1, 0.0], 10.0))),
        ("lens", lens),
    ]
}

fn image(
    stimulus: &Stimulus,
    method: Method,
    samples: u32,
    seed: u64,
    assets: &Path,
) -> LinearImage {
    let mut pipeline = OpenDevice::Cpu.pipeline(method, assets);
    image_by(&mut *pipeline, &Stimulus { method, samples, seed, ..stimulus.clone() })
}

fn image_by(pipeline: &mut dyn Pipeline, stimulus: &Stimulus) -> LinearImage {
    // The frame in which half of the sequence has passed.
    let view = stimulus.views(60).remove(0);
    pipeline.films(stimulus, &view, 60, &[stimulus.samples]).unwrap().remove(0).image()
}

/// RMS of the difference, over that of the truth.
fn relative_difference(image: &LinearImage, truth: &LinearImage) -> f64 {
    let power: f64 = values(truth).map(|value| value * value).sum();
    let pairs = values(image).zip(values(truth));
    (pairs.map(|(a, b)| (a - b).powi(2)).sum::<f64>() / power).sqrt()
}

fn values(image: &LinearImage) -> impl Iterator<Item = f64> + Clone {
    image.pixels.iter().flatten().map(|&value| f64::from(value))
}

/// RMS bias of images against the truth, over the truth's RMS. Each image and either truth has noise of its own: the
/// product of the differences of two images to one truth each has the squared bias as its mean, and no noise.
fn bias(images: &[LinearImage], truths: &[LinearImage; 2]) -> f64 {
    let power: f64 = values(&truths[0]).zip(values(&truths[1])).map(|(t, u)| t * u).sum();
    let mut products = vec![];
    for (k, a) in images.iter().enumerate() {
        for b in &images[k + 1..] {
            let [a, b] = [(a, &truths[0]), (b, &truths[1])].map(|(i, t)| values(i).zip(values(t)));
            products.push(a.zip(b).map(|((x, t), (y, u))| (x - t) * (y - u)).sum::<f64>() / power);
        }
    }
    (products.iter().sum::<f64>() / products.len() as f64).max(0.0).sqrt()
}

/// Below 1 % at 1,024 samples. The accumulation buffer has one set of instants for all pixels, so that its noise does not
/// average out over them, but over many sets.
#[test]
fn all_methods_converge_to_one_image() {
    let assets = tempfile::tempdir().unwrap();
    for (name, stimulus) in scenes(assets.path()) {
        let of = |method, samples, seed| image(&stimulus, method, samples, seed, assets.path());
        // Few samples meet what is thin.
        let rays = if name == "thin" { 16_384 } else { 4096 };
        let truths = [11, 12].map(|seed| of(Method::DistributionRayTracing, rays, seed));
        assert!(values(&truths[0]).sum::<f64>() > 10.0, "{name}");
        for (method, sets) in
            [(Method::AccumulationBuffer, 8), (Method::StochasticRasterization, 2)]
        {
            let images: Vec<_> = (0..sets).map(|set| of(method, 1024, 31 + set)).collect();
            let bias = bias(&images, &truths);
            assert!(bias < 0.01, "{name}, {method}: {bias}");
        }
    }
}

/// With the same samples as rays the rasterizer sees the same, but for samples whose instants are within a hair of an
/// edge, and turning points whose arcs are chains of chords.
#[test]
fn stochastic_rasterization_sees_what_the_same_rays_see() {
    let assets = tempfile::tempdir().unwrap();
    for (name, stimulus) in scenes(assets.path()) {
        let of = |method| image(&stimulus, method, 64, 1, assets.path());
        let (rays, raster) =
            (of(Method::DistributionRayTracing), of(Method::StochasticRasterization));
        let error = relative_difference(&raster, &rays);
        assert!(error < 0.03, "{name}: {error}");
    }
}

/// Four times the images: a quarter of the error and better where they are evenly spread, half of it by chance.
#[test]
fn errors_fall_as_they_should() {
    let assets = tempfile::tempdir().unwrap();
    let (_, stimulus) = scenes(assets.path()).remove(0);
    let truth = image(&stimulus, Method::DistributionRayTracing, 16_384, 5, assets.path());
    let error = |method, sampler, samples| {
        let stimulus = Stimulus { sampler, ..stimulus.clone() };
        let found = image(&stimulus, method, samples, 7, assets.path());
        values(&found).zip(values(&truth)).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
    };
    for (method, sampler, range) in [
        (Method::AccumulationBuffer, Sampler::Sobol, 2.2..6.0),
        (Method::StochasticRasterization, Sampler::Random, 1.8..2.2),
        (Method::StochasticRasterization, Sampler::Sobol, 2.2..6.0),
    ] {
        let [few, some, many] = [16, 64, 256].map(|samples| error(method, sampler, samples));
        for ratio in [few / some, some / many] {
            assert!(range.contains(&ratio), "{method} {sampler:?}: {few} {some} {many}");
        }
    }
}
