//! Ratings as tables.

use super::analysis::RatingAnalysis;
use super::level_of_detail::CoarsestLevel;
use super::rating::Rating;
use crate::report::section::{Cell, Column, Kind, Table};

fn column(name: &str, title: &str, kind: Kind, description: &str) -> Column {
    Column::new(name, title, kind, description)
}

/// The columns that say of which image a row is.
fn image_columns(unit: &str) -> Vec<Column> {
    vec![
        column("model", "model", Kind::Text, "Name of the model."),
        column("r", "r", Kind::Number(3), "Exponent of the weight that it was simplified with."),
        column("speed", "speed", Kind::Number(2), &format!("Its speed in {unit}.")),
    ]
}

fn bounds(name: &str, title: &str, decimals: usize, what: &str) -> [Column; 2] {
    [
        column(
            &format!("{name}_low"),
            title,
            Kind::Number(decimals),
            &format!("Lower bound of {what}."),
        ),
        column(
            &format!("{name}_high"),
            "to",
            Kind::Number(decimals),
            &format!("Upper bound of {what}."),
        ),
    ]
}

pub(super) fn ratings(analysis: &RatingAnalysis) -> Table {
    let mut columns = image_columns(analysis.speed_unit.symbol());
    columns.extend([
        column(
            "level_of_detail",
            "level of detail",
            Kind::Number(4),
            "Part of the original's faces.",
        ),
        column(
            "same",
            "same",
            Kind::Integer,
            "u₁: answers that it looks the same as the original.",
        ),
        column("different", "different", Kind::Integer, "u₂: answers that it looks different."),
        column("not_sure", "not sure", Kind::Integer, "Answers that are in no rating."),
        column("rating", "rating", Kind::Number(3), "u₁/(u₁ + u₂); empty if nobody answered."),
    ]);
    columns.extend(bounds("wilson_95", "Wilson", 3, "Wilson's 95 % interval of the rating"));
    columns.extend(bounds(
        "clopper_pearson_95",
        "Clopper–Pearson",
        3,
        "Clopper and Pearson's exact 95 % interval of the rating",
    ));
    let tests = analysis.ratings.iter().filter(|rating| rating.share.is_some()).count();
    columns.extend([
        column("reaches", "≥ 0.8", Kind::Flag, "Whether the rating is 0.8 or more."),
        column(
            "wilson_clears",
            "Wilson > 0.8",
            Kind::Flag,
            "Whether Wilson's interval lies above 0.8.",
        ),
        column(
            "clopper_pearson_clears",
            "exact > 0.8",
            Kind::Flag,
            "Whether Clopper and Pearson's interval lies above 0.8.",
        ),
        column(
            "p_above",
            "p above",
            Kind::P,
            "Exact binomial test against 0.8, upper tail, no correction.",
        ),
        column(
            "p_above_holm",
            "p above (Holm)",
            Kind::P,
            &format!("The same with Holm's correction for {tests} images."),
        ),
        column(
            "p_below",
            "p below",
            Kind::P,
            "Exact binomial test against 0.8, lower tail, no correction.",
        ),
    ]);
    let row = |rating: &Rating| {
        let image = &rating.image;
        let mut row: Vec<Cell> = vec![
            image.model.as_str().into(),
            image.r.into(),
            image.speed.into(),
            image.level_of_detail.into(),
            rating.same.into(),
            rating.different.into(),
            rating.not_sure.into(),
        ];
        let missing = columns.len() - row.len();
        match &rating.share {
            None => row.extend(std::iter::repeat_n(Cell::Missing, missing)),
            Some(share) => {
                let intervals = [share.wilson_95, share.clopper_pearson_95].concat();
                row.push(share.rating.into());
                row.extend(intervals.into_iter().map(Cell::from));
                row.extend(
                    [share.reaches, share.wilson_clears, share.clopper_pearson_clears]
                        .map(Cell::from),
                );
                row.extend([share.p_above, share.p_above_holm, share.p_below].map(Cell::from));
            }
        }
        row
    };
    let rows = analysis.ratings.iter().map(row).collect();
    let caption = "The rating of each image, with intervals and exact tests against 0.8.".into();
    Table { name: "ratings".into(), caption, columns, rows }
}

