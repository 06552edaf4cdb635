//! What a weight of the edges' directions is worth: how far the blurred images of simplified models are from
//! that of the original, at equal numbers of faces.
//!
//! ```text
//! script/bench motion_weight [-o DIR] [--peer DIR]… MODELS…
//! ```
//! Each model moves in four directions and turns, at the four speeds and with the ratios of faces of Zhang
//! et al. 2014 (Table 1, bunny), and is simplified without a weight, with Eq. 4 as printed and mirrored, each
//! with the paper's r and ε = 0.5. An image is the mean of 432 instants: grey Lambertian model of 10⁵ pixels,
//! two distant lamps and a little ambient light, black background, a field of view of 33.33° over 600 rows;
//! the frame is as large as the path. It is shaded with area-weighted normals at the vertices of the mesh that
//! is drawn (`smooth`) and with those of its faces (`flat`). Errors are means over the pixels that the
//! original touches: relative MSE, squared error over mean square, and FLIP at 29.6 pixels per degree.
//!
//! `--peer DIR` adds the meshes of another program, `DIR/MODEL-FACES.ply`, under the name of DIR.
//! `DIR/motion-weight.csv` (by default in `target/bench`) has all numbers; what is there is not computed
//! again. In the end tables and figures over the whole file are made.
#![expect(clippy::print_stdout, reason = "a benchmark prints")]

mod stage;
mod summary;

use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use shutterlab::film::measure;
use shutterlab::mesh::Mesh;
use shutterlab::mesh::simplify::direction::Weight;
use shutterlab::mesh::simplify::{Options, simplify};
use shutterlab::scene::import;
use shutterlab::scene::screen_motion::Described;
use shutterlab_stimuli::LinearImage;
use shutterlab_stimuli::frames::Transfer;
use stage::Stage;
use std::path::{Path, PathBuf};

/// Pixels per shutter, and the faces that are left of a hundred.
pub const SPEEDS: [(f32, usize); 4] = [(10.0, 40), (30.0, 20), (90.0, 10), (270.0, 4)];
/// The paper's exponents; 0 is no weight.
const EXPONENTS: [f32; 7] = [0.125, 0.25, 0.5, 1.0, 2.0, 4.0, 8.0];
const EPSILON: f32 = 0.5;
/// Of the paper's display: 86.27 dpi, half a metre away.
const PIXELS_PER_DEGREE: f32 = 29.64;

type Failure = Box<dyn std::error::Error + Send + Sync>;

/// The error of one image.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Row {
    model: String,
    direction: String,
    speed_px: f32,
    weight: String,
    r: f32,
    faces: usize,
    shading: String,
    relative_mse: f64,
    mse: f64,
    flip: f64,
}

fn main() -> Result<(), Failure> {
    let (mut models, mut folder, mut peers) = (vec![], PathBuf::from("target/bench"), vec![]);
    // cargo says --bench.
    let mut words = std::env::args().skip(1).filter(|word| word != "--bench");
    while let Some(word) = words.next() {
        let mut next =
            || words.next().map(PathBuf::from).ok_or(format!("{word}: a folder is missing"));
        match word.as_str() {
            "-o" => folder = next()?,
            "--peer" => peers.push(next()?),
            _ => models.push(PathBuf::from(word)),
        }
    }
    std::fs::create_dir_all(&folder)?;
    let path = folder.join("motion-weight.csv");
    let mut rows: Vec<Row> = match path.exists() {
        true => csv::Reader::from_path(&path)?.deserialize().collect::<Result<_, _>>()?,
        false => vec![],
    };
    for model in &models {
        measure_model(model, &peers, &mut rows, &path)?;
    }
    summary::print(&rows);
    summary::draw(&rows, &folder)?;
    Ok(())
}

