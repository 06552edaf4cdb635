//! `shutterlab render`: sequences of a grid, with manifests.

use super::progress::RenderProgress;
use super::{UsageError, say};
use crate::pipelines::DeviceChoice;
use crate::render::Renderer;
use anyhow::anyhow;
use shutterlab_stimuli::generate::GenerateError;
use shutterlab_stimuli::{Grid, Render, Selection, Sequence, generate};
use std::ops::Range;
use std::path::{Path, PathBuf};

/// Render the sequences of a grid. What is finished is skipped; an interrupted run goes on where it
/// stopped.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// A shipped grid (rolling-sphere-mono, demo) or a grid file
    grid: String,
    /// Folder for the sequence folders
    #[arg(short, long, value_name = "DIR")]
    out: PathBuf,
    /// Cells to render, such as material=checker,speed=S2; given again, adds cells
    #[arg(long, value_name = "AXIS=LEVEL,…")]
    select: Vec<String>,
    /// Frames A to B−1 of each sequence
    #[arg(long, value_name = "A..B", value_parser = parse_range)]
    frames: Option<Range<u32>>,
    /// Size of the images in pixels, in place of the grid's; the view stays the same
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    size: Option<[u32; 2]>,
    /// What renders
    #[arg(long, value_name = "DEVICE", default_value = "auto")]
    device: Device,
    /// Print the finished sequences as JSON
    #[arg(long)]
    json: bool,
}

/// What renders.
#[derive(Clone, Copy, Debug, clap::ValueEnum)]
pub enum Device {
    /// A graphics adapter, be it in software
    Gpu,
    /// The processor
    Cpu,
    /// A graphics adapter if there is one, else the processor
    Auto,
}

impl From<Device> for DeviceChoice {
    fn from(device: Device) -> Self {
        match device {
            Device::Gpu => Self::Gpu,
            Device::Cpu => Self::Cpu,
            Device::Auto => Self::Auto,
        }
    }
}

pub(super) fn run(args: &Args) -> anyhow::Result<()> {
    let mut grid = load_grid(&args.grid)?;
    if let Some([width, height]) = args.size {
        (grid.image.width_px, grid.image.height_px) = (width, height);
    }
    let selection = Selection::parse(&args.select, &grid).map_err(UsageError::from)?;
    let finished = render(&grid, &selection, args.frames.clone(), &args.out, args.device.into())?;
    let described = finished.iter().map(|sequence| (sequence, &sequence.manifest));
    if args.json {
        let list: Vec<_> = described
            .map(|(sequence, manifest)| {
                serde_json::json!({
                    "id": manifest.stimulus.id,
                    "folder": sequence.folder,
                    "frames": manifest.frames.len(),
                    "sha256": manifest.sha256,
                })
            })
            .collect();
        say(&format!("{:#}", serde_json::Value::from(list)))?;
    } else {
        for (sequence, manifest) in described {
            let (folder, frames) = (sequence.folder.display(), manifest.frames.len());
            say(&format!("{folder}  {frames} frames  sha256 {}", &manifest.sha256[..16]))?;
        }
    }
    Ok(())
}

/// Loads a grid; a name that is neither shipped nor a file is a wrong word.
fn load_grid(name: &str) -> anyhow::Result<Grid> {
    let is_known = Path::new(name).exists();
    Grid::load(name).map_err(|error| if is_known { error.into() } else { UsageError::from(error) })
}

/// Renders the cells that `selection` takes into `out`.
pub(super) fn render(
    grid: &Grid,
    selection: &Selection,
    frames: Option<Range<u32>>,
    out: &Path,
    device: DeviceChoice,
) -> anyhow::Result<Vec<Sequence>> {
    let stimuli = grid.stimuli(selection)?;
    let mut renderer = Renderer::open(device).map_err(|error| anyhow!(error))?;
    let described = renderer.device();
    eprintln!("sequences: {}, on {} ({})", stimuli.len(), described.adapter, described.kind);
    let length = frames.as_ref().map(|range| range.end.saturating_sub(range.start));
    let mut progress =
        RenderProgress::new(&stimuli, |stimulus| length.unwrap_or(stimulus.image.frames));
    match generate(&grid.name, &stimuli, frames, out, &mut renderer, &mut progress) {
        Ok(()) => Ok(progress.finished),
        Err(error @ GenerateError::Frames { .. }) => Err(UsageError::from(error)),
        Err(error) => Err(error.into()),
    }
}

fn parse_range(text: &str) -> Result<Range<u32>, String> {
    let parsed = text
        .split_once("..")
        .and_then(|(a, b)| Some(a.trim().parse().ok()?..b.trim().parse().ok()?));
    parsed.ok_or("A..B is needed, such as 58..60; B is not rendered".into())
}

fn parse_size(text: &str) -> Result<[u32; 2], String> {
    let parsed = text
        .split_once('x')
        .and_then(|(w, h)| Some([w.trim().parse().ok()?, h.trim().parse().ok()?]));
    let sides =
        parsed.filter(|sides: &[u32; 2]| sides.iter().all(|side| (1..=16384).contains(side)));
    sides.ok_or("WIDTHxHEIGHT is needed, such as 640x360, each from 1 to 16384".into())
}
