//! Scaling in tables: scale values, their differences, and how well they describe the choices.

use super::differences::Difference;
use super::fit::Estimate;
use super::study::{Fitted, Scaling};
use crate::report::section::{Cell, Column, Kind, Table};

/// `scale`, `scale-differences` and `scale-fit`.
pub(super) fn tables(scaling: &Scaling) -> Vec<Table> {
    vec![values(scaling), differences(scaling), fits(scaling)]
}

fn number(name: &str, title: &str, description: &str) -> Column {
    Column::new(name, title, Kind::Number(3), description)
}

fn interval(name: &str, title: &str, description: &str) -> [Column; 2] {
    [
        number(&format!("{name}_low"), title, &format!("Lower bound of {description}.")),
        number(&format!("{name}_high"), "to", &format!("Upper bound of {description}.")),
    ]
}

fn cells(interval: Option<[f64; 2]>) -> [Cell; 2] {
    match interval {
        Some(bounds) => bounds.map(Cell::from),
        None => [Cell::Missing, Cell::Missing],
    }
}

fn estimate(estimate: Estimate) -> [Cell; 2] {
    [estimate.value.into(), estimate.se.into()]
}

fn values(scaling: &Scaling) -> Table {
    let reference = &scaling.items[0];
    let mut columns = vec![
        Column::new("item", "item", Kind::Text, "Id of the item."),
        Column::new(
            "estimation",
            "estimation",
            Kind::Text,
            "Maximum likelihood, or bias-reduced (Firth 1993) where it has no finite values.",
        ),
        number("worth", "worth", "Bradley–Terry worth π; all worths sum to 1."),
    ];
    let units = [
        ("logit", "logit", "Bradley–Terry value ln π in logits"),
        (
            "jod",
            "JOD",
            "Thurstone Case V value in just-objectionable differences, of which one is a preference of 75 %",
        ),
    ];
    for (name, title, what) in units {
        columns.push(number(name, title, &format!("{what}, mean of all items 0.")));
        columns.push(number(&format!("{name}_se"), "SE", "Its standard error."));
        let mut of = |kind: &str, title: &str, what: &str| {
            columns.extend(interval(&format!("{name}_{kind}_95"), title, what));
        };
        of("wald", "Wald", "its 95 % interval by the standard error");
        of("profile", "profile", "its 95 % interval by the profile likelihood");
        of("bootstrap", "bootstrap", "its 95 % interval by resampling observers");
    }
    for (unit, what) in [("logit", "Bradley–Terry"), ("probit", "Thurstone Case V")] {
        let name = format!("{unit}_from_reference");
        let description = format!("{what} value in {unit}s less that of {reference}.");
        columns.push(number(&name, &format!("{unit} from {reference}"), &description));
        columns.push(number(&format!("{name}_se"), "SE", "Its standard error."));
    }
    let [bradley_terry, thurstone] = scaling.both();
    let worths = bradley_terry.scale.worths();
    let row = |i: usize| {
        let mut row: Vec<Cell> = vec![
            scaling.items[i].as_str().into(),
            bradley_terry.scale.estimation.name().into(),
            worths[i].into(),
        ];
        let jod = thurstone.scale.model.just_objectionable_difference();
        for (fitted, unit) in [(bradley_terry, 1.0), (thurstone, jod)] {
            let centred = fitted.scale.centred(i);
            row.extend(estimate(centred.in_units_of(unit)));
            for bounds in [Some(centred.wald_95()), fitted.profile_95(i), fitted.bootstrap_95(i)] {
                row.extend(cells(bounds.map(|bounds| bounds.map(|bound| bound / unit))));
            }
        }
        for fitted in scaling.both() {
            row.extend(estimate(fitted.scale.difference(i, 0)));
        }
        row
    };
    Table {
        name: "scale".into(),
        caption: "Scale values of the items, best first, with standard errors and 95 % intervals."
            .into(),
        columns,
        rows: bradley_terry.scale.best_first().into_iter().map(row).collect(),
    }
}

