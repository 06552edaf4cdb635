//! `shutterlab validate`: whether files are what they say.

use super::render::Device;
use super::{counted, say};
use crate::render::Renderer;
use crate::scene::import;
use anyhow::{Context, anyhow};
use shutterlab_data_schema::cohort::Cohort;
use shutterlab_data_schema::study::StudyKind;
use shutterlab_data_schema::{DisplayProfile, FittedParameters, Protocol};
use shutterlab_experiments::record::status::status;
use shutterlab_stimuli::generate::ORIGIN_FILE as UNFINISHED;
use shutterlab_stimuli::manifest::FILE_NAME;
use shutterlab_stimuli::verify::{Agreement, VerifyError, verify};
use shutterlab_stimuli::{Grid, Scene, Sequence};
use std::hash::{BuildHasher, RandomState};
use std::path::{Path, PathBuf};

/// What tells a display profile.
const DISPLAY_KEYS: [&str; 11] = [
    "screen",
    "transfer",
    "stereo",
    "photodiode",
    "magnification",
    "refresh_hz",
    "variable_refresh",
    "output",
    "window",
    "luminance_cd_m2",
    "black_cd_m2",
];

/// What is listed of one thing that is not valid.
const MAX_FAULTS: usize = 10;

/// Check sequences (every file's hash, and a random frame rendered anew), studies, grids, scenes,
/// protocols, cohorts, fitted parameters, display profiles, light maps and models.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Sequence folders, folders of such, study folders; files: grids, scenes, protocols, cohorts, fitted
    /// parameters and display profiles (.toml), light maps (.hdr, .exr), models (.ply, .obj, .gltf, .glb, .stl)
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
                Err(found) => {
                    say(&format!("{}  NOT VALID", target.display()))?;
                    for fault in found.iter().take(MAX_FAULTS) {
                        say(&format!("  {fault:#}"))?;
                    }
                    if let Some(more) = found.len().checked_sub(MAX_FAULTS).filter(|&n| n > 0) {
                        say(&format!("  and {}", counted(more, "more fault")))?;
                    }
                    faults.extend(found.into_iter().next());
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
        path.is_file() || [FILE_NAME, UNFINISHED, "datapackage.json"].into_iter().any(holds)
    };
    if is_one(path) {
        return Ok(vec![path.into()]);
    }
    if !path.exists() && path.to_str().is_some_and(Grid::is_shipped) {
        let name = path.display();
        return Err(anyhow!("{name}: no such file or folder; a shipped grid needs no check"));
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

/// Checks one thing, and says what was found, or all that is wrong.
fn check(
    path: &Path,
    device: Device,
    kept: &mut Option<(PathBuf, Renderer)>,
) -> Result<String, Vec<anyhow::Error>> {
    let one = |error: anyhow::Error| vec![error];
    if path.is_file() {
        check_file(path).map_err(one)
    } else if path.join("datapackage.json").exists() {
        check_study(path)
    } else {
        check_sequence(path, device, kept)
    }
}

/// Checks the records of a study, and its answers as an analysis reads them.
fn check_study(path: &Path) -> Result<String, Vec<anyhow::Error>> {
    let one = |error: anyhow::Error| vec![error];
    // The folders of pilots and simulated observers are studies, too.
    let study = status(path, StudyKind::Real, |_| None)
        .ok_or_else(|| one(anyhow!("{}: holds no protocol.toml", path.display())))?;
    if !study.faults.is_empty() {
        return Err(study.faults.into_iter().map(anyhow::Error::msg).collect());
    }
    shutterlab_analysis::input::responses::read(&[path]).map_err(|e| one(e.into()))?;
    let answers: u32 = study.sessions.iter().map(|session| session.answered).sum();
    Ok(format!("study, {}", counted(answers as usize, "answer")))
}

fn check_file(path: &Path) -> anyhow::Result<String> {
    let ending = path.extension().unwrap_or_default().to_string_lossy().to_lowercase();
    match ending.as_str() {
        "hdr" | "exr" => {
            let map = import::image::light_map(path)?;
            Ok(format!("light map, {}×{} texels", map.width, map.height))
        }
        "ply" | "obj" | "gltf" | "glb" | "stl" => {
            let mesh = import::model(path)?.mesh;
            let triangles = counted(mesh.triangles.len(), "triangle");
            Ok(format!("model, {triangles}, {} vertices", mesh.positions.len()))
        }
        "toml" => check_definition(path),
        _ => Err(anyhow!(
            "{}: ending: {ending:?}: grids, scenes, protocols, cohorts, fitted parameters, \
             display profiles (.toml), light maps (.hdr, .exr) and models (.ply, .obj, .gltf, \
             .glb) can be checked, and a sequence or a study by its folder",
            path.display()
        )),
    }
}

fn check_sequence(
    path: &Path,
    device: Device,
    kept: &mut Option<(PathBuf, Renderer)>,
) -> Result<String, Vec<anyhow::Error>> {
    if !path.join(FILE_NAME).exists() && path.join(UNFINISHED).exists() {
        let shown = path.display();
        return Err(vec![anyhow!("{shown}: unfinished: the same `render` command finishes it")]);
    }
    let sequence = Sequence::open(path).map_err(|e| vec![e.into()])?;
    // Of the folder `.` too.
    let whole = std::path::absolute(path).map_err(|e| vec![e.into()])?;
    let beside = whole.parent().unwrap_or(&whole).to_path_buf();
    let renderer = match kept {
        Some((folder, renderer)) if *folder == beside => renderer,
        _ => {
            let renderer =
                Renderer::open(device.into(), &beside).map_err(|error| vec![anyhow!(error)])?;
            &mut kept.insert((beside, renderer)).1
        }
    };
    let place = RandomState::new().hash_one(path) as usize;
    let all = |faults: Vec<VerifyError>| faults.into_iter().map(anyhow::Error::from).collect();
    let (index, agreement) = verify(&sequence, place, renderer).map_err::<Vec<_>, _>(all)?;
    let anew = match agreement {
        Agreement::SameBytes => "the same bytes".into(),
        Agreement::SameImage { relative_rmse, .. } => {
            format!("the same image (relative RMSE {relative_rmse:.1e}) by another renderer")
        }
    };
    let frames = counted(sequence.manifest.frames.len(), "frame");
    Ok(format!("{frames} as in the manifest, frame {index} rendered anew is {anew}"))
}

fn check_definition(path: &Path) -> anyhow::Result<String> {
    let file = path.display().to_string();
    let text = std::fs::read_to_string(path).with_context(|| format!("{file}: cannot be read"))?;
    // Only a grid has axes as a table, only a scene a camera, only a cohort observers, only fitted
    // parameters what they were fitted to, and only a protocol a question. Nothing in a display profile
    // is needed but its name.
    let keys: toml::Table = text.parse().unwrap_or_default();
    // No absolute path is the name of a shipped one.
    let absolute = std::path::absolute(path)?.display().to_string();
    let (found, assets) = if keys.contains_key("axes") {
        let grid = Grid::load(&absolute)?;
        let (stimuli, assets) = grid.resolve(&Default::default())?;
        (format!("grid, {}", counted(stimuli.len(), "sequence")), assets)
    } else if keys.contains_key("camera") {
        let (scene, assets) = Scene::load(&absolute, Path::new(""))?;
        (format!("scene {}", scene.name), assets)
    } else if keys.contains_key("observers") {
        let cohort = Cohort::parse(&text, &file)?;
        let count: u32 = cohort.observers.iter().map(|sort| sort.count).sum();
        return Ok(format!("cohort, {}", counted(count as usize, "observer")));
    } else if keys.contains_key("fitted_to") {
        let fitted = FittedParameters::parse(&text, &file)?.fitted_to;
        return Ok(format!("parameters fitted to {}", fitted.source));
    } else if ["question", "task", "design"].iter().any(|key| keys.contains_key(*key)) {
        return Ok(format!("protocol {}", Protocol::parse(&text, &file)?.name));
    } else if DISPLAY_KEYS.iter().any(|key| keys.contains_key(*key))
        || keys.keys().all(|key| ["schema", "name"].contains(&key.as_str())) && keys.len() == 2
    {
        return Ok(format!("display profile {}", DisplayProfile::parse(&text, &file)?.name));
    } else {
        return Err(anyhow!(
            "{file}: a grid has [axes], a scene [camera], a protocol a question, a cohort \
             [[observers]], fitted parameters [fitted_to], a display profile one of {}: this \
             file has none of these",
            DISPLAY_KEYS.join(", ")
        ));
    };
    assets.iter().try_for_each(import::check)?;
    Ok(found)
}
