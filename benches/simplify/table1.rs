//! Table 1 of Zhang et al. 2014 beside ours: how long it takes to get from the original to their numbers of faces,
//! and how many faces their law leaves in each reading of its units.

use super::cost::{self, Cost, median};
use super::{Failure, read};
use glam::DVec3;
use shutterlab::mesh::Mesh;
use shutterlab::mesh::simplify::detail::{PerimeterLimit, Viewing};
use shutterlab::mesh::simplify::direction::ScreenMotion;
use shutterlab::mesh::simplify::progressive::record;
use shutterlab::mesh::simplify::{Options, simplify};
use shutterlab::scene::screen_motion::{Described, Rule, framing};
use shutterlab_data_schema::fitted::{FrequencyUnit, LevelOfDetailLaw, VelocityUnit};
use shutterlab_stimuli::stimulus::View;
use std::path::Path;

/// A mesh, the model of the table that it stands for, how many faces are asked of it at the four speeds, and the
/// seconds of the table, on an Intel Core 2 Duo E8400.
const ROWS: [(&str, &str, [usize; 4], [f64; 4]); 4] = [
    ("bunny", "Bunny", [27_789, 13_894, 6946, 2777], [0.458, 0.146, 0.065, 0.036]),
    ("igea", "Armadillo", [88_666, 26_869, 8946, 3358], [3.317, 1.091, 0.370, 0.133]),
    ("dragon", "Buddha", [285_072, 66_744, 13_716, 4746], [10.95, 4.077, 0.978, 0.167]),
    ("large", "Asian Dragon", [88_035, 16_405, 7218, 3138], [63.219, 10.389, 0.591, 0.012]),
];

/// Speed-1 to Speed-4, in pixels per shutter.
const SPEEDS_PX: [f64; 4] = [10.0, 30.0, 90.0, 270.0];

/// The paper's images and the field of view of its experiments.
const SIZE_PX: [u32; 2] = [800, 600];
const FIELD_OF_VIEW_DEG: f64 = 33.33;

const RUNS: usize = 5;

/// Seconds on the clock from each number of faces to the next: by simplifying again, and from a record, where the
/// first row is the recording of all. In brackets the processor's seconds. How many times faster that is than
/// the table.
pub fn times(files: &[&str]) -> Result<(), Failure> {
    println!("{} threads", rayon::current_num_threads());
    println!(
        "mesh     stands for    faces  table s    simplified (core s)    times   recorded (core s)   times"
    );
    let mut least = [f64::INFINITY; 2];
    for file in files {
        let stem = Path::new(file).file_stem().unwrap_or_default().to_string_lossy();
        let names = ROWS.map(|row| row.0);
        let row = ROWS.into_iter().find(|row| row.0 == stem);
        let (name, model, faces, table_s) = row.ok_or(format!("{stem}: {names:?} are allowed"))?;
        let mesh = read(file)?;
        let (simplified, recorded) = (simplified(&mesh, faces)?, recorded(&mesh, faces)?);
        for k in 0..4 {
            print!("{name:8} {model:12} {:6} {:8.3}", faces[k], table_s[k]);
            for (least, costs) in least.iter_mut().zip([&simplified, &recorded]) {
                let wall_s = median(costs[k].iter().map(|cost| cost.wall_s));
                let cpu_s = median(costs[k].iter().map(|cost| cost.cpu_s));
                let times = table_s[k] / wall_s;
                *least = least.min(times);
                print!("   {wall_s:.5} ({cpu_s:.5}) {times:7.1}");
            }
            println!();
        }
    }
    println!("at least {:.1} and {:.1} times as fast", least[0], least[1]);
    Ok(())
}

fn simplified(mesh: &Mesh, faces: [usize; 4]) -> Result<[Vec<Cost>; 4], Failure> {
    let mut before = mesh.clone();
    let mut costs: [Vec<Cost>; 4] = Default::default();
    for (costs, faces) in costs.iter_mut().zip(faces) {
        let options = Options { faces, ..Options::default() };
        let mut next = Mesh::default();
        for _ in 0..RUNS {
            let (result, cost) = cost::of(|| simplify(&before, None, &options))?;
            next = result?.mesh;
            costs.push(cost);
        }
        before = next;
    }
    Ok(costs)
}

