//! Linear frames of the rolling sphere and the time that rendering them took: our part of
//! `script/bench peers`, which lays them beside those of other renderers.
//!
//! ```text
//! cargo bench --bench peer_frames -- -o DIR [--device gpu|cpu] [--material flat|checker8|checker16]
//!     [--speed S2] [--shutter T5] [--frame 60] [--samples N,…] [--seeds N,…]
//! ```
//! For all numbers of samples and seeds it writes `ours-DEVICE_VIEW_SAMPLES_SEED.pfm`, and it prints a
//! line of CSV as the scripts in `benches/peers` do. It adds `empty_VIEW.pfm`, the view without the
//! sphere, which the measure of error needs. One frame is rendered beforehand and not counted.
#![expect(clippy::print_stdout, reason = "a benchmark prints")]

mod pfm;

use cpu_time::ProcessTime;
use shutterlab::pipelines::{DeviceChoice, OpenDevice};
use shutterlab_stimuli::scene::Material;
use shutterlab_stimuli::stimulus::Trajectory;
use shutterlab_stimuli::{Grid, Selection, Stimulus};
use std::io::Write;
use std::path::PathBuf;
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
    let samples: Vec<u32> = numbers(&option("--samples", "4,32,128"))?;
    let seeds: Vec<u64> = numbers(&option("--seeds", "1"))?;

    let stimulus = stimulus(&material, &speed, &shutter)?;
    let open = match device.as_str() {
        "gpu" => OpenDevice::open(DeviceChoice::Gpu)?,
        "cpu" => OpenDevice::open(DeviceChoice::Cpu)?,
        _ => return Err(format!("--device: {device}; gpu and cpu are allowed").into()),
    };
    std::fs::create_dir_all(&folder)?;
    let mut times =
        std::fs::File::options().create(true).append(true).open(folder.join("times.csv"))?;
    let view = format!("{material}-{speed}-{shutter}-{frame}");
    let mut pipeline = open.pipeline(stimulus.method, &folder);

    // It is out of sight at the first frame of a sequence in which it passes once.
    let away =
        Stimulus { trajectory: Trajectory::Once, samples: EMPTY_SAMPLES, ..stimulus.clone() };
    let view_of = &stimulus.views(0)[0];
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

/// A stimulus of the thesis's grid; `checker16` is its checker with twice as many cells.
fn stimulus(material: &str, speed: &str, shutter: &str) -> Result<Stimulus, Failure> {
    let (level, cells) = match material {
        "flat" => ("flat", None),
        "checker8" => ("checker", Some(8)),
        "checker16" => ("checker", Some(16)),
        _ => {
            return Err(format!("--material: {material}; flat, checker8, checker16 allowed").into());
        }
    };
    let grid = Grid::load("rolling-sphere-mono")?;
    let select = format!("material={level},speed={speed},shutter={shutter},samples=A1");
    let mut stimulus = grid.stimuli(&Selection::parse(&[select], &grid)?)?.remove(0);
    if let (Some(wanted), Material::Checker { cells, .. }) = (cells, &mut stimulus.material) {
        *cells = wanted;
    }
    Ok(stimulus)
}

fn numbers<T: FromStr>(text: &str) -> Result<Vec<T>, T::Err> {
    text.split(',').map(str::parse).collect()
}
