//! What one part of an analysis has to say: sentences, tables and figures, written once and shown in
//! the terminal, on the page and in files.

use crate::PValue;
use crate::maths::proportion::Proportion;

/// One part of an analysis, for people.
#[derive(Clone, Debug, Default)]
pub struct Section {
    /// Heading.
    pub heading: String,
    /// Results in words, in the field's reporting style. Beside every p stand n, tail, correction and
    /// whether it is exact; what cannot be computed stands here with its reason.
    pub sentences: Vec<String>,
    /// Tables, each also a CSV with its schema.
    pub tables: Vec<Table>,
    /// Figures, each also an SVG and a PNG.
    pub figures: Vec<Figure>,
    /// How it was computed, with the sources cited as "Author (year)".
    pub method: Vec<String>,
    /// The sources in full, as in a list of references.
    pub references: Vec<&'static str>,
}

/// A table of results.
#[derive(Clone, Debug)]
pub struct Table {
    /// Name of its file without the ending: lower-case letters, digits and hyphens.
    pub name: String,
    /// What it shows, with units, levels of confidence and what the tests test.
    pub caption: String,
    /// Its columns.
    pub columns: Vec<Column>,
    /// Its rows, each with one cell per column.
    pub rows: Vec<Vec<Cell>>,
}

/// A column of a table.
#[derive(Clone, Debug)]
pub struct Column {
    /// Name in the CSV.
    pub name: String,
    /// Heading on the page.
    pub title: String,
    /// What its values mean, with unit and source: the description in the schema.
    pub description: String,
    /// What its values are.
    pub kind: Kind,
}

/// What the values of a column are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Words.
    Text,
    /// Whole numbers.
    Integer,
    /// Numbers, shown to people with so many decimals; files have all digits.
    Number(usize),
    /// p-values.
    P,
    /// Yes or no.
    Flag,
}

/// A value in a table.
#[derive(Clone, Debug, PartialEq)]
pub enum Cell {
    /// Words.
    Text(String),
    /// A whole number.
    Integer(i64),
    /// A finite number.
    Number(f64),
    /// A p-value.
    P(PValue),
    /// Yes or no.
    Flag(bool),
    /// Not known; the sentences of the section say why.
    Missing,
}

/// A figure.
#[derive(Clone, Debug)]
pub struct Figure {
    /// Name of its files without the ending: lower-case letters, digits and hyphens.
    pub name: String,
    /// What it shows.
    pub caption: String,
    /// The drawing: an `svg` element with its size in CSS pixels.
    pub svg: String,
}

impl Column {
    /// A column called `name` in files and `title` on the page.
    pub fn new(name: &str, title: &str, kind: Kind, description: &str) -> Self {
        Self { name: name.into(), title: title.into(), description: description.into(), kind }
    }
}

impl From<f64> for Cell {
    /// A number; what is not finite is missing.
    fn from(value: f64) -> Self {
        if value.is_finite() { Self::Number(value) } else { Self::Missing }
    }
}

impl From<u64> for Cell {
    fn from(value: u64) -> Self {
        i64::try_from(value).map_or(Self::Missing, Self::Integer)
    }
}

impl From<usize> for Cell {
    fn from(value: usize) -> Self {
        (value as u64).into()
    }
}

impl From<&str> for Cell {
    fn from(value: &str) -> Self {
        Self::Text(value.into())
    }
}

impl From<String> for Cell {
    fn from(value: String) -> Self {
        Self::Text(value)
    }
}

impl From<bool> for Cell {
    fn from(value: bool) -> Self {
        Self::Flag(value)
    }
}

impl From<PValue> for Cell {
    fn from(value: PValue) -> Self {
        Self::P(value)
    }
}

impl<T: Into<Self>> From<Option<T>> for Cell {
    fn from(value: Option<T>) -> Self {
        value.map_or(Self::Missing, Into::into)
    }
}

/// The work that rates simplified models, as in a list of references.
pub(crate) const ZHANG: &str = "Zhang, M., Wang, W., Sun, H. and Han, H. (2014). Perception-based model \
     simplification for motion blur rendering. Graphical Models 76.";

/// The columns that [`share_cells`] fills.
pub(crate) fn share_columns() -> Vec<Column> {
    let share = |name: &str, title: &str, kind: Kind, description: &str| {
        Column::new(name, title, kind, description)
    };
    vec![
        share("chosen", "chosen", Kind::Integer, "How often it was chosen."),
        share("trials", "of", Kind::Integer, "Number of trials."),
        share("percent", "%", Kind::Number(1), "The share in percent."),
        share("wilson_95_low", "Wilson", Kind::Number(3), "Lower bound of Wilson's 95 % interval."),
        share("wilson_95_high", "to", Kind::Number(3), "Upper bound of Wilson's 95 % interval."),
        share(
            "clopper_pearson_95_low",
            "Clopper–Pearson",
            Kind::Number(3),
            "Lower bound of Clopper and Pearson's exact 95 % interval.",
        ),
        share(
            "clopper_pearson_95_high",
            "to",
            Kind::Number(3),
            "Upper bound of Clopper and Pearson's exact 95 % interval.",
        ),
        share("chi2", "χ²", Kind::Number(2), "χ² against ½, without correction."),
        share("df", "df", Kind::Integer, "Degrees of freedom of χ²."),
        share("p_chi2", "p (χ²)", Kind::P, "Upper tail of χ², approximate."),
        share("p_binomial", "p (exact)", Kind::P, "Exact binomial test against ½, two-sided."),
    ]
}

/// A share of answers as cells.
pub(crate) fn share_cells(share: &Proportion) -> Vec<Cell> {
    vec![
        share.chosen.into(),
        share.trials.into(),
        share.percent.into(),
        share.wilson_95[0].into(),
        share.wilson_95[1].into(),
        share.clopper_pearson_95[0].into(),
        share.clopper_pearson_95[1].into(),
        share.chi2.into(),
        share.df.into(),
        share.p_chi2.into(),
        share.p_binomial.into(),
    ]
}
