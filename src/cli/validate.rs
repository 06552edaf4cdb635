//! `shutterlab validate`: whether files are what they say.

use super::render::Device;
use super::say;
use crate::render::Renderer;
use crate::scene::import;
use anyhow::{Context, anyhow};
use shutterlab_data_schema::Protocol;
use shutterlab_stimuli::manifest::FILE_NAME;
use shutterlab_stimuli::verify::{Agreement, verify};
use shutterlab_stimuli::{Grid, Sequence};
use std::hash::{BuildHasher, RandomState};
use std::path::{Path, PathBuf};

/// Check sequences (every frame's hash, and a random frame rendered anew), studies, grids, protocols,
/// light maps and models.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Sequence folders, folders of such, study folders; files: grids and protocols (.toml), light maps
    /// (.hdr, .exr), models (.ply, .obj, .gltf, .glb)
    #[arg(required = true)]
    paths: Vec<PathBuf>,
    /// What renders anew
    #[arg(long, value_name = "DEVICE", default_value = "auto")]
    device: Device,
}

pub(super) fn run(args: &Args) -> anyhow::Result<()> {
    let mut renderer = None;
    let (mut checked, mut faults) = (0, vec![]);
    for path in &args.paths {
        for target in targets(path)? {
            checked += 1;
            match check(&target, args.device, &mut renderer) {
                Ok(found) => say(&format!("{}  {found}", target.display()))?,
                Err(error) => {
                    say(&format!("{}  NOT VALID", target.display()))?;
                    faults.push(error);
                }
            }
        }
    }
    let Some(first) = faults.first() else { return Ok(()) };
    Err(anyhow!("{} of {checked} not valid; the first: {first:#}", faults.len()))
}

/// What there is to check at `path`: itself, or the sequences in it.
fn targets(path: &Path) -> anyhow::Result<Vec<PathBuf>> {
    let is_one = |path: &Path| {
        let holds = |name: &str| path.join(name).exists();
        path.is_file() || [FILE_NAME, "unfinished.json", "datapackage.json"].into_iter().any(holds)
    };
    if is_one(path) {
        return Ok(vec![path.into()]);
    }
    let unreadable = || format!("{}: cannot be read", path.display());
    let mut found = vec![];
    for entry in std::fs::read_dir(path).with_context(unreadable)? {
        let path = entry.with_context(unreadable)?.path();
        if path.is_dir() && is_one(&path) {
            found.push(path);
        }
    }
    if found.is_empty() {
        return Err(anyhow!("{}: holds no sequence and no study", path.display()));
    }
    found.sort();
    Ok(found)
}

/// Checks one thing, and says what was found.
fn check(
    path: &Path,
    device: Device,
    kept: &mut Option<(PathBuf, Renderer)>,
) -> anyhow::Result<String> {
    if path.is_file() {
        let ending = path.extension().unwrap_or_default().to_string_lossy().to_lowercase();
        return match ending.as_str() {
            "hdr" | "exr" => {
                let map = import::image::light_map(path)?;
                Ok(format!("light map, {}×{} texels", map.width, map.height))
            }
            "ply" | "obj" | "gltf" | "glb" => {
                let mesh = import::model(path)?.mesh;
                let (faces, vertices) = (mesh.triangles.len(), mesh.positions.len());
                Ok(format!("model, {faces} triangles, {vertices} vertices"))
            }
            _ => check_definition(path),
        };
    }
    if path.join("datapackage.json").exists() {
        let answers = shutterlab_analysis::responses::read(path)?;
        return Ok(format!("study, answers about {} stimuli", answers.items().len()));
    }
    let sequence = Sequence::open(path)?;
    let beside = path.parent().unwrap_or(Path::new("")).to_path_buf();
    let renderer = match kept {
        Some((folder, renderer)) if *folder == beside => renderer,
        _ => {
            let renderer =
                Renderer::open(device.into(), &beside).map_err(|error| anyhow!(error))?;
            &mut kept.insert((beside, renderer)).1
        }
    };
    let place = RandomState::new().hash_one(path) as usize;
    let (index, agreement) = verify(&sequence, place, renderer)?;
    let anew = match agreement {
        Agreement::SameBytes => "the same bytes".into(),
        Agreement::SameImage { relative_rmse, .. } => {
            format!("the same image (relative RMSE {relative_rmse:.1e}) by another renderer")
        }
    };
    let frames = sequence.manifest.frames.len();
    Ok(format!("{frames} frames hold their hashes, frame {index} rendered anew is {anew}"))
}

fn check_definition(path: &Path) -> anyhow::Result<String> {
    let file = path.display().to_string();
    let text = std::fs::read_to_string(path).with_context(|| format!("{file}: cannot be read"))?;
    // Only a grid has axes as a table; a protocol without them is told by its own error.
    let keys: toml::Table = text.parse().unwrap_or_default();
    if keys.contains_key("axes") {
        let grid = Grid::load(&std::path::absolute(path)?.display().to_string())?;
        let stimuli = grid.stimuli(&Default::default())?;
        grid.assets()?
            .iter()
            .try_for_each(|asset| import::image::light_map(&asset.source).map(drop))?;
        return Ok(format!("grid, {} sequences", stimuli.len()));
    }
    Ok(format!("protocol {}", Protocol::parse(&text, &file)?.name))
}
