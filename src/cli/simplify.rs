//! `shutterlab simplify`: a mesh with fewer faces, for a number of them, an error, or a motion.

mod plan;
mod report;

use super::fit::parse_from_0;
use super::motion_args::MotionArgs;
use super::{UsageError, counted, say};
use crate::mesh::simplify::{Attributes, simplify};
use crate::raster::picture::side_by_side;
use crate::scene::export::{self, Format};
use crate::scene::import::{self, Model};
use anyhow::anyhow;
use indicatif::{ProgressBar, ProgressFinish};
use plan::{Goal, Tolerance, WeightKind};
use shutterlab_data_schema::files::write_atomically;
use shutterlab_stimuli::assets::companions;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// Simplify a mesh: to a number of faces, within an error, or as far as a law of its speed allows
#[derive(Debug, clap::Args)]
pub struct Args {
    /// The mesh: .ply, .obj, .gltf, .glb or .stl
    mesh: PathBuf,
    /// The simplified mesh, in any of these formats
    #[arg(short, long, value_name = "FILE")]
    out: PathBuf,
    /// Stop at so many faces
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = plan::parse_faces)]
    faces: Option<usize>,
    /// Stop at this part of the faces, above 0 and up to 1
    #[arg(long, value_name = "R", allow_negative_numbers = true, conflicts_with = "faces", value_parser = plan::parse_ratio)]
    ratio: Option<f64>,
    /// No contraction with a larger error: in the mesh's unit, or as a part of the diagonal of its bounding
    /// box, such as 0.1%
    #[arg(long, value_name = "E", allow_negative_numbers = true, value_parser = plan::parse_tolerance)]
    error: Option<Tolerance>,
    /// How an edge's direction to the motion weighs: isotropic, printed or mirrored; without this,
    /// printed if there is an r, here or in the parameters' file, else isotropic
    #[arg(long, value_name = "WEIGHT", value_parser = plan::parse_weight)]
    weight: Option<WeightKind>,
    /// The exponent r of the weight; without this, that of the parameters' file, or 4
    #[arg(long, value_name = "R", allow_negative_numbers = true, value_parser = parse_from_0)]
    r: Option<f64>,
    /// The constant ε of the weight; without this, that of the parameters' file, or 0.5
    #[arg(long, value_name = "E", allow_negative_numbers = true, value_parser = parse_from_0)]
    epsilon: Option<f64>,
    /// Weight and level-of-detail law as `fit -o` writes them; what is missing there is as published
    #[arg(long, value_name = "FILE")]
    parameters: Option<PathBuf>,
    /// What becomes of normals and texture coordinates: quadrics (they are placed best) or averaged
    #[arg(long, value_name = "HOW", default_value = "quadrics", value_parser = plan::parse_attributes)]
    attributes: Attributes,
    /// Draw the mesh and the simplified one side by side, shaded and with their edges, into this PNG file
    #[arg(long, value_name = "FILE")]
    picture: Option<PathBuf>,
    /// Print statistics and the geometric error, which is measured for it, as JSON
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    motion: MotionArgs,
    /// The simplified model as the shutter closes, if it deforms
    #[arg(long, value_name = "FILE", help_heading = "Motion")]
    end_out: Option<PathBuf>,
}

