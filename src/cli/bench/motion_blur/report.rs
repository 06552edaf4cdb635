//! The measurements as a table, a CSV and figures.

use super::{Row, SPEEDS_PX};
use crate::cli::say;
use anyhow::anyhow;
use shutterlab_analysis::report::plot::{Axis, Plot, Series, Style};
use shutterlab_data_schema::files::write_atomically;
use shutterlab_stimuli::stimulus::Method;
use std::fmt::Write;
use std::path::Path;

/// Prints the rows, and writes them and a figure per method into `folder`.
pub fn give(rows: &[Row], folder: Option<&Path>) -> anyhow::Result<()> {
    if let Some(folder) = folder {
        let mut csv = csv::Writer::from_writer(vec![]);
        rows.iter().try_for_each(|row| csv.serialize(row))?;
        let table = csv.into_inner().map_err(|error| anyhow!("motion-blur.csv: {error}"))?;
        write_atomically(&folder.join("motion-blur.csv"), &table)?;
        for (name, _) in Method::ALL {
            let file = folder.join(format!("motion-blur-{name}.svg"));
            write_atomically(&file, (figure(rows, name).svg() + "\n").as_bytes())?;
        }
    }
    say(&text(rows)?)
}

fn text(rows: &[Row]) -> anyhow::Result<String> {
    let mut text = String::from(
        "model               faces    simpl.     px  method                      on   seconds    simpl.     empty  speedup   with s.       net  rel.err\n",
    );
    for row in rows {
        let net = row.speedup_above_empty.map_or("-".into(), |net| format!("{net:.2}"));
        writeln!(
            text,
            "{:<16} {:>8} {:>9} {:>6}  {:<25} {:>4} {:>9.3} {:>9.3} {:>9.3} {:>8.2} {:>9.2} {:>9} {:>8.3}",
            row.model,
            row.faces,
            row.simplified_faces,
            row.px_per_shutter,
            row.method,
            row.device,
            row.seconds,
            row.simplified_seconds,
            row.empty_seconds,
            row.speedup,
            row.speedup_with_simplification,
            net,
            row.relative_rmse
        )?;
    }
    Ok(text)
}

/// Speed-up ratios over the speed, without the simplification and, dashed, with it.
fn figure(rows: &[Row], method: &str) -> Plot {
    let of_method = || rows.iter().filter(|row| row.method == method);
    let mut models: Vec<&str> = of_method().map(|row| row.model.as_str()).collect();
    models.dedup();
    let mut series = vec![];
    for model in models {
        let mut add = |name, style, value: fn(&Row) -> f64| {
            let own = of_method().filter(|row| row.model == model);
            let points = own.map(|row| [f64::from(row.px_per_shutter), value(row)]).collect();
            series.push(Series { name, style, points, intervals: vec![] });
        };
        add(format!("{model}, excluded"), Style::Line, |row| row.speedup);
        add(format!("{model}, included"), Style::Dashed, |row| row.speedup_with_simplification);
    }
    let ratios = series.iter().flat_map(|series| &series.points).map(|point| point[1]);
    let y = Axis::of("speed-up ratio", ratios.chain([0.0, 1.0]));
    let [slow, .., fast] = SPEEDS_PX.map(f64::from);
    Plot {
        label: format!(
            "Speed-up ratio by {method} over the speed, time of simplification excluded and included"
        ),
        series,
        x: Axis::logarithmic("screen velocity (px/shutter)", [0.8 * slow, 1.25 * fast]),
        y,
        rules: vec![],
    }
}
