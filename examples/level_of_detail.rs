//! Draws the figures and prints the table of `docs/guide/level-of-detail.md`: the sensitivity to contrast, the
//! highest spatial frequency that is seen, and the published law by each reading of its units.
//!
//! `cargo run --example level_of_detail -- docs/guide/images`

use anyhow::Context;
use shutterlab::mesh::simplify::detail::{PerimeterLimit, Viewing};
use shutterlab_analysis::report::plot::{Axis, Plot, Series, Style};
use shutterlab_data_schema::fitted::{FrequencyUnit, LevelOfDetailLaw, VelocityUnit};
use shutterlab_stimuli::contrast_sensitivity::ContrastSensitivity;
use std::io::Write;

const EYE: ContrastSensitivity = ContrastSensitivity::DALY_1998;

/// The paper's display, 86.27 dpi at half a metre. Its shutter time is not told; this one is assumed.
const PIXELS_PER_DEGREE: f64 = 29.64;
const SHUTTER_SECONDS: f64 = 1.0 / 60.0;

/// What a model covers in the paper's images, roughly, in square pixels; half of its faces are seen.
const COVERED_PX: f64 = 1e5;

fn main() -> anyhow::Result<()> {
    let folder = std::env::args().nth(1).context("a folder for the figures is needed")?;
    std::fs::create_dir_all(&folder).context(folder.clone())?;
    let figures = [("sensitivity", sensitivity()), ("limit", limit()), ("law", law()?)];
    for (name, figure) in figures {
        let file = format!("{folder}/contrast-{name}.svg");
        std::fs::write(&file, figure.svg() + "\n").context(file)?;
    }
    table(&mut std::io::stdout())
}

/// Figure 3, left: a curve for each velocity.
fn sensitivity() -> Plot {
    let x = Axis::logarithmic("spatial frequency (cycles/deg)", [0.05, 50.0]);
    let y = Axis::logarithmic("contrast sensitivity", [1.0, 500.0]);
    let series = [0.15, 1.0, 3.0, 10.0, 30.0].map(|velocity| {
        let value = |frequency| Some(EYE.at(frequency, velocity));
        curve(format!("{velocity} deg/s"), Style::Line, [&x, &y], value)
    });
    let label = "Contrast sensitivity against spatial frequency for five retinal velocities";
    Plot { label: label.into(), series: series.into(), x, y, rules: vec![] }
}

/// Figure 3, right: a curve for each sensitivity.
fn limit() -> Plot {
    let x = Axis::logarithmic("retinal velocity (deg/s)", [0.1, 50.0]);
    let y = Axis::logarithmic("limit of spatial frequency (cycles/deg)", [0.2, 50.0]);
    let series = [1.0, 10.0, 50.0, 100.0].map(|sensitivity| {
        let value = |velocity| EYE.limit_frequency(sensitivity, velocity);
        curve(format!("sensitivity {sensitivity}"), Style::Line, [&x, &y], value)
    });
    let label =
        "Highest visible spatial frequency against retinal velocity, for four sensitivities";
    Plot { label: label.into(), series: series.into(), x, y, rules: vec![] }
}

/// The limit at sensitivity 1 and the law. A perimeter is taken for a cycle, as the paper does.
fn law() -> anyhow::Result<Plot> {
    let x = Axis::logarithmic("velocity on retina and screen (deg/s)", [0.1, 1000.0]);
    let y = Axis::logarithmic("spatial frequency (cycles/deg)", [0.01, 100.0]);
    let visible = |velocity| EYE.limit_frequency(1.0, velocity);
    let mut series = vec![curve("visible".into(), Style::Line, [&x, &y], visible)];
    for (name, limit) in readings()? {
        let value = |velocity: f64| {
            let speed_px = velocity * PIXELS_PER_DEGREE * SHUTTER_SECONDS;
            Some(PIXELS_PER_DEGREE / f64::from(limit.at(speed_px as f32)))
        };
        series.push(curve(name, Style::Dashed, [&x, &y], value));
    }
    let label =
        "The published law by each reading of its units beside the highest visible frequency";
    Ok(Plot { label: label.into(), series, x, y, rules: vec![] })
}

/// The published law in each pair of units that makes a difference, in pixels.
fn readings() -> anyhow::Result<Vec<(String, PerimeterLimit)>> {
    use FrequencyUnit::{PerPerimeterDegree, PerPerimeterPixel};
    let viewing = Viewing {
        pixels_per_degree: Some(PIXELS_PER_DEGREE),
        shutter_seconds: Some(SHUTTER_SECONDS),
    };
    let units = [
        (VelocityUnit::PixelsPerShutter, PerPerimeterPixel),
        (VelocityUnit::DegreesPerShutter, PerPerimeterPixel),
        (VelocityUnit::DegreesPerShutter, PerPerimeterDegree),
        (VelocityUnit::DegreesPerSecond, PerPerimeterPixel),
    ];
    let reading = |(velocity_unit, frequency_unit): (VelocityUnit, FrequencyUnit)| {
        let law = LevelOfDetailLaw { velocity_unit, frequency_unit, ..LevelOfDetailLaw::PUBLISHED };
        let of = if frequency_unit == PerPerimeterPixel { "1/px" } else { "1/deg" };
        let limit = PerimeterLimit::from_law(&law, viewing)?;
        Ok((format!("{}, {of}", velocity_unit.symbol()), limit))
    };
    units.map(reading).into_iter().collect()
}

/// The perimeters that the law allows at the paper's speeds, and the faces of that size that a model has.
fn table(out: &mut impl Write) -> anyhow::Result<()> {
    writeln!(out, "| units of v and ρ | 10 | 30 | 90 | 270 px/shutter |\n|---|---|---|---|---|")?;
    for (name, limit) in readings()? {
        let cell = |speed: f32| {
            let perimeter = f64::from(limit.at(speed));
            // An equilateral triangle of perimeter p has the area p²/(12·√3).
            let faces = 2.0 * COVERED_PX * 12.0 * 3f64.sqrt() / (perimeter * perimeter);
            format!("{perimeter:.1} px, {faces:.0}")
        };
        writeln!(out, "| {name} | {} |", [10.0, 30.0, 90.0, 270.0].map(cell).join(" | "))?;
    }
    Ok(())
}

/// A curve where it has values on the axes.
fn curve(
    name: String,
    style: Style,
    [x, y]: [&Axis; 2],
    value: impl Fn(f64) -> Option<f64>,
) -> Series {
    let ([left, right], [low, high]) = (x.range, y.range);
    let steps = (0..=400).map(|k| left * (right / left).powf(f64::from(k) / 400.0));
    let points = steps.filter_map(|x| Some([x, value(x)?]));
    let points = points.filter(|[_, y]| (low..=high).contains(y)).collect();
    Series { name, style, points, intervals: vec![] }
}
