//! How fast the path tracer is: camera paths per core-second, and time to a given error, on each
//! device; and what each sampler's error is. Written so that another renderer's figures can be laid
//! beside.
//!
//! `script/bench render` renders frame 60 of M2-S2-T5 of the thesis's grid (640×360) with 4 to 512
//! samples. It prints tables and leaves in `target/bench/`: `render.csv`, `samplers.csv` and
//! `render-truth.pfm`, the linear image (Portable Float Map) that errors are measured against. Each
//! figure is the median of three runs after one that is not counted; a core-second is a second of this
//! process's processor time, so a graphics card's work is not in it, and its figure is the wall time
//! alone.
#![expect(clippy::print_stdout, reason = "a benchmark prints")]

mod pfm;

use cpu_time::ProcessTime;
use shutterlab::film::{Film, measure};
use shutterlab::pipelines::{DeviceChoice, OpenDevice, Pipeline};
use shutterlab_stimuli::stimulus::{Sampler, Trajectory};
use shutterlab_stimuli::{Grid, Selection, Stimulus};
use std::io::Write;
use std::path::Path;
use std::time::Instant;

const FRAME: u32 = 60;
const SAMPLES: [u32; 4] = [4, 32, 128, 512];
/// The thesis's levels A1 to A5.
const LEVELS: [u32; 5] = [4, 128, 256, 384, 512];
/// The truth's own error is a few per cent of that of the finest row.
const TRUTH_SAMPLES: u32 = 8192;
const TARGET_RELATIVE_MSE: f64 = 1e-3;
const COUNTED_RUNS: usize = 3;

type Failure = Box<dyn std::error::Error + Send + Sync>;

fn main() -> Result<(), Failure> {
    let grid = Grid::load("rolling-sphere-mono")?;
    let selection = Selection::parse(&["material=checker,speed=S2,shutter=T5,samples=A1"], &grid)?;
    let stimulus = grid.stimuli(&selection)?.remove(0);
    let devices = [DeviceChoice::Gpu, DeviceChoice::Cpu].map(OpenDevice::open);
    let fastest = devices.iter().flatten().next().ok_or("no device")?;

    let with = |samples: u32, seed: u64| Stimulus { samples, seed, ..stimulus.clone() };
    let render = |pipeline: &mut dyn Pipeline, samples| film(pipeline, &with(samples, 1), FRAME);
    let folder = &Path::new(env!("CARGO_MANIFEST_DIR")).join("target/bench");
    let mut pipeline = fastest.pipeline(stimulus.method, folder);
    let truth = film(pipeline.as_mut(), &with(TRUTH_SAMPLES, 2), FRAME)?.image();
    // The view without the sphere: it is out of sight at the first frame.
    let mut away = with(256, 3);
    away.trajectory = Trajectory::Once;
    let empty = film(pipeline.as_mut(), &away, 0)?.image();
    let epsilon = measure::epsilon(&truth, &empty);

    std::fs::create_dir_all(folder)?;
    pfm::write(&truth, &folder.join("render-truth.pfm"))?;
    let mut csv = std::fs::File::create(folder.join("render.csv"))?;
    let columns = "device,adapter,samples,wall_s,core_s,paths_per_s,paths_per_core_s,relative_mse";
    writeln!(csv, "{columns}")?;
    for device in devices.iter().flatten() {
        let described = device.describe();
        println!("{} ({}) {}", described.adapter, described.kind, described.driver);
        println!("samples   wall s   core s   Mpaths/s   Mpaths/core-s   relative MSE");
        let mut pipeline = device.pipeline(stimulus.method, folder);
        let mut rows = vec![];
        for samples in SAMPLES {
            let (mut walls, mut cores) = (vec![], vec![]);
            let mut image = render(pipeline.as_mut(), samples)?.image();
            for _ in 0..COUNTED_RUNS {
                let (started, cpu) = (Instant::now(), ProcessTime::now());
                image = render(pipeline.as_mut(), samples)?.image();
                walls.push(started.elapsed().as_secs_f64());
                cores.push(cpu.elapsed().as_secs_f64());
            }
            let (wall, core) = (median(walls), median(cores));
            let paths = f64::from(truth.width * truth.height) * f64::from(samples);
            let error = measure::relative_mse(&image, &truth, epsilon);
            rows.push([error, wall, core]);
            let (per_s, per_core_s) = (paths / wall, paths / core);
            println!(
                "{samples:7} {wall:8.3} {core:8.3} {:10.2} {:15.2} {error:14.3e}",
                per_s / 1e6,
                per_core_s / 1e6
            );
            let name = described.adapter.replace(',', ";");
            writeln!(
                csv,
                "{},{name},{samples},{wall},{core},{per_s},{per_core_s},{error}",
                described.kind
            )?;
        }
        let [wall, core] = [1, 2].map(|column| to_target(&rows, column));
        println!(
            "to a relative MSE of {TARGET_RELATIVE_MSE}: {wall:.2} s, {core:.2} core-seconds\n"
        );
    }

    println!("relative MSE    random  stratified       sobol  random/sobol");
    let mut csv = std::fs::File::create(folder.join("samplers.csv"))?;
    writeln!(csv, "samples,random,stratified,sobol")?;
    for samples in LEVELS {
        let mut errors = [0.0; 3];
        let samplers = [Sampler::Random, Sampler::Stratified, Sampler::Sobol];
        for (error, sampler) in errors.iter_mut().zip(samplers) {
            let image = film(pipeline.as_mut(), &Stimulus { sampler, ..with(samples, 1) }, FRAME)?;
            *error = measure::relative_mse(&image.image(), &truth, epsilon);
        }
        let [random, stratified, sobol] = errors;
        let decibels = 10.0 * (random / sobol).log10();
        println!("{samples:7} {random:14.3e} {stratified:11.3e} {sobol:11.3e} {decibels:9.1} dB");
        writeln!(csv, "{samples},{random},{stratified},{sobol}")?;
    }
    Ok(())
}

/// What `column` of the rows of [error, …] is at the target: interpolated between the two rows about it
/// (extrapolated from the nearest two), error and time being powers of the samples.
fn to_target(rows: &[[f64; 3]], column: usize) -> f64 {
    let after = rows.iter().position(|row| row[0] < TARGET_RELATIVE_MSE).unwrap_or(rows.len() - 1);
    let [a, b] = [rows[after.max(1) - 1], rows[after.max(1)]];
    let part = (TARGET_RELATIVE_MSE / a[0]).ln() / (b[0] / a[0]).ln();
    a[column] * (b[column] / a[column]).powf(part)
}

/// Frame number `frame` of `stimulus`, all its samples.
fn film(pipeline: &mut dyn Pipeline, stimulus: &Stimulus, frame: u32) -> Result<Film, Failure> {
    let view = &stimulus.views(frame)[0];
    Ok(pipeline.films(stimulus, view, frame, &[stimulus.samples])?.remove(0))
}

fn median(mut seconds: Vec<f64>) -> f64 {
    seconds.sort_by(f64::total_cmp);
    seconds[seconds.len() / 2]
}