pub(super) fn histogram(analysis: &RatingAnalysis) -> Table {
    let drawn = match analysis.observers {
        Some(_) => "observers",
        None => "the answers to each image",
    };
    let mut columns = vec![
        column("r", "r", Kind::Number(3), "Exponent of the weight."),
        column("images", "images", Kind::Integer, "Images of this r that have a rating."),
        column("over", "≥ 0.8", Kind::Integer, "Those with a rating of 0.8 or more."),
        column("share", "share", Kind::Number(3), "over/images."),
    ];
    let what = format!("the 95 % bootstrap interval of the share, {drawn} resampled");
    columns.extend(bounds("share_95", "bootstrap", 3, &what));
    columns.push(column(
        "won",
        "ahead",
        Kind::Number(3),
        "Part of the resamples in which this share is the largest.",
    ));
    let rows = analysis.histogram.bins.iter().map(|bin| {
        let [low, high] =
            bin.share_95.map_or([Cell::Missing, Cell::Missing], |b| b.map(Cell::from));
        vec![
            bin.r.into(),
            bin.images.into(),
            bin.over.into(),
            bin.share.into(),
            low,
            high,
            bin.won.into(),
        ]
    });
    Table {
        name: "r-histogram".into(),
        caption: "Images that reach a rating of 0.8, by the exponent r of the weight.".into(),
        columns,
        rows: rows.collect(),
    }
}

pub(super) fn levels(analysis: &RatingAnalysis) -> Table {
    let mut columns = image_columns(analysis.speed_unit.symbol());
    let level = "Coarsest level of detail, a part of the original's faces,";
    columns.extend([
        column("levels", "levels", Kind::Integer, "Levels of detail that have a rating."),
        column(
            "point",
            "by rule",
            Kind::Number(4),
            &format!("{level} by the rule of Zhang et al. (2014)."),
        ),
        column("point_reason", "why not", Kind::Text, "Why the rule gives none."),
        column(
            "finer_below",
            "finer, below",
            Kind::Integer,
            "Finer levels whose rating is below 0.8 all the same.",
        ),
        column(
            "smoothed",
            "by function",
            Kind::Number(4),
            &format!("{level} at which the fitted function is 0.8."),
        ),
        column("smoothed_se", "SE", Kind::Number(4), "Its standard error, by the delta method."),
    ]);
    columns.extend(bounds(
        "smoothed_95",
        "profile",
        4,
        "its 95 % profile-likelihood interval; empty where open",
    ));
    columns.extend([
        column("deviance", "deviance", Kind::Number(2), "Deviance of the function."),
        column("df", "df", Kind::Integer, "Its degrees of freedom."),
        column("smoothed_reason", "why not", Kind::Text, "Why the function gives none."),
    ]);
    let reason = |of: Option<&String>| of.map_or(Cell::Missing, |reason| reason.as_str().into());
    let row = |coarsest: &CoarsestLevel| {
        let mut row: Vec<Cell> = vec![
            coarsest.model.as_str().into(),
            coarsest.r.into(),
            coarsest.speed.into(),
            coarsest.levels.len().into(),
            coarsest.point.clone().ok().into(),
            reason(coarsest.point.as_ref().err()),
            coarsest.finer_below.len().into(),
        ];
        match &coarsest.smoothed {
            Ok(found) => {
                let [low, high] = found.interval_95.map(Cell::from);
                let numbers = [found.level.into(), found.se.into(), low, high];
                row.extend(numbers);
                row.extend([found.deviance.into(), found.df.into(), Cell::Missing]);
            }
            Err(reason) => {
                row.extend(std::iter::repeat_n(Cell::Missing, 6));
                row.push(reason.as_str().into());
            }
        }
        row
    };
    Table {
        name: "level-of-detail".into(),
        caption: "The coarsest level of detail that looks like the original.".into(),
        columns,
        rows: analysis.coarsest.iter().map(row).collect(),
    }
}
