//! What the pipeline must satisfy on either device: outside truth, convergence, and the twins'
//! agreement. Random images are tested by their mean and variance.

mod scenes;

use super::reference;
use crate::film::{Film, measure};
use crate::pipelines::frame::Frame;
use crate::scene::environment::{
    Environment, SUN_DIRECTION, SUN_RADIANCE, SUN_SHARPNESS, luminance,
};
use crate::scene::world::World;
use shutterlab_stimuli::scene::{self, BuiltIn, Material};
use shutterlab_stimuli::stereo::{Convergence, EyeNoise, Layout, Stereo};
use shutterlab_stimuli::stimulus::{Sampler, ShutterProfile, View};
use shutterlab_stimuli::{Grid, LinearImage, Selection, Stimulus};
use std::path::Path;

const WIDTH: u32 = 96;
const HEIGHT: u32 = 54;

/// The cell of the thesis's grid with these levels, small.
fn stimulus(select: &str) -> Stimulus {
    let mut grid = Grid::load("rolling-sphere-mono").unwrap();
    (grid.image.width_px, grid.image.height_px) = (WIDTH, HEIGHT);
    let selection = Selection::parse(&[select], &grid).unwrap();
    grid.stimuli(&selection).unwrap().remove(0)
}

fn constant(albedo: f64) -> Material {
    Material::Constant { albedo: [albedo; 3], coat: None }
}

/// Gives the floor another albedo.
fn paint_floor(stimulus: &mut Stimulus, albedo: f64) {
    stimulus.scene.objects[1].material = Some(constant(albedo));
}

/// With random samples, whose variance a film tells.
fn checker() -> Stimulus {
    let sampler = Sampler::Random;
    Stimulus { sampler, ..stimulus("material=checker,speed=S2,shutter=T5,samples=A3") }
}

fn on_cpu(stimulus: &Stimulus, frame: u32) -> Film {
    let Set { frame, world, environment } = set(stimulus, frame);
    film(reference::trace(&frame, &world, &environment, &[stimulus.samples]))
}

/// All that tracing a frame needs.
struct Set {
    frame: Frame,
    world: World,
    environment: Environment,
}

/// Frame number `frame` as the (left) eye sees it.
fn set(stimulus: &Stimulus, frame: u32) -> Set {
    set_of_view(stimulus, &stimulus.views(frame)[0], frame, Path::new(""))
}

/// With files from `assets`.
fn set_of_view(stimulus: &Stimulus, view: &View, frame: u32, assets: &Path) -> Set {
    let world = World::load(stimulus, assets).unwrap();
    Set {
        frame: Frame::new(stimulus, &world, view, frame),
        environment: Environment::load(&stimulus.scene.environment, assets).unwrap(),
        world,
    }
}

/// The one film of one number of samples.
fn film(mut films: Vec<Film>) -> Film {
    assert_eq!(films.len(), 1);
    films.remove(0)
}

