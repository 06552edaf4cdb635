//! Simplifies a model that crosses the view as far as the blur hides it, and tells by how much:
//! `cargo run --release --example simplify_for_motion -- MODEL PIXELS_PER_SHUTTER OUT`.
#![expect(clippy::print_stdout, reason = "it tells what it did")]

use anyhow::{Context, ensure};
use glam::DVec3;
use shutterlab::mesh::simplify::detail::{PerimeterLimit, Viewing};
use shutterlab::mesh::simplify::{Options, simplify};
use shutterlab::scene::screen_motion::{Described, Rule, framing};
use shutterlab::scene::{export, import};
use shutterlab_data_schema::fitted::LevelOfDetailLaw;
use shutterlab_stimuli::stimulus::View;
use std::path::PathBuf;

fn main() -> anyhow::Result<()> {
    let arguments: Vec<PathBuf> = std::env::args_os().skip(1).map(PathBuf::from).collect();
    let [model, pixels, out] = &arguments[..] else {
        anyhow::bail!("MODEL PIXELS_PER_SHUTTER OUT are needed");
    };
    let pixels = pixels.to_string_lossy();
    let pixels: f64 = pixels.parse().context(format!("PIXELS_PER_SHUTTER: {pixels}"))?;
    ensure!(pixels >= 0.0, "PIXELS_PER_SHUTTER: {pixels}: a number from 0 is needed");
    let mut model = import::model(model)?;

    // The camera looks along −z at the middle of the model, which goes along x.
    let (middle, radius) = model.mesh.bounding_sphere();
    let camera = framing(middle.as_dvec3(), radius.into(), [800, 600], 33.33);
    let metres_per_pixel = camera.look_at_distance_m() / camera.focal_length_px(800);
    let motion = Described {
        view: View { camera, travel_m: [[0.0; 3]; 2], shift_px: 0.0, noise: 0 },
        width_px: 800,
        translation: DVec3::X * pixels * metres_per_pixel,
        turn: None,
        window: 1,
        rule: Rule::Least,
    };
    let limit = PerimeterLimit::from_law(&LevelOfDetailLaw::PUBLISHED, Viewing::default())?;
    let options =
        Options { motion: Some(&motion.paths()), limit: Some(limit), ..Options::default() };
    let simplified = simplify(&model.mesh, Some(&model.face_materials), &options)?;

    let before = model.mesh.triangles.len();
    println!("{before} faces became {}", simplified.mesh.triangles.len());
    model.face_materials =
        simplified.faces.iter().map(|&face| model.face_materials[face as usize]).collect();
    model.mesh = simplified.mesh;
    for what in export::model(&model, out)? {
        println!("without {what}");
    }
    Ok(())
}