/// Adds what is missing of a model to the rows and the file.
fn measure_model(
    model: &Path,
    peers: &[PathBuf],
    rows: &mut Vec<Row>,
    path: &Path,
) -> Result<(), Failure> {
    let name = model.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let stage = Stage::new(import::model(model)?.mesh);
    for (speed_px, percent) in SPEEDS {
        let faces = stage.mesh.triangles.len() * percent / 100;
        for (direction, motion) in stage.motions(f64::from(speed_px)) {
            let is_here = |row: &Row| {
                row.model == name && row.speed_px == speed_px && row.direction == direction
            };
            let mut ways = ways(peers, &name, faces);
            ways.retain(|(weight, r, _)| {
                !rows.iter().any(|row| is_here(row) && row.weight == *weight && row.r == *r)
            });
            if ways.is_empty() {
                continue;
            }
            let truth = stage.blurred(&stage.mesh, &motion);
            let found: Vec<[Row; 2]> = ways
                .into_par_iter()
                .map(|(weight, r, way)| {
                    let mesh = way.mesh(&stage.mesh, &motion, faces)?;
                    let images = stage.blurred(&mesh, &motion);
                    let row = |shading: usize| -> Result<Row, Failure> {
                        let [relative_mse, mse, flip] = errors(&images[shading], &truth[shading])?;
                        Ok(Row {
                            model: name.clone(),
                            direction: direction.into(),
                            speed_px,
                            weight: weight.clone(),
                            r,
                            faces: mesh.triangles.len(),
                            shading: ["smooth", "flat"][shading].into(),
                            relative_mse,
                            mse,
                            flip,
                        })
                    };
                    Ok([row(0)?, row(1)?])
                })
                .collect::<Result<_, Failure>>()?;
            rows.extend(found.into_iter().flatten());
            // All of it, so that a file is never cut off within a row.
            let mut csv = csv::Writer::from_writer(vec![]);
            rows.iter().try_for_each(|row| csv.serialize(row))?;
            let text = csv.into_inner().map_err(|error| error.to_string())?;
            shutterlab_data_schema::files::write_atomically(path, &text)?;
        }
    }
    Ok(())
}

/// How a simplified mesh comes about.
enum Way {
    Ours(Weight),
    File(PathBuf),
}

/// All ways with their names and r.
fn ways(peers: &[PathBuf], model: &str, faces: usize) -> Vec<(String, f32, Way)> {
    let mut ways = vec![("isotropic".into(), 0.0, Way::Ours(Weight::Isotropic))];
    for r in EXPONENTS {
        let epsilon = EPSILON;
        ways.push(("printed".into(), r, Way::Ours(Weight::Printed { r, epsilon })));
        ways.push(("mirrored".into(), r, Way::Ours(Weight::Mirrored { r, epsilon })));
    }
    for folder in peers {
        let name = folder.file_name().unwrap_or_default().to_string_lossy().into_owned();
        ways.push((name, 0.0, Way::File(folder.join(format!("{model}-{faces}.ply")))));
    }
    ways
}

impl Way {
    fn mesh(&self, model: &Mesh, motion: &Described, faces: usize) -> Result<Mesh, Failure> {
        match self {
            Self::Ours(weight) => {
                let paths = motion.paths();
                let options =
                    Options { faces, weight: *weight, motion: Some(&paths), ..Options::default() };
                Ok(simplify(model, None, &options)?.mesh)
            }
            Self::File(path) => Ok(import::model(path)?.mesh),
        }
    }
}

/// Relative MSE, squared error over mean square, and FLIP, as means over the pixels that the truth touches.
fn errors(image: &LinearImage, truth: &LinearImage) -> Result<[f64; 3], Failure> {
    let black = LinearImage { pixels: vec![[0.0; 3]; truth.pixels.len()], ..*truth };
    let touched = truth.pixels.iter().filter(|pixel| **pixel != [0.0; 3]).count();
    let per_touched = truth.pixels.len() as f64 / touched as f64;
    let relative_mse = measure::relative_mse(image, truth, measure::epsilon(truth, &black));

    let pairs = || image.pixels.iter().zip(&truth.pixels).map(|(x, y)| [x[0], y[0]].map(f64::from));
    let squares: f64 = pairs().map(|[_, y]| y * y).sum();
    let mse = pairs().map(|[x, y]| (x - y).powi(2)).sum::<f64>() / squares;

    let seen = |image: &LinearImage| {
        let encoded = image.encode(0.0, Transfer::Srgb);
        flip_rs::RgbImage::new(encoded.width as usize, encoded.height as usize, encoded.bytes)
    };
    let map = flip_rs::ldr_flip(&seen(truth)?, &seen(image)?, PIXELS_PER_DEGREE)?;
    let flip = f64::from(map.statistics().mean);
    Ok([relative_mse * per_touched, mse, flip * per_touched])
}
