//! `shutterlab bench motion-blur`: how much faster models are rendered with motion blur once they are simplified, and
//! how far the images are off: Table 1 and Figure 7 of Zhang et al. (2014).

mod report;
mod scene;

use crate::cli::UsageError;
use crate::cli::render::{Device, parse_size};
use crate::film::measure::relative_mse;
use crate::mesh::Mesh;
use crate::mesh::simplify::{Options, simplify};
use crate::render::Renderer;
use crate::scene::import;
use crate::scene::screen_motion::framing;
use anyhow::anyhow;
use indicatif::{ProgressBar, ProgressFinish, ProgressStyle};
use scene::Stage;
use serde::Serialize;
use shutterlab_stimuli::stimulus::Method;
use shutterlab_stimuli::{LinearImage, Render, Stimulus};
use std::path::PathBuf;
use std::time::{Duration, Instant};

/// The paper's speeds, Speed-1 to Speed-4, in pixels per shutter.
const SPEEDS_PX: [u32; 4] = [10, 30, 90, 270];

/// The parts of its faces that the paper's bunny has at these speeds.
const PARTS: [f64; 4] = [0.4, 0.2, 0.1, 0.04];

/// Samples per pixel as the paper has them; the accumulation buffer's follow the speed.
const RAYS: u32 = 64;
const STOCHASTIC_SAMPLES: u32 = 32;
const IMAGES: [u32; 4] = [16, 48, 144, 432];

/// Frames that one simplification serves, in the ratio that includes its time.
const FRAMES: f64 = 100.0;

/// The field of view of the paper's images.
const FIELD_OF_VIEW_DEG: f64 = 33.33;

/// Render models and their simplified versions at the paper's four speeds by three methods: times, speed-up ratios,
/// image errors
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Models: .ply, .obj, .gltf, .glb or .stl
    #[arg(required = true)]
    models: Vec<PathBuf>,
    /// Write motion-blur.csv and a figure per method into this folder
    #[arg(short, long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Size of the images
    #[arg(long, value_name = "WxH", default_value = "800x600", value_parser = parse_size)]
    size: [u32; 2],
    /// What renders
    #[arg(long, value_enum, default_value = "auto")]
    device: Device,
    /// Take the median of so many times
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=100))]
    runs: u32,
    /// Parts of its faces that a model keeps at the four speeds; those of the paper's bunny if not said
    #[arg(long, value_name = "R,R,R,R", value_parser = parse_parts)]
    ratios: Option<[f64; 4]>,
}

/// A model at a speed by a method.
#[derive(Clone, Debug, Serialize)]
struct Row {
    model: String,
    faces: usize,
    simplified_faces: usize,
    px_per_shutter: u32,
    method: String,
    device: String,
    samples: u32,
    /// Of one frame, with the original model and with the simplified one.
    seconds: f64,
    simplified_seconds: f64,
    /// Of one frame of a model of one triangle that is not in view.
    empty_seconds: f64,
    simplification_seconds: f64,
    /// (original − simplified)/simplified.
    speedup: f64,
    /// The same over a hundred frames, with the simplification.
    speedup_with_simplification: f64,
    /// The same of what exceeds the time of an empty frame; nothing if that is lost in it.
    speedup_above_empty: Option<f64>,
    /// Relative RMSE of the simplified model's image against the original's by the same method.
    relative_rmse: f64,
}

