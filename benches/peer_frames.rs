//! Linear frames of the rolling sphere and the time that rendering them took: our part of
//! `script/bench peers`, which lays them beside those of other renderers.
//!
//! ```text
//! cargo bench --bench peer_frames -- -o DIR [--device gpu|cpu] [--material flat|checker8|checker16|mesh]
//!     [--speed S2] [--shutter T5] [--frame 60] [--eye left|right] [--samples N,…] [--seeds N,…]
//! ```
//! `mesh` is `DIR/mesh.ply` in place of the sphere. For all numbers of samples and seeds it writes
//! `ours-DEVICE_VIEW_SAMPLES_SEED.pfm`, and it prints a line of CSV as the scripts in `benches/peers` do. It
//! adds `empty_VIEW.pfm`, the view without the sphere, which the measure of error needs. One frame is
//! rendered beforehand and not counted.
#![expect(clippy::print_stdout, reason = "a benchmark prints")]

mod pfm;

use cpu_time::ProcessTime;
use shutterlab::pipelines::{DeviceChoice, OpenDevice};
use shutterlab_stimuli::assets::{Asset, Kind};
use shutterlab_stimuli::scene::{Material, Shape};
use shutterlab_stimuli::stimulus::Trajectory;
use shutterlab_stimuli::{Grid, Selection, Stimulus};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::str::FromStr;
use std::time::Instant;

/// Samples of the view without the sphere, which is smooth.
const EMPTY_SAMPLES: u32 = 256;

type Failure = Box<dyn std::error::Error + Send + Sync>;

fn main() -> Result<(), Failure> {
    let option = |name: &str, default: &str| {
        let given = std::env::args().skip_while(|word| word != name).nth(1);
        given.unwrap_or_else(|| default.to_owned())
    };
    let folder = PathBuf::from(option("-o", "target/bench/peers"));
    let device = option("--device", "gpu");
    let material = option("--material", "checker8");
    let (speed, shutter) = (option("--speed", "S2"), option("--shutter", "T5"));
    let frame: u32 = option("--frame", "60").parse()?;
    let eye = option("--eye", "");
    let samples: Vec<u32> = numbers(&option("--samples", "4,32,128"))?;
    let seeds: Vec<u64> = numbers(&option("--seeds", "1"))?;

    let mut stimulus = stimulus(&material, &speed, &shutter, !eye.is_empty())?;
    if material == "mesh" {
        replace_sphere(&mut stimulus, &folder)?;
    }
    let open = match device.as_str() {
        "gpu" => OpenDevice::open(DeviceChoice::Gpu)?,
        "cpu" => OpenDevice::open(DeviceChoice::Cpu)?,
        _ => return Err(format!("--device: {device}; gpu and cpu are allowed").into()),
    };
    std::fs::create_dir_all(&folder)?;
    let mut times =
        std::fs::File::options().create(true).append(true).open(folder.join("times.csv"))?;
    let dash = if eye.is_empty() { "" } else { "-" };
    let view = format!("{material}-{speed}-{shutter}-{frame}{dash}{eye}");
    let mut pipeline = open.pipeline(stimulus.method, &folder);

    // It is out of sight at the first frame of a sequence in which it passes once.
    let away =
        Stimulus { trajectory: Trajectory::Once, samples: EMPTY_SAMPLES, ..stimulus.clone() };
    let number = match eye.as_str() {
        "" | "left" => 0,
        "right" => 1,
        _ => return Err(format!("--eye: {eye}; left and right are allowed").into()),
    };
    let view_of = &stimulus.views(frame)[number];
    let empty = pipeline.films(&away, view_of, 0, &[EMPTY_SAMPLES])?.remove(0).image();
    pfm::write(&empty, &folder.join(format!("empty_{view}.pfm")))?;
    for samples in samples {
        for &seed in &seeds {
            let wanted = Stimulus { samples, seed, ..stimulus.clone() };
            let (started, cpu) = (Instant::now(), ProcessTime::now());
            let image = pipeline.films(&wanted, view_of, frame, &[samples])?.remove(0).image();
            let (wall, core) = (started.elapsed().as_secs_f64(), cpu.elapsed().as_secs_f64());
            let name = format!("ours-{device}_{view}_{samples}_{seed}.pfm");
            pfm::write(&image, &folder.join(name))?;
            let line = format!("ours-{device},{view},{samples},{seed},{wall:.4},{core:.4}");
            println!("{line}");
            writeln!(times, "{line}")?;
        }
    }
    Ok(())
}

/// A stimulus of the thesis's grids; `checker16` is their checker with twice as many cells.
fn stimulus(
    material: &str,
    speed: &str,
    shutter: &str,
    is_stereo: bool,
) -> Result<Stimulus, Failure> {
    let (level, cells) = match material {
        "flat" | "mesh" => ("flat", None),
        "checker8" => ("checker", Some(8)),
        "checker16" => ("checker", Some(16)),
        _ => {
            let allowed = "flat, checker8, checker16 and mesh are allowed";
            return Err(format!("--material: {material}; {allowed}").into());
        }
    };
    let grid = if is_stereo { "rolling-sphere-stereo" } else { "rolling-sphere-mono" };
    let grid = Grid::load(grid)?;
    let select = format!("material={level},speed={speed},shutter={shutter},samples=A1");
    let mut stimulus = grid.stimuli(&Selection::parse(&[select], &grid)?)?.remove(0);
    if let (Some(wanted), Material::Checker { cells, .. }) = (cells, &mut stimulus.material) {
        *cells = wanted;
    }
    Ok(stimulus)
}

/// Puts the mesh in `folder` in place of the sphere of the same radius.
fn replace_sphere(stimulus: &mut Stimulus, folder: &Path) -> Result<(), Failure> {
    let mesh = Asset::open(&folder.join("mesh.ply"), Kind::Model)?;
    mesh.keep(folder)?;
    let object = &mut stimulus.scene.objects[0];
    let radius_m = object.radius_m();
    object.shape = Shape::Mesh { file: "mesh.ply".into(), sha256: mesh.sha256, radius_m };
    Ok(())
}

fn numbers<T: FromStr>(text: &str) -> Result<Vec<T>, T::Err> {
    text.split(',').map(str::parse).collect()
}
