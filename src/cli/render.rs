//! `shutterlab render`: sequences of a grid, with manifests.

use super::progress::RenderProgress;
use super::{UsageError, counted, say, slurm};
use crate::pipelines::DeviceChoice;
use crate::render::Renderer;
use crate::scene::import;
use anyhow::anyhow;
use indicatif::HumanBytes;
use shutterlab_data_schema::files::create_folder;
use shutterlab_stimuli::generate::{Request, passes};
use shutterlab_stimuli::stereo::Layout;
use shutterlab_stimuli::{Grid, Render, Selection, Sequence, Stimulus, generate, overview, video};
use std::ops::Range;
use std::path::{Path, PathBuf};

/// Render the sequences of a grid. What is finished is skipped; an interrupted run goes on where it
/// stopped.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// A shipped grid (rolling-sphere-mono, rolling-sphere-stereo, zhang-r, zhang-lod, zhang-validation, demo) or a
    /// grid file
    pub(super) grid: String,
    /// Folder for the sequence folders
    #[arg(short, long, value_name = "DIR")]
    pub(super) out: PathBuf,
    /// Cells to render, such as material=checker,speed=S2; given again, adds cells
    #[arg(long, value_name = "AXIS=LEVEL,…")]
    select: Vec<String>,
    /// Frames A to B−1 of each sequence
    #[arg(long, value_name = "A..B", value_parser = parse_range)]
    frames: Option<Range<u32>>,
    /// Size of the images in pixels, in place of the grid's
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    size: Option<[u32; 2]>,
    /// How the eyes of a stereo grid make one frame, in place of the grid's layout
    #[arg(long, value_name = "LAYOUT", value_parser = layouts())]
    layout: Option<String>,
    /// The models in this folder (.ply, .obj, .gltf, .glb, .stl) in place of those of the grid's axis model
    #[arg(long, value_name = "DIR")]
    pub(super) models: Option<PathBuf>,
    /// Write the linear images too, as OpenEXR (the eyes side by side)
    #[arg(long)]
    exr: bool,
    /// Write each sequence as one lossless video too (FFV1; needs ffmpeg)
    #[arg(long)]
    video: bool,
    /// Only part I of N of the work, 1 to N; the parts' folders make up the whole
    #[arg(long, value_name = "I/N", value_parser = parse_shard)]
    shard: Option<[usize; 2]>,
    /// Render nothing; write a job array for Slurm that does
    #[arg(long, conflicts_with_all = ["shard", "json"])]
    slurm: bool,
    /// What renders
    #[arg(long, value_name = "DEVICE", default_value = "auto")]
    device: Device,
    /// Print the finished sequences as JSON
    #[arg(long)]
    json: bool,
}

impl Args {
    /// The words that say what of the grid is rendered, how and on what.
    pub(super) fn restrictions(&self) -> Vec<String> {
        let mut words = vec![];
        let mut add = |option: &str, value: String| words.extend([option.to_string(), value]);
        self.select.iter().for_each(|select| add("--select", select.clone()));
        if let Some(Range { start, end }) = self.frames {
            add("--frames", format!("{start}..{end}"));
        }
        if let Some([width, height]) = self.size {
            add("--size", format!("{width}x{height}"));
        }
        if let Some(layout) = &self.layout {
            add("--layout", layout.clone());
        }
        add("--device", format!("{:?}", self.device).to_lowercase());
        words.extend(self.exr.then(|| "--exr".into()));
        words.extend(self.video.then(|| "--video".into()));
        words
    }
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
    if let Some(layout) = &args.layout {
        let refuse =
            || anyhow!("render: --layout: {layout}: {}: the grid is not stereo", grid.name);
        let stereo = grid.stereo.as_mut().ok_or_else(|| UsageError::from(refuse()))?;
        let named = Layout::ALL.into_iter().find(|(name, _)| name == layout);
        stereo.layout = named.map_or(stereo.layout, |(_, layout)| layout);
    }
    if let Some(models) = &args.models {
        grid.set_models(models)?;
    }
    grid.check(&args.grid)?;
    let selection = Selection::parse(&args.select, &grid).map_err(UsageError::from)?;
    let (stimuli, assets) = grid.resolve(&selection)?;
    let stimuli = shard(stimuli, args.shard);
    if args.slurm {
        return slurm::write(args, &grid.name, passes(&stimuli).len());
    }
    if args.video && !video::is_available() {
        return Err(anyhow!(
            "render: --video: ffmpeg: not found; install it, or leave --video out"
        ));
    }
    let request = Request {
        grid: &grid.name,
        stimuli: &stimuli,
        frames: args.frames.as_ref(),
        exr: args.exr,
        out: &args.out,
    };
    // A file that cannot be used is told of under its own name, before anything is written.
    assets.iter().try_for_each(import::check)?;
    for asset in &assets {
        asset.keep(&args.out)?;
    }
    let finished = render(&request, args.device.into())?;
    if args.video {
        for sequence in &finished {
            video::write(&sequence.folder)?;
        }
    }
    match overview::write(&args.out) {
        Ok(None) => {}
        Ok(Some([sheet, page])) => {
            let (sheet, page) = (sheet.display(), page.display());
            eprintln!("contact sheet: {sheet}\npage that plays them: {page}");
        }
        // Another sequence in the folder is damaged, perhaps; these are whole.
        Err(error) => eprintln!("no contact sheet: {error}"),
    }
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
            let frames = counted(manifest.frames.len(), "frame");
            let folder = sequence.folder.display();
            say(&format!("{folder}  {frames}  sha256 {}", &manifest.sha256[..16]))?;
        }
    }
    Ok(())
}