pub(in crate::cli) fn run(args: &Args) -> anyhow::Result<()> {
    if let Some(out) = &args.out {
        std::fs::create_dir_all(out).map_err(|error| anyhow!("{}: {error}", out.display()))?;
    }
    let folder = tempfile::tempdir()?;
    let renderer = Renderer::open(args.device.into(), folder.path());
    let mut renderer = renderer.map_err(|error| anyhow!(error))?;
    let bar = ProgressBar::new((args.models.len() * SPEEDS_PX.len() * Method::ALL.len()) as u64);
    if let Ok(style) = ProgressStyle::with_template("{msg} [{bar:30}] {pos}/{len} {eta} left") {
        bar.set_style(style.progress_chars("=> "));
    }
    let bar = bar.with_finish(ProgressFinish::AndClear);
    bar.enable_steady_tick(Duration::from_millis(200));
    let mut rows = vec![];
    for model in &args.models {
        let name = model.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let mesh = import::model(model)?.mesh;
        let (middle, radius) = mesh.bounding_sphere();
        if radius == 0.0 {
            return Err(UsageError::from(format!("bench: {}: all in one point", model.display())));
        }
        let camera = framing(middle.as_dvec3(), radius.into(), args.size, FIELD_OF_VIEW_DEG);
        let stage = Stage::new(folder.path(), &camera, args.size)?;
        let original = stage.keep("original.ply", &mesh)?;
        let empty = stage.keep("empty.ply", &behind(&mesh))?;
        for (k, px_per_shutter) in SPEEDS_PX.into_iter().enumerate() {
            let faces =
                ((args.ratios.unwrap_or(PARTS)[k] * mesh.triangles.len() as f64) as usize).max(1);
            let started = Instant::now();
            let simplified = simplify(&mesh, None, &Options { faces, ..Options::default() })
                .map_err(|error| anyhow!("{}: {error}", model.display()))?;
            let simplification_seconds = started.elapsed().as_secs_f64();
            let kept = stage.keep("simplified.ply", &simplified.mesh)?;
            for (method_name, method) in Method::ALL {
                bar.set_message(format!("{name} {px_per_shutter} px {method_name}"));
                let samples = match method {
                    Method::DistributionRayTracing => RAYS,
                    Method::AccumulationBuffer => IMAGES[k],
                    Method::StochasticRasterization => STOCHASTIC_SAMPLES,
                };
                let stimulus = |of: &_| stage.stimulus(of, method, px_per_shutter, samples);
                let mut timed = |of: &_| time(&mut renderer, &stimulus(of), args.runs);
                let (empty_seconds, _) = timed(&empty)?;
                let (simplified_seconds, image) = timed(&kept)?;
                let (seconds, truth) = timed(&original)?;
                let net = simplified_seconds - empty_seconds;
                rows.push(Row {
                    model: name.clone(),
                    faces: mesh.triangles.len(),
                    simplified_faces: simplified.mesh.triangles.len(),
                    px_per_shutter,
                    method: method_name.into(),
                    device: renderer.device(&stimulus(&original)).kind,
                    samples,
                    seconds,
                    simplified_seconds,
                    empty_seconds,
                    simplification_seconds,
                    speedup: (seconds - simplified_seconds) / simplified_seconds,
                    speedup_with_simplification: FRAMES * seconds
                        / (FRAMES * simplified_seconds + simplification_seconds)
                        - 1.0,
                    speedup_above_empty: (net > 0.05 * simplified_seconds)
                        .then(|| (seconds - simplified_seconds) / net),
                    relative_rmse: relative_rmse(&image, &truth),
                });
                bar.inc(1);
            }
        }
    }
    bar.finish_and_clear();
    report::give(&rows, args.out.as_deref())
}

/// A triangle of the size of the mesh, where no camera looks.
fn behind(mesh: &Mesh) -> Mesh {
    let (middle, radius) = mesh.bounding_sphere();
    let far = middle + 1e3 * radius * glam::Vec3::Z;
    let positions = vec![far, far + radius * glam::Vec3::X, far + radius * glam::Vec3::Y];
    Mesh { positions, triangles: vec![[0, 1, 2]], ..Mesh::default() }
}

/// Median seconds of a frame, after a first one that loads and compiles, and its image.
fn time(
    renderer: &mut Renderer,
    stimulus: &Stimulus,
    runs: u32,
) -> anyhow::Result<(f64, LinearImage)> {
    let mut frame = |samples: u32| {
        let images = renderer.render(stimulus, scene::FRAME, &[samples]);
        images.map_err(|error| anyhow!(error)).map(|mut images| images.remove(0).remove(0))
    };
    frame(1)?;
    let mut times = vec![];
    let mut image = None;
    for _ in 0..runs {
        let started = Instant::now();
        image = Some(frame(stimulus.samples)?);
        times.push(started.elapsed().as_secs_f64());
    }
    times.sort_by(f64::total_cmp);
    let image = image.ok_or_else(|| anyhow!("no frame was rendered"))?;
    Ok((times[times.len() / 2], image))
}

/// Relative RMSE, with 1 % of the mean of what is not black.
fn relative_rmse(image: &LinearImage, truth: &LinearImage) -> f64 {
    let lit = || truth.pixels.iter().flatten().filter(|&&value| value > 0.0);
    let mean = lit().map(|&value| f64::from(value)).sum::<f64>() / lit().count().max(1) as f64;
    relative_mse(image, truth, (0.01 * mean).max(f64::MIN_POSITIVE)).sqrt()
}

fn parse_parts(text: &str) -> Result<[f64; 4], String> {
    let part = |text: &str| text.trim().parse().ok().filter(|part| *part > 0.0 && *part <= 1.0);
    let parts: Option<Vec<f64>> = text.split(',').map(part).collect();
    let four = parts.and_then(|parts| <[f64; 4]>::try_from(parts).ok());
    four.ok_or_else(|| "four parts, above 0 and up to 1, are needed".into())
}
