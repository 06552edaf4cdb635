//! What the errors say: ratios to the mesh simplified without a weight, as tables and figures.

use super::{Failure, Row, SPEEDS};
use shutterlab_analysis::maths::student::t_975;
use shutterlab_analysis::report::plot::{Axis, Plot, Series, Style};
use std::collections::{BTreeMap, HashMap};
use std::path::Path;

/// An error: its name, and where it is in a row.
type Measure = (&'static str, fn(&Row) -> f64);

const MEASURES: [Measure; 3] =
    [("relative MSE", |row| row.relative_mse), ("FLIP", |row| row.flip), ("MSE", |row| row.mse)];
const SHADINGS: [&str; 2] = ["smooth", "flat"];

/// A weight and its r.
type Way<'a> = (&'a str, f32);

const ISOTROPIC: Way = ("isotropic", 0.0);

/// Errors of one way over those of another with as many faces, same model, motion and shading.
struct Ratios {
    /// Geometric mean, and its 95 % interval over models: Student's t of the models' means.
    mean: f64,
    interval: [f64; 2],
    /// How many are below 1, of how many.
    wins: usize,
    count: usize,
}

/// The ratios of `way` to `base`, at one speed or at all; none for fewer than two models.
fn ratios(
    rows: &[Row],
    measure: Measure,
    shading: &str,
    speed: Option<f32>,
    [way, base]: [Way; 2],
) -> Option<Ratios> {
    let of = |(weight, r): Way<'_>| -> HashMap<_, f64> {
        let is_wanted = |row: &&Row| {
            let is_at = speed.is_none_or(|speed| row.speed_px == speed);
            is_at && row.shading == shading && row.weight == weight && row.r == r
        };
        let key = |row: &Row| (row.model.clone(), row.direction.clone(), row.speed_px.to_bits());
        rows.iter().filter(is_wanted).map(|row| (key(row), measure.1(row).ln())).collect()
    };
    let known = of(base);
    let mut models: BTreeMap<String, Vec<f64>> = BTreeMap::new();
    for (key, logarithm) in of(way) {
        if let Some(base) = known.get(&key) {
            models.entry(key.0).or_default().push(logarithm - base);
        }
    }
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    let means: Vec<f64> = models.values().map(|logarithms| mean(logarithms)).collect();
    let (centre, n) = (mean(&means), means.len() as f64);
    if n < 2.0 {
        return None;
    }
    let variance = means.iter().map(|m| (m - centre).powi(2)).sum::<f64>() / (n - 1.0);
    let half = t_975(n - 1.0) * (variance / n).sqrt();
    let all = || models.values().flatten();
    Some(Ratios {
        mean: centre.exp(),
        interval: [(centre - half).exp(), (centre + half).exp()],
        wins: all().filter(|logarithm| **logarithm < 0.0).count(),
        count: all().count(),
    })
}

/// All ways but the isotropic.
fn ways(rows: &[Row]) -> Vec<Way<'_>> {
    let mut found: Vec<Way> = vec![];
    for row in rows {
        let way = (row.weight.as_str(), row.r);
        if way != ISOTROPIC && !found.contains(&way) {
            found.push(way);
        }
    }
    found.sort_by(|a, b| a.0.cmp(b.0).then(a.1.total_cmp(&b.1)));
    found
}

/// Tables in Markdown: for each measure and shading, a row per pair of ways and a column per speed.
pub fn print(rows: &[Row]) {
    let ways = ways(rows);
    let printed = ways.iter().filter(|way| way.0 == "printed");
    let pairs = (ways.iter().map(|&way| [way, ISOTROPIC]))
        .chain(printed.map(|&(name, r)| [(name, r), ("mirrored", r)]));
    for (measure, shading) in
        MEASURES.into_iter().flat_map(|m| SHADINGS.map(|shading| (m, shading)))
    {
        println!("\n{}, {shading}: mean ratio, [95 % interval], times below 1\n", measure.0);
        print!("| r | of | to | all speeds |");
        SPEEDS.iter().for_each(|(speed, _)| print!(" {speed} px |"));
        println!("\n|---|---|---|---|{}", "---|".repeat(SPEEDS.len()));
        for pair in pairs.clone() {
            print!("| {} | {} | {} |", pair[0].1, pair[0].0, pair[1].0);
            for speed in std::iter::once(None).chain(SPEEDS.map(|(speed, _)| Some(speed))) {
                match ratios(rows, measure, shading, speed, pair) {
                    Some(Ratios { mean, interval: [low, high], wins, count }) => {
                        print!(" {mean:.3} [{low:.3}, {high:.3}] {wins}/{count} |");
                    }
                    None => print!(" – |"),
                }
            }
            println!();
        }
    }
}

/// A figure per measure: the ratio to isotropic over r.
pub fn draw(rows: &[Row], folder: &Path) -> Result<(), Failure> {
    for measure in MEASURES {
        let mut series = vec![];
        for weight in ["printed", "mirrored"] {
            for (shading, style) in SHADINGS.into_iter().zip([Style::Line, Style::Dashed]) {
                let (points, intervals) = (ways(rows).into_iter())
                    .filter(|way| way.0 == weight)
                    .filter_map(|way| {
                        let found = ratios(rows, measure, shading, None, [way, ISOTROPIC])?;
                        Some(([f64::from(way.1), found.mean], found.interval))
                    })
                    .unzip();
                series.push(Series {
                    name: format!("{weight}, {shading}"),
                    style,
                    points,
                    intervals,
                });
            }
        }
        let bounds = series.iter().flat_map(|series| series.intervals.iter().flatten()).copied();
        let title = format!("{}, ratio to isotropic", measure.0);
        let plot = Plot {
            label: format!("{title}, over the exponent r of the weight"),
            y: Axis::of(&title, bounds.chain([1.0])),
            x: Axis::logarithmic("r", [0.125, 8.0]),
            series,
            rules: vec![(1.0, "isotropic".into())],
        };
        let name = measure.0.to_lowercase().replace(' ', "-");
        std::fs::write(folder.join(format!("motion-weight-{name}.svg")), plot.svg())?;
    }
    Ok(())
}