fn recorded(mesh: &Mesh, faces: [usize; 4]) -> Result<[Vec<Cost>; 4], Failure> {
    let options = Options { faces: faces[3], ..Options::default() };
    let mut costs: [Vec<Cost>; 4] = Default::default();
    for _ in 0..RUNS {
        let (recorded, cost) = cost::of(|| record(mesh, None, &options, &[]))?;
        costs[0].push(cost);
        let mut progressive = recorded?;
        progressive.set_faces(faces[0]);
        for (costs, faces) in costs[1..].iter_mut().zip(&faces[1..]) {
            let ((), cost) = cost::of(|| progressive.set_faces(*faces))?;
            costs.push(cost);
        }
    }
    Ok(costs)
}

/// How many faces of the bunny the law leaves at the four speeds, beside the table's, in each reading of its units.
/// The bunny goes to the right and fills the image.
pub fn law(file: &str) -> Result<(), Failure> {
    let mesh = read(file)?;
    let (middle, radius) = mesh.bounding_sphere();
    let camera = framing(middle.as_dvec3(), radius.into(), SIZE_PX, FIELD_OF_VIEW_DEG);
    let metres_per_px = 1.0 / camera.pixels_per_metre(SIZE_PX[0]);
    let view = View { camera, travel_m: [[0.0; 3]; 2], shift_px: 0.0, noise: 0 };
    let at_speed = |speed_px: f64| {
        let translation = DVec3::X * speed_px * metres_per_px;
        let (width_px, window) = (SIZE_PX[0], 1);
        let view = view.clone();
        Described { view, width_px, translation, turn: None, window, rule: Rule::Least }.paths()
    };

    let (_, _, table, _) = ROWS[0];
    println!(
        "{} faces; their area in the image, halved: {:.0} px",
        mesh.triangles.len(),
        covered_px(&mesh, &at_speed(0.0))
    );
    print!("{:44}", "v in, ρ in, at px/shutter");
    println!("{}", SPEEDS_PX.map(|speed| format!("{speed:>18}")).concat());
    println!("{:44}{}", "Table 1", table.map(|faces| format!("{faces:>18}")).concat());
    // Their display, 86.27 dpi at half a metre; a frame's time is not said.
    let pixel_m = 0.0254 / 86.27;
    let viewing = Viewing {
        pixels_per_degree: Some(1.0 / f64::atan2(pixel_m, 0.5).to_degrees()),
        shutter_seconds: Some(1.0 / 30.0),
    };
    for frequency_unit in [FrequencyUnit::PerPerimeterPixel, FrequencyUnit::PerPerimeterDegree] {
        for velocity_unit in [
            VelocityUnit::PixelsPerShutter,
            VelocityUnit::DegreesPerShutter,
            VelocityUnit::DegreesPerSecond,
        ] {
            let law =
                LevelOfDetailLaw { velocity_unit, frequency_unit, ..LevelOfDetailLaw::PUBLISHED };
            let limit = Some(PerimeterLimit::from_law(&law, viewing)?);
            print!("{:44}", format!("{}, {}", velocity_unit.symbol(), frequency_unit.symbol()));
            for (speed_px, table) in SPEEDS_PX.into_iter().zip(table) {
                let paths = at_speed(speed_px);
                let options = Options { limit, motion: Some(&paths), ..Options::default() };
                let faces = simplify(&mesh, None, &options)?.mesh.triangles.len();
                print!("{:>18}", format!("{faces} ({:.2})", faces as f64 / table as f64));
            }
            println!();
        }
    }
    Ok(())
}

/// Half the area of all triangles in the image: what a closed mesh covers, if no part hides another.
fn covered_px(mesh: &Mesh, motion: &dyn ScreenMotion) -> f32 {
    let double = |&triangle: &[u32; 3]| {
        let [a, b, c] = mesh.corners(triangle, 0.0).map(|p| motion.seen([p; 2]).position_px);
        (b - a).perp_dot(c - a).abs()
    };
    0.25 * mesh.triangles.iter().map(double).sum::<f32>()
}
