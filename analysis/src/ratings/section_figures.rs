//! Ratings as figures.

use super::analysis::RatingAnalysis;
use super::level_of_detail::CoarsestLevel;
use super::rating::{Rating, THRESHOLD};
use crate::report::labels::significant;
use crate::report::plot::{Axis, Dot, Plot, Series, Style, dots};
use crate::report::section::Figure;

/// The most figures of single models.
const MOST_FIGURES: usize = 12;

pub(super) fn figures(analysis: &RatingAnalysis) -> Vec<Figure> {
    let mut figures = Vec::new();
    if analysis.histogram.bins.len() > 1 {
        let rows: Vec<Dot> = analysis
            .histogram
            .bins
            .iter()
            .map(|bin| Dot {
                label: format!("r = {}", bin.r),
                value: bin.share,
                interval: bin.share_95,
            })
            .collect();
        let axis = Axis::of("share of images with a rating of 0.8 or more", [0.0, 1.0]);
        figures.push(Figure {
            name: "r-histogram".into(),
            caption: "Share of images that reach a rating of 0.8, by the exponent r of the \
                      weight, with 95 % bootstrap intervals."
                .into(),
            svg: dots("Images that look like the original, by r", &axis, &rows, &[]),
        });
    }
    let of_models: Vec<&[Rating]> = analysis
        .ratings
        .chunk_by(|a, b| (&a.image.model, a.image.r) == (&b.image.model, b.image.r))
        .collect();
    let left = of_models.len().saturating_sub(MOST_FIGURES);
    for (place, ratings) in of_models.into_iter().take(MOST_FIGURES).enumerate() {
        let (model, r) = (&ratings[0].image.model, ratings[0].image.r);
        let coarsest: Vec<&CoarsestLevel> =
            analysis.coarsest.iter().filter(|c| (&c.model, c.r) == (model, r)).collect();
        let others = match left {
            0 => String::new(),
            left => format!(" {left} more pairs of model and r are in the table."),
        };
        figures.push(Figure {
            name: format!("ratings-{}", place + 1),
            caption: format!(
                "Ratings of {model}, simplified with r = {r}, by level of detail and speed in \
                 {}: shares with Wilson's 95 % intervals, and the fitted function where there is \
                 one.{others}",
                analysis.speed_unit.symbol()
            ),
            svg: curves(model, ratings, &coarsest, analysis.speed_unit.symbol()).svg(),
        });
    }
    figures
}

/// Ratings by level of detail, in one colour for each speed.
fn curves(model: &str, ratings: &[Rating], coarsest: &[&CoarsestLevel], unit: &str) -> Plot {
    let levels = || ratings.iter().map(|rating| rating.image.level_of_detail);
    let low = levels().fold(1.0, f64::min) * 0.8;
    let mut series = Vec::new();
    for of_speed in ratings.chunk_by(|a, b| a.image.speed == b.image.speed) {
        let speed = of_speed[0].image.speed;
        let name = format!("{} {unit}", significant(speed));
        let known =
            of_speed.iter().filter_map(|r| Some((r.image.level_of_detail, r.share.as_ref()?)));
        series.push(Series {
            name: name.clone(),
            style: Style::Points,
            points: known.clone().map(|(level, share)| [level, share.rating]).collect(),
            intervals: known.map(|(_, share)| share.wilson_95).collect(),
        });
        let found =
            coarsest.iter().find(|c| c.speed == speed).and_then(|c| c.smoothed.as_ref().ok());
        let line = found.map(|found| {
            let step = libm::log(1.0 / low) / 60.0;
            let point = |k: u32| {
                let x = libm::log(low) + f64::from(k) * step;
                let eta = found.intercept + found.slope * x;
                [libm::exp(x), 1.0 / (1.0 + libm::exp(-eta))]
            };
            (0..=60).map(point).collect()
        });
        let points = line.unwrap_or_default();
        series.push(Series { name, style: Style::Line, points, intervals: vec![] });
    }
    Plot {
        label: format!("Ratings of {model} by level of detail"),
        x: Axis::logarithmic("level of detail (part of the faces)", [low, 1.0]),
        y: Axis::of("rating", [0.0, 1.0]),
        series,
        rules: vec![(THRESHOLD, String::new())],
    }
}
