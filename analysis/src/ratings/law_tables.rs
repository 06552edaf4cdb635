//! The re-fit of the law of the level of detail as tables and a figure.

use super::joint_law::{JointLaw, JointParameter, ModelUnderLaw};
use super::law::Refit;
use super::over_models::OverModels;
use super::reciprocal::ReciprocalFit;
use crate::report::plot::{Axis, Plot, Series, Style};
use crate::report::section::{Cell, Column, Figure, Kind, Table};
use shutterlab_data_schema::fitted::LevelOfDetailLaw;

const PUBLISHED: LevelOfDetailLaw = LevelOfDetailLaw::PUBLISHED;

/// The symbols of the units of velocity and frequency.
pub(super) fn units(refit: &Refit) -> [&'static str; 2] {
    [refit.setting.velocity_unit.symbol(), refit.setting.frequency_unit.symbol()]
}

fn number(name: &str, title: &str, description: &str) -> Column {
    Column::new(name, title, Kind::Number(5), description)
}

/// The law from all answers, and how well it holds for each model.
pub(super) fn joint_tables(refit: &Refit, joint: &JointLaw) -> [Table; 2] {
    let [velocity, frequency] = units(refit);
    let unit = [format!("1/({frequency} · {velocity})"), format!("1/({frequency})")];
    let row = |i: usize| {
        let JointParameter { estimate, se, interval_95: [low, high] } = joint.sigma[i];
        let less = [&refit.sigma_1_less_published, &refit.sigma_2_less_published][i];
        let published = [PUBLISHED.sigma_1.value, PUBLISHED.sigma_2.value][i];
        let difference = less.as_ref().map_or(Cell::Missing, |_| (estimate - published).into());
        let name = ["sigma_1", "sigma_2"][i];
        let numbers = [estimate, se, low, high, published].map(Cell::from);
        [name.into(), unit[i].as_str().into()]
            .into_iter()
            .chain(numbers)
            .chain([difference])
            .collect()
    };
    let of_model =
        |of: &ModelUnderLaw| vec![of.model.as_str().into(), of.same.into(), of.expected.into()];
    [
        Table {
            name: "law-from-all-answers".into(),
            caption: "The law from all answers at once".into(),
            columns: vec![
                Column::new("parameter", "parameter", Kind::Text, "sigma_1 or sigma_2."),
                Column::new("unit", "unit", Kind::Text, "Its unit."),
                number("estimate", "estimate", "Estimate of the largest likelihood."),
                number("se", "SE", "Its standard error, by the jackknife over observers."),
                number("jackknife_95_low", "95 %", "Lower bound of its 95 % interval."),
                number("jackknife_95_high", "to", "Upper bound of its 95 % interval."),
                number(
                    "published",
                    "published",
                    "What Zhang et al. (2014) print, v in px/shutter, ρ in 1/px.",
                ),
                number(
                    "difference",
                    "difference",
                    "estimate − published; empty where the units differ.",
                ),
            ],
            rows: vec![row(0), row(1)],
        },
        Table {
            name: "models-under-the-law".into(),
            caption: "How well it holds for each model".into(),
            columns: vec![
                Column::new("model", "model", Kind::Text, "The model."),
                number("same", "same", "Share of the answers that say \"same\"."),
                number("expected", "by the law", "Share to be expected by the law."),
            ],
            rows: joint.models.iter().map(of_model).collect(),
        },
    ]
}

pub(super) fn parameters(refit: &Refit) -> Table {
    let [velocity, frequency] = units(refit);
    let mut columns = vec![
        Column::new("parameter", "parameter", Kind::Text, "sigma_1 or sigma_2."),
        Column::new("unit", "unit", Kind::Text, "Its unit."),
        number("estimate", "estimate", "Least-squares estimate."),
        number("se", "SE", "Its standard error."),
    ];
    for (name, title, what) in [
        ("wald_95", "t", "its 95 % interval by Student's t"),
        (
            "profile_95",
            "profile",
            "its 95 % interval by the profile of the sum of squares; empty where open",
        ),
        ("bootstrap_95", "bootstrap", "its 95 % bootstrap interval"),
    ] {
        columns.push(number(&format!("{name}_low"), title, &format!("Lower bound of {what}.")));
        columns.push(number(&format!("{name}_high"), "to", &format!("Upper bound of {what}.")));
    }
    columns.push(number(
        "published",
        "published",
        "What Zhang et al. (2014) print, v in px/shutter, ρ in 1/px.",
    ));
    columns.push(number(
        "difference",
        "difference",
        "estimate − published; empty where the units differ.",
    ));
    let row = |i: usize| {
        let parameter = refit.fit.as_ref().ok().map(|fit| [&fit.sigma_1, &fit.sigma_2][i]);
        let both = |bounds: Option<[f64; 2]>| {
            bounds.map_or([Cell::Missing, Cell::Missing], |b| b.map(Cell::from))
        };
        let profile = parameter.and_then(|parameter| parameter.profile_95);
        let bootstrap = refit.bootstrap.as_ref().ok().map(|bootstrap| bootstrap[i].interval_95);
        let less = [&refit.sigma_1_less_published, &refit.sigma_2_less_published][i];
        let unit = [format!("1/({frequency} · {velocity})"), format!("1/({frequency})")];
        let mut row: Vec<Cell> = vec![["sigma_1", "sigma_2"][i].into(), unit[i].as_str().into()];
        row.push(parameter.map(|parameter| parameter.estimate).into());
        row.push(parameter.and_then(|parameter| parameter.se).into());
        row.extend(both(parameter.and_then(|parameter| parameter.wald_95)));
        row.extend(profile.unwrap_or_default().map(Cell::from));
        row.extend(both(bootstrap));
        row.push([PUBLISHED.sigma_1.value, PUBLISHED.sigma_2.value][i].into());
        row.push(less.as_ref().ok().copied().into());
        row
    };
    Table {
        name: "reciprocal-fit".into(),
        caption: format!(
            "The law ρ = 1/(σ₁v + σ₂), v in {velocity}, ρ in {frequency}, beside the published one."
        ),
        columns,
        rows: vec![row(0), row(1)],
    }
}