fn differences(scaling: &Scaling) -> Table {
    let [bradley_terry, thurstone] = scaling.both();
    let mut columns = vec![
        Column::new(
            "item",
            "item",
            Kind::Text,
            "Id of the item with the higher Bradley–Terry value.",
        ),
        Column::new("over", "over", Kind::Text, "Id of the other."),
        number("logit", "logit", "Difference of their Bradley–Terry values in logits."),
        number("logit_se", "SE", "Its standard error."),
    ];
    columns.extend(interval("wald_95", "Wald", "its 95 % interval by the standard error"));
    columns.extend(interval(
        "bootstrap_95",
        "bootstrap",
        "its 95 % interval by resampling observers",
    ));
    columns.push(number("z", "z", "The difference over its standard error."));
    columns.push(Column::new(
        "p",
        "p",
        Kind::P,
        "Wald's test, two-sided, approximate, no correction.",
    ));
    let tests = bradley_terry.differences.len();
    let holm = format!("That p with Holm's correction for {tests} tests.");
    columns.push(Column::new("p_holm", "p (Holm)", Kind::P, &holm));
    columns.push(number(
        "jod",
        "JOD",
        "Difference of their Thurstone Case V values in just-objectionable differences.",
    ));
    columns.push(number("jod_se", "SE", "Its standard error."));
    let jod = thurstone.scale.model.just_objectionable_difference();
    let row = |difference: &Difference| {
        let [i, j] = difference.places;
        let drawn = bradley_terry.bootstrap.as_ref().ok();
        let mut row: Vec<Cell> =
            vec![difference.item.as_str().into(), difference.over.as_str().into()];
        row.extend(estimate(difference.estimate));
        row.extend(cells(Some(difference.estimate.wald_95())));
        row.extend(cells(drawn.map(|drawn| drawn.interval_95(|values| values[i] - values[j]))));
        row.extend([difference.z.into(), difference.p.into(), difference.p_holm.into()]);
        row.extend(estimate(thurstone.scale.difference(i, j).in_units_of(jod)));
        row
    };
    Table {
        name: "scale-differences".into(),
        caption: "Differences between the scale values of all pairs of items.".into(),
        columns,
        rows: bradley_terry.differences.iter().map(row).collect(),
    }
}

fn fits(scaling: &Scaling) -> Table {
    let integer =
        |name: &str, title: &str, what: &str| Column::new(name, title, Kind::Integer, what);
    let p = |name: &str, title: &str, what: &str| Column::new(name, title, Kind::P, what);
    let columns = vec![
        Column::new("model", "model", Kind::Text, "How choices follow from scale values."),
        Column::new("estimation", "estimation", Kind::Text, "How the values were estimated."),
        number("log_likelihood", "ln L", "Logarithm of the binomial likelihood of the counts."),
        number("deviance", "deviance", "Deviance from the observed shares of wins."),
        integer("df", "df", "Degrees of freedom of deviance and Pearson's χ²."),
        p("p_deviance", "p", "Upper tail of χ² at the deviance, approximate, no correction."),
        number("pearson", "Pearson χ²", "Pearson's χ²."),
        p("p_pearson", "p", "Upper tail of χ² at Pearson's χ², approximate, no correction."),
        p(
            "p_simulated",
            "p (simulated)",
            "Share of studies simulated from the scale that fit no better, by the deviance of bias-reduced values.",
        ),
        number("smallest_expected", "smallest", "The smallest count that the scale expects."),
        integer(
            "small_expected",
            "below 5",
            "How many of the counts that the scale expects are below 5.",
        ),
        number("null_deviance", "null deviance", "Deviance of equal scale values."),
        integer("null_df", "df", "Degrees of freedom of null deviance − deviance."),
        p(
            "p_equal",
            "p",
            "Upper tail of χ² at null deviance − deviance, approximate, no correction.",
        ),
    ];
    let row = |fitted: &&Fitted| {
        let fit = &fitted.goodness_of_fit;
        vec![
            fitted.scale.model.name().into(),
            fitted.scale.estimation.name().into(),
            fit.log_likelihood.into(),
            fit.deviance.into(),
            fit.df.into(),
            fit.p.into(),
            fit.pearson.into(),
            fit.p_pearson.into(),
            fitted.simulated_fit.as_ref().ok().map(|fit| fit.p).into(),
            fit.smallest_expected.into(),
            fit.small_expected.into(),
            fit.equal_worth.null_deviance.into(),
            fit.equal_worth.df.into(),
            fit.equal_worth.p.into(),
        ]
    };
    Table {
        name: "scale-fit".into(),
        caption: "How well the scales describe the choices, and tests that all items are alike."
            .into(),
        columns,
        rows: scaling.both().iter().map(row).collect(),
    }
}