/// Loads a grid; a name that is neither shipped nor a file is a wrong word.
pub(super) fn load_grid(name: &str) -> anyhow::Result<Grid> {
    let is_known = Path::new(name).exists();
    Grid::load(name).map_err(|error| if is_known { error.into() } else { UsageError::from(error) })
}

/// Part I of N of `stimuli`: every N-th of the passes that make them.
fn shard(stimuli: Vec<Stimulus>, part: Option<[usize; 2]>) -> Vec<Stimulus> {
    let Some([part, of]) = part else { return stimuli };
    let passes = passes(&stimuli).into_iter().skip(part - 1).step_by(of);
    passes.flatten().cloned().collect()
}

/// Renders what is requested.
pub(super) fn render(request: &Request<'_>, device: DeviceChoice) -> anyhow::Result<Vec<Sequence>> {
    let &Request { stimuli, frames, .. } = request;
    request.check().map_err(UsageError::from)?;
    create_folder(request.out)?;
    check_space(request)?;
    let mut renderer = Renderer::open(device, request.out).map_err(|error| anyhow!(error))?;
    // A part of a grid may be empty; the stimuli of one have the scene in common.
    if let Some(described) = stimuli.first().map(|first| renderer.device(first)) {
        eprintln!("sequences: {}, on {} ({})", stimuli.len(), described.adapter, described.kind);
    }
    let length = frames.map(|range| range.end.saturating_sub(range.start));
    let mut progress =
        RenderProgress::new(stimuli, |stimulus| length.unwrap_or(stimulus.image.frames));
    match generate(request, &mut renderer, &mut progress) {
        Ok(()) => Ok(progress.finished),
        Err(error) => Err(error.into()),
    }
}

/// Says how much the frames will take, and refuses to begin what the disk cannot hold.
fn check_space(request: &Request<'_>) -> anyhow::Result<()> {
    let (needed, out) = (request.bytes_needed(), request.out);
    // The folder may not be there yet, but one above it is.
    let there = out.ancestors().find(|folder| folder.exists() && !folder.as_os_str().is_empty());
    let free = fs4::available_space(there.unwrap_or(Path::new(".")));
    let free =
        free.map_err(|e| anyhow!("{}: its free space cannot be told: {e}", out.display()))?;
    eprintln!("disk space: up to {} to come, {} free", HumanBytes(needed), HumanBytes(free));
    if needed > free {
        let (needed, free) = (HumanBytes(needed), HumanBytes(free));
        let shown = out.display();
        return Err(anyhow!("render: -o: {shown}: {free} free: up to {needed} may be needed"));
    }
    Ok(())
}

fn layouts() -> [&'static str; Layout::ALL.len()] {
    Layout::ALL.map(|(name, _)| name)
}

fn parse_shard(text: &str) -> Result<[usize; 2], String> {
    let parsed = text
        .split_once('/')
        .and_then(|(i, n)| Some([i.trim().parse().ok()?, n.trim().parse().ok()?]));
    let part = parsed.filter(|[part, of]: &[usize; 2]| (1..=*of).contains(part));
    part.ok_or("I/N is needed, such as 3/45, with I from 1 to N".into())
}

pub(super) fn parse_range(text: &str) -> Result<Range<u32>, String> {
    let parsed = text
        .split_once("..")
        .and_then(|(a, b)| Some(a.trim().parse().ok()?..b.trim().parse().ok()?));
    parsed.ok_or("A..B is needed, such as 58..60; B is not rendered".into())
}

pub(super) fn parse_size(text: &str) -> Result<[u32; 2], String> {
    let parsed = text
        .split_once('x')
        .and_then(|(w, h)| Some([w.trim().parse().ok()?, h.trim().parse().ok()?]));
    let sides =
        parsed.filter(|sides: &[u32; 2]| sides.iter().all(|side| (1..=16384).contains(side)));
    sides.ok_or("WIDTHxHEIGHT is needed, such as 640x360, each from 1 to 16384".into())
}