/// A device's name and how it traces.
type NamedDevice = (&'static str, Box<dyn FnMut(&Set, &[u32]) -> Vec<Film>>);

/// The devices of this build: the processor, and a graphics adapter where there is one. With
/// `SHUTTERLAB_REQUIRE_GPU` set, not finding one is a failure.
fn devices() -> Vec<NamedDevice> {
    let on_cpu = |set: &Set, samples: &[u32]| {
        reference::trace(&set.frame, &set.world, &set.environment, samples)
    };
    #[cfg_attr(not(feature = "gpu"), expect(unused_mut, reason = "only an adapter is added"))]
    let mut devices: Vec<NamedDevice> = vec![("cpu", Box::new(on_cpu))];
    #[cfg(feature = "gpu")]
    match crate::gpu::device::Gpu::open() {
        Ok(gpu) => {
            use super::compute::Tracer;
            use crate::pipelines::on_gpu::Shown;
            use crate::pipelines::resources::{EnvironmentBuffers, WorldBuffers};
            let mut tracer = Tracer::default();
            devices.push((
                "gpu",
                Box::new(move |Set { frame, world, environment }, samples| {
                    let environment = &EnvironmentBuffers::new(&gpu, environment).unwrap();
                    let world_buffers = &WorldBuffers::new(&gpu, world).unwrap();
                    let shown = Shown { gpu: &gpu, frame, world, world_buffers, environment };
                    tracer.trace(&shown, samples).unwrap()
                }),
            ));
        }
        Err(error) => assert!(std::env::var_os("SHUTTERLAB_REQUIRE_GPU").is_none(), "{error}"),
    }
    devices
}

/// Renders on every device.
fn on_all(stimulus: &Stimulus, frame: u32) -> Vec<(&'static str, Film)> {
    let set = set(stimulus, frame);
    let samples = [stimulus.samples];
    let trace = |(name, mut trace): NamedDevice| (name, film(trace(&set, &samples)));
    devices().into_iter().map(trace).collect()
}

/// Mean of z² over the pixels, and the largest |z|, for the difference of two films.
fn z_scores(a: &Film, b: &Film) -> (f64, f64) {
    let pairs = a.luminance_statistics().into_iter().zip(b.luminance_statistics());
    let z: Vec<f64> = pairs
        .map(|((mean_a, variance_a), (mean_b, variance_b))| {
            // Rounding alone moves a mean by about 10⁻⁷ of itself.
            let rounding = (1e-6 * mean_a).powi(2);
            (mean_a - mean_b) / (variance_a + variance_b + rounding).sqrt()
        })
        .collect();
    let mean_square = z.iter().map(|z| z * z).sum::<f64>() / z.len() as f64;
    (mean_square, z.iter().fold(0.0, |largest, z| z.abs().max(largest)))
}

fn mean_of(image: &LinearImage, xs: std::ops::Range<u32>, ys: std::ops::Range<u32>) -> [f64; 3] {
    let count = f64::from((xs.end - xs.start) * (ys.end - ys.start));
    let mut mean = [0.0; 3];
    for y in ys {
        for x in xs.clone() {
            let pixel = image.pixels[(y * image.width + x) as usize];
            (0..3).for_each(|c| mean[c] += f64::from(pixel[c]) / count);
        }
    }
    mean
}

/// One sample stream, two implementations: relative RMSE ≤ 10⁻³, and at most 0.1 % of the pixels
/// differ by more than 1/255. Every material, sampler, shutter and eye takes its turn.
#[test]
fn the_twins_agree() {
    let plain = |select: &str| stimulus(&format!("{select},speed=S3,samples=A2"));
    let moving = || plain("material=checker,shutter=T5");
    let trapezoid = ShutterProfile::Trapezoid { ramp_fraction: 0.2 };
    let gaussian = ShutterProfile::Gaussian { sigma_fraction: 0.15 };
    let stereo = Stereo {
        interocular_mm: 65.0,
        convergence: Convergence::OffAxis,
        noise: EyeNoise::Independent,
        layout: Layout::SideBySide,
    };
    let cases = [
        plain("material=flat,shutter=T1"),
        plain("material=noise,shutter=T3"),
        moving(),
        Stimulus { sampler: Sampler::Random, ..moving() },
        Stimulus { sampler: Sampler::Stratified, ..moving() },
        Stimulus { shutter_profile: trapezoid, ..moving() },
        Stimulus { shutter_profile: gaussian, stereo: Some(stereo), ..moving() },
    ];
    let mut devices = devices();
    for stimulus in cases {
        for view in stimulus.views(63) {
            let set = set_of_view(&stimulus, &view, 63, Path::new(""));
            let mut images =
                devices.iter_mut().map(|(_, trace)| film(trace(&set, &[stimulus.samples])).image());
            let truth = images.next().unwrap();
            for image in images {
                let error = measure::relative_mse(&image, &truth, 0.004).sqrt();
                let others = measure::differing(&image, &truth, 1.0 / 255.0);
                assert!(error <= 1e-3 && others <= 1e-3, "{stimulus:?}: {error} {others}");
            }
        }
    }
}

/// Every sampler gives the image that random samples give. z² is taken with the variance of the random
/// film alone, so it is 1 and what the sampler's own error adds: for random samples another 1, for the
/// others much less, which is what they are for.
#[test]
fn samplers_agree_and_lessen_the_error() {
    let random = checker();
    let other_seed = Stimulus { seed: random.seed + 1, ..random.clone() };
    let truth = on_cpu(&other_seed, 60);
    for (sampler, added) in
        [(Sampler::Random, 0.9..1.1), (Sampler::Stratified, 0.0..0.4), (Sampler::Sobol, 0.0..0.3)]
    {
        let image = on_cpu(&Stimulus { sampler, ..random.clone() }, 60).image();
        let z_squared = truth.luminance_statistics().into_iter().zip(&image.pixels).map(
            |((mean, variance), pixel)| {
                let difference = mean - f64::from(luminance(glam::Vec3::from(*pixel)));
                difference.powi(2) / (variance + (1e-6 * mean).powi(2))
            },
        );
        let mean = z_squared.sum::<f64>() / image.pixels.len() as f64;
        assert!((1.0 + added.start - 0.1..1.0 + added.end).contains(&mean), "{sampler:?}: {mean}");
    }
}

/// Other seeds, other noise, the same image. Šidák: with 5184 pixels, |z| > 5.3 comes by chance in
/// one run of two thousand; the mean of z² has a standard error of 0.02.
#[test]
fn independent_seeds_and_devices_agree() {
    let stimulus = checker();
    let truth = on_cpu(&Stimulus { seed: stimulus.seed + 1, ..stimulus.clone() }, 60);
    for (device, film) in on_all(&stimulus, 60) {
        let (mean_square, largest) = z_scores(&film, &truth);
        assert!(
            (mean_square - 1.0).abs() < 0.1 && largest < 5.3,
            "{device}: {mean_square} {largest}"
        );
    }
}

/// The test above can fail: a floor of 0.515 in place of 0.5 is told apart.
#[test]
fn a_wrong_albedo_is_noticed() {
    let stimulus = checker();
    let mut other = Stimulus { seed: 1, ..stimulus.clone() };
    paint_floor(&mut other, 0.515);
    let (mean_square, _) = z_scores(&on_cpu(&stimulus, 60), &on_cpu(&other, 60));
    assert!(mean_square > 1.1, "{mean_square}");
}

/// All-white surfaces under the same light from everywhere are invisible, but for what the paths
/// of more than five hits would have brought: nothing but the crevice below the sphere has any.
#[test]
fn white_furnace() {
    let mut stimulus = checker();
    stimulus.scene.environment = scene::Environment::Uniform([1.0; 3]);
    paint_floor(&mut stimulus, 1.0);
    stimulus.material = constant(1.0);
    for (device, film) in on_all(&stimulus, 60) {
        let statistics = film.luminance_statistics();
        let mean = statistics.iter().map(|(mean, _)| mean).sum::<f64>() / statistics.len() as f64;
        assert!((0.999..1.0005).contains(&mean), "{device}: {mean}");
        let off = |sign: f64| {
            let away =
                |(mean, variance): &&(f64, f64)| sign * (mean - 1.0) > 5.3 * variance.sqrt() + 1e-6;
            statistics.iter().filter(away).count()
        };
        assert!(
            off(1.0) == 0 && off(-1.0) <= 10,
            "{device}: {} above, {} below",
            off(1.0),
            off(-1.0)
        );
    }
}

/// Far from the sphere the floor is ρ/π·E, with the irradiance of a lobe L·e^{k(cos θ − 1)} about
/// the sun's direction s: E = 2πL·s_y·(1/k − 1/k²), for k ≫ 1.
#[test]
fn the_sun_alone_gives_its_analytic_irradiance() {
    let mut stimulus = checker();
    stimulus.scene.environment = scene::Environment::BuiltIn(BuiltIn::SunOnly);
    let k = SUN_SHARPNESS;
    let per_radiance = 0.5 * 2.0 * SUN_DIRECTION.y * (1.0 / k - 1.0 / (k * k));
    for (device, film) in on_all(&stimulus, 60) {
        let mean = mean_of(&film.image(), 0..WIDTH, HEIGHT - 8..HEIGHT);
        for c in 0..3 {
            let expected = per_radiance * SUN_RADIANCE[c];
            assert!((mean[c] / expected - 1.0).abs() < 2e-3, "{device}: {} {expected}", mean[c]);
        }
    }
}

/// Unshadowed floor under the clear sky, from an outside computation.
#[test]
fn the_floor_under_the_clear_sky_has_its_known_radiance() {
    for (device, film) in on_all(&checker(), 60) {
        let mean = mean_of(&film.image(), 0..WIDTH, HEIGHT - 8..HEIGHT);
        for (mean, known) in mean.iter().zip([0.31126, 0.35947, 0.52819]) {
            assert!((mean / known - 1.0).abs() < 5e-3, "{device}: {mean} {known}");
        }
    }
}

/// Four times the samples, a quarter of the squared error against a converged image.
#[test]
fn variance_falls_as_one_over_n() {
    let with = |samples: u32, seed: u64| Stimulus { samples, seed, ..checker() };
    let (_, truth) = on_all(&with(4096, 1), 60).pop().unwrap();
    let truth = truth.image();
    let error = |samples: u32| {
        let image = on_cpu(&with(samples, 2), 60).image();
        let squares =
            image.pixels.iter().zip(&truth.pixels).map(|(a, b)| f64::from(a[1] - b[1]).powi(2));
        squares.sum::<f64>() / image.pixels.len() as f64
    };
    let (few, some, many) = (error(4), error(16), error(64));
    assert!((3.4..4.6).contains(&(few / some)), "{few} {some}");
    assert!((3.4..4.6).contains(&(some / many)), "{some} {many}");
}

/// With the shutter at 0 % the speed leaves no trace; with 100 % it does.
#[test]
fn a_closed_shutter_is_one_instant() {
    let at = |speed: &str, shutter: &str| Stimulus {
        noise_stream: String::new(),
        ..stimulus(&format!("material=checker,speed={speed},shutter={shutter},samples=A1"))
    };
    // Frame 60 has the sphere in the middle, not yet rolled, at every speed.
    assert_eq!(on_cpu(&at("S1", "T1"), 60), on_cpu(&at("S3", "T1"), 60));
    assert_ne!(on_cpu(&at("S1", "T5"), 60), on_cpu(&at("S3", "T5"), 60));
}

/// A white sphere over black floor: the centroid of its light stays where the instant frame has it,
/// however long the shutter is open. The centroid's standard error is 0.02 pixels; a shutter that
/// opened at the frame's time instead of around it would move it by 1.7.
#[test]
fn the_centre_does_not_move_with_the_shutter() {
    let centroid = |shutter: &str, frame: u32| {
        let mut stimulus =
            stimulus(&format!("material=flat,speed=S3,shutter={shutter},samples=A5"));
        stimulus.scene.environment = scene::Environment::Uniform([1.0; 3]);
        paint_floor(&mut stimulus, 0.0);
        let film = on_cpu(&stimulus, frame);
        // Below the horizon, where only the sphere shines.
        let lit =
            film.sums.iter().enumerate().filter(|(index, _)| *index as u32 / WIDTH > HEIGHT / 4);
        let (mut weight, mut moment) = (0.0, 0.0);
        for (index, sum) in lit {
            let light = f64::from(luminance(sum.truncate()));
            weight += light;
            moment += light * (f64::from(index as u32 % WIDTH) + 0.5);
        }
        moment / weight
    };
    for shutter in ["T1", "T2", "T3", "T4", "T5"] {
        let middle = centroid(shutter, 60);
        assert!((middle - f64::from(WIDTH) / 2.0).abs() < 0.1, "{shutter}: {middle}");
        let (aside, instant) = (centroid(shutter, 66), centroid("T1", 66));
        assert!(
            (aside - instant).abs() < 0.15 && aside > middle + 10.0,
            "{shutter}: {aside} {instant}"
        );
    }
}

/// Samples are numbered, not drawn in turn: sample by sample they add up to the very same film, and
/// so any prefix is what a run with that many samples gives.
#[test]
fn a_prefix_of_samples_equals_a_run_with_that_many() {
    let stimulus = checker();
    let set = set(&stimulus, 60);
    let from = |first_sample: u32| {
        let mut part = self::set(&stimulus, 60);
        part.frame.params.first_sample = first_sample;
        part
    };
    for (device, mut trace) in devices() {
        let mut sums = vec![glam::Vec4::ZERO; (WIDTH * HEIGHT) as usize];
        for first_sample in 0..5 {
            let one = film(trace(&from(first_sample), &[1]));
            sums.iter_mut().zip(&one.sums).for_each(|(sum, one)| *sum += *one);
        }
        let films = trace(&set, &[3, 3, 5]);
        assert!(films[2].sums == sums, "{device}");
        assert!(films[1] == film(trace(&set, &[3])), "{device}");
    }
}

/// More samples than one dispatch takes are still the same film.
#[test]
fn dispatches_join_without_a_seam() {
    let stimulus = checker();
    let set = set(&stimulus, 60);
    let mut rest_of_set = self::set(&stimulus, 60);
    rest_of_set.frame.params.first_sample = 64;
    for (device, mut trace) in devices() {
        let whole = film(trace(&set, &[130]));
        let first = film(trace(&set, &[64]));
        let rest = film(trace(&rest_of_set, &[66]));
        let close = whole.sums.iter().zip(first.sums.iter().zip(&rest.sums)).all(
            |(whole, (first, rest))| {
                (*whole - (*first + *rest)).abs().max_element() <= 1e-5 * whole.max_element()
            },
        );
        assert!(close, "{device}");
    }
}
