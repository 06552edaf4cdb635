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

use cpu_time::ProcessTime;
use shutterlab::pipelines::{DeviceChoice, OpenDevice};
use shutterlab_stimuli::scene::Material;
use shutterlab_stimuli::stimulus::Edge;
use shutterlab_stimuli::{Grid, LinearImage, Selection, Stimulus};
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
    let mut pipeline = open.pipeline(stimulus.method);

    // It is out of sight at the first frame of a sequence in which it passes once.
    let away = Stimulus { edge: Edge::Once, samples: EMPTY_SAMPLES, ..stimulus.clone() };
    let empty = pipeline.film(&away, 0)?.image();
    write_pfm(&empty, &folder.join(format!("empty_{view}.pfm")))?;
    for samples in samples {
        for &seed in &seeds {
            let wanted = Stimulus { samples, seed, ..stimulus.clone() };
            let (started, cpu) = (Instant::now(), ProcessTime::now());
            let image = pipeline.film(&wanted, frame)?.image();
            let (wall, core) = (started.elapsed().as_secs_f64(), cpu.elapsed().as_secs_f64());
            let name = format!("ours-{device}_{view}_{samples}_{seed}.pfm");
            write_pfm(&image, &folder.join(name))?;
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

/// A Portable Float Map: little-endian 32-bit RGB, rows from the bottom.
fn write_pfm(image: &LinearImage, path: &Path) -> std::io::Result<()> {
    let mut file = std::io::BufWriter::new(std::fs::File::create(path)?);
    write!(file, "PF\n{} {}\n-1.0\n", image.width, image.height)?;
    for row in image.pixels.chunks(image.width as usize).rev() {
        for value in row.iter().flatten() {
            file.write_all(&value.to_le_bytes())?;
        }
    }
    file.flush()
}