pub(super) fn run(args: &Args) -> anyhow::Result<()> {
    let goal = Goal::new(args)?;
    check_files(args)?;
    let bar = ProgressBar::new_spinner().with_finish(ProgressFinish::AndClear);
    bar.enable_steady_tick(Duration::from_millis(100));
    let mut clock = report::Clock::default();

    bar.set_message(format!("reading {}", args.mesh.display()));
    let mut model = import::model(&args.mesh)?;
    let seen = args.motion.resolve(&mut model.mesh)?;
    if args.end_out.is_some() && model.mesh.end_positions.is_none() {
        let needed = "simplify: --end-out: the model does not deform: --end-mesh is needed";
        return Err(UsageError::from(needed));
    }
    let plan = goal.of(&model.mesh, seen.as_ref())?;
    clock.stage("read");

    bar.set_message("simplifying");
    let groups = (model.materials.len() > 1).then_some(&model.face_materials[..]);
    let found = simplify(&model.mesh, groups, &plan.options())
        .map_err(|error| anyhow!("{}: {error}", args.mesh.display()))?;
    clock.stage("simplify");

    bar.set_message(format!("writing {}", args.out.display()));
    let simplified = Model {
        mesh: found.mesh.clone(),
        face_materials: found.faces.iter().map(|&f| model.face_materials[f as usize]).collect(),
        materials: model.materials.clone(),
    };
    let picture = args.picture.as_deref().map(|path| picture(args, &model, &simplified, path));
    picture.transpose()?;
    let left_out = write(args, simplified)?;
    clock.stage("write");

    let result = match args.json {
        true => {
            bar.set_message("measuring");
            let report = report::json(args, &plan, &model.mesh, &found, &left_out, clock);
            serde_json::to_string_pretty(&report)?
        }
        false => report::text(args, &model.mesh, &found, &clock),
    };
    bar.finish_and_clear();
    if !left_out.is_empty() {
        eprintln!("{}: is without {}", args.out.display(), left_out.join(", "));
    }
    if !plan.is_reached(&found.mesh) {
        let left = counted(found.mesh.triangles.len(), "face");
        let out = args.out.display();
        eprintln!(
            "{out}: {left}, and {} asked for: {} allows no more contractions",
            plan.faces(),
            if args.error.is_some() { "--error" } else { "the surface" }
        );
    }
    say(&result)
}

/// Writes what was found; returns what the format cannot hold.
fn write(args: &Args, mut simplified: Model) -> anyhow::Result<Vec<String>> {
    let end_out = args.end_out.as_ref();
    let end = end_out.and_then(|out| Some((out, simplified.mesh.end_positions.take()?)));
    let left_out = export::model(&simplified, &args.out)?;
    if let Some((out, positions)) = end {
        simplified.mesh.positions = positions;
        export::model(&simplified, out)?;
    }
    Ok(left_out)
}

fn picture(args: &Args, model: &Model, simplified: &Model, path: &Path) -> anyhow::Result<()> {
    let (view, width_px) = args.motion.view(&model.mesh)?;
    let image = side_by_side(model, simplified, &view, width_px)?;
    Ok(write_atomically(path, &image.to_png()?)?)
}

/// Refuses, before anything is done, to write what cannot be written or over what is read.
fn check_files(args: &Args) -> anyhow::Result<()> {
    let read = [Some(&args.mesh), args.motion.end_mesh.as_ref()];
    let mut taken: BTreeSet<PathBuf> = BTreeSet::new();
    for mesh in read.into_iter().flatten() {
        taken.insert(place(mesh));
        // A file that cannot be read is the reader's to tell.
        let beside = companions(mesh).unwrap_or_default();
        taken.extend(beside.iter().map(|name| place(&mesh.with_file_name(name))));
    }
    let mut claim = |path: &Path| {
        if taken.insert(place(path)) {
            return Ok(());
        }
        let allowed = "it is read or written already: another name is needed";
        Err(UsageError::from(format!("simplify: {}: {allowed}", path.display())))
    };
    let format = Format::of(&args.out).map_err(UsageError::from)?;
    for out in [Some(&args.out), args.end_out.as_ref()].into_iter().flatten() {
        let own = Format::of(out).map_err(UsageError::from)?;
        if args.end_out.is_some() && (own != format || own == Format::Stl) {
            let needed = "two poses are of one format, which has vertices: not .stl";
            return Err(UsageError::from(format!("simplify: {}: {needed}", out.display())));
        }
        export::check_folder(out)?;
        claim(out)?;
        own.companion(out).map_or(Ok(()), |path| claim(&path))?;
    }
    let Some(picture) = &args.picture else { return Ok(()) };
    if !picture.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("png")) {
        let needed = format!("simplify: --picture: {}: it ends in .png", picture.display());
        return Err(UsageError::from(needed));
    }
    export::check_folder(picture)?;
    claim(picture)
}

/// What tells whether two paths are of one file.
fn place(path: &Path) -> PathBuf {
    let absolute = || Some(path.with_file_name("").canonicalize().ok()?.join(path.file_name()?));
    path.canonicalize().ok().or_else(absolute).unwrap_or(path.into())
}