pub(super) fn residuals(refit: &Refit, fit: &ReciprocalFit) -> Table {
    let [velocity, frequency] = units(refit);
    let columns = vec![
        Column::new(
            "model",
            "model",
            Kind::Text,
            "Name of the model; empty if the points name none.",
        ),
        Column::new("speed", "speed", Kind::Number(2), &format!("Speed v in {velocity}.")),
        number("frequency", "ρ", &format!("Spatial frequency in {frequency}.")),
        number("fitted", "fitted", "Spatial frequency by the law."),
        number("residual", "residual", "frequency − fitted."),
    ];
    let rows = fit.points.iter().map(|fitted| {
        let model = fitted.point.model.as_deref().map_or(Cell::Missing, Cell::from);
        let numbers = [fitted.point.speed, fitted.point.frequency, fitted.fitted, fitted.residual];
        std::iter::once(model).chain(numbers.map(Cell::from)).collect()
    });
    Table {
        name: "reciprocal-residuals".into(),
        caption: "The points and what the law leaves of them.".into(),
        columns,
        rows: rows.collect(),
    }
}

pub(super) fn models(found: &OverModels) -> Table {
    let columns = vec![
        Column::new("model", "model", Kind::Text, "Name of the model."),
        number("sigma_1", "σ₁", "σ₁ by its own points."),
        number("sigma_2", "σ₂", "σ₂ by its own points."),
        number(
            "sigma_1_shrunk",
            "σ₁, shrunk",
            "σ₁ drawn towards the mean by how little its points tell.",
        ),
        number(
            "sigma_2_shrunk",
            "σ₂, shrunk",
            "σ₂ drawn towards the mean by how little its points tell.",
        ),
    ];
    let rows = found.models.iter().map(|law| {
        let numbers = [law.own, law.shrunk].concat();
        std::iter::once(law.model.as_str().into())
            .chain(numbers.into_iter().map(Cell::from))
            .collect()
    });
    Table {
        name: "reciprocal-models".into(),
        caption: "The law of each model.".into(),
        columns,
        rows: rows.collect(),
    }
}

pub(super) fn figure(refit: &Refit, fit: &ReciprocalFit) -> Figure {
    let [velocity, frequency] = units(refit);
    let speeds = || fit.points.iter().map(|fitted| fitted.point.speed);
    let [slowest, fastest] = [speeds().fold(f64::INFINITY, f64::min), speeds().fold(0.0, f64::max)];
    let at: Vec<f64> =
        (0..=80).map(|k| slowest + (fastest - slowest) * f64::from(k) / 80.0).collect();
    let line = |of: &dyn Fn(f64) -> f64| at.iter().map(|v| [*v, of(*v)]).collect::<Vec<_>>();
    let mut series = vec![Series {
        name: "through points".into(),
        style: Style::Line,
        points: line(&|v| fit.predict(v).frequency),
        intervals: at.iter().filter_map(|v| fit.predict(*v).interval_95).collect(),
    }];
    if let Ok(joint) = &refit.joint {
        let [one, two] = joint.sigma.map(|sigma| sigma.estimate);
        series.push(Series {
            name: "from all answers".into(),
            style: Style::Line,
            points: line(&|v| 1.0 / (one * v + two)),
            intervals: vec![],
        });
    }
    let alike = refit.sigma_1_less_published.is_ok();
    if alike {
        series.push(Series {
            name: "published".into(),
            style: Style::Dashed,
            points: line(&|v| PUBLISHED.frequency_limit(v)),
            intervals: vec![],
        });
    }
    let points: Vec<[f64; 2]> =
        fit.points.iter().map(|fitted| [fitted.point.speed, fitted.point.frequency]).collect();
    let most = points.iter().map(|point| point[1]).fold(0.0, f64::max);
    series.push(Series { name: "points".into(), style: Style::Points, points, intervals: vec![] });
    let published = match alike {
        true => "the published law is dashed",
        false => "the published law is in other units and not drawn",
    };
    let from_all_answers = refit.joint.as_ref().map_or("", |_| ", that from all answers");
    Figure {
        name: "reciprocal-fit".into(),
        caption: format!(
            "The highest spatial frequency to keep by speed: points, the law through them with its 95 \
             % band (t){from_all_answers}; {published}."
        ),
        svg: Plot {
            label: "Spatial frequency to keep by speed".into(),
            x: Axis::of(&format!("speed v ({velocity})"), [slowest, fastest]),
            y: Axis::of(&format!("spatial frequency ρ ({frequency})"), [0.0, most]),
            series,
            rules: vec![],
        }
        .svg(),
    }
}
