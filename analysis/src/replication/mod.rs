//! The published experiments: what was printed about them, and what their votes give.
//!
//! [`replicate`] goes through the chapters of a published experiment in the order of its text. Every
//! printed number and every conclusion that a number could bear is one [`Line`], with its section, what
//! was printed, what follows from the printed votes and counts by the code of this crate, and whether the
//! two agree.

mod factors;
mod implied;
mod navarro_mono;
mod navarro_stereo;
pub mod published;
mod section;
mod shares;
mod table;

use crate::error::InputError;
use crate::maths::p_value::PValue;
use crate::outcome::{Outcome, entry};
use serde::ser::SerializeMap;
use serde::{Serialize, Serializer};
use std::fmt;

pub use section::{section, text};

/// The experiments that [`replicate`] knows.
pub const NAMES: [&str; 2] = ["navarro-mono", "navarro-stereo"];

/// A published experiment, line by line.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Replication {
    /// Its name, one of [`NAMES`].
    pub name: &'static str,
    /// What it was about.
    pub title: &'static str,
    /// Where it was published.
    pub citation: &'static str,
    /// How many lines have which verdict.
    pub counts: Counts,
    /// The lines, in the order of the text.
    pub lines: Vec<Line>,
}

/// How many lines of a replication have which verdict.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Counts {
    /// Print and votes agree.
    pub agrees: usize,
    /// They do not.
    pub conflict: usize,
    /// It does not follow from what was printed.
    pub unknown: usize,
    /// It was not printed.
    pub not_printed: usize,
}

/// One printed number or conclusion, or one that could have been printed.
#[derive(Clone, Debug, PartialEq)]
pub struct Line {
    /// Section of the publication.
    pub section: &'static str,
    /// What it is.
    pub what: String,
    /// As it was printed; none if it was not.
    pub published: Option<Value>,
    /// What the printed votes and counts give, or why they give nothing.
    pub ours: Outcome<Value>,
    /// Whether the two agree.
    pub verdict: Verdict,
    /// What a reader should know.
    pub note: Option<String>,
}

/// Whether print and votes agree.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    /// They agree, to the last printed digit.
    Agrees,
    /// They do not.
    Conflict,
    /// It does not follow from what was printed.
    Unknown,
    /// It was not printed, but follows.
    NotPrinted,
}

/// A result: in JSON a number, a list, or words.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Value {
    /// A whole number.
    Count(u64),
    /// A number, shown with so many decimals.
    #[serde(serialize_with = "plain_number")]
    Number(f64, usize),
    /// A p-value.
    P(PValue),
    /// Groups of stimuli, best first.
    Groups(Vec<Vec<String>>),
    /// Words.
    Words(String),
}

/// Replicates the published experiment `name`.
///
/// # Errors
/// There is no such experiment.
pub fn replicate(name: &str) -> Result<Replication, InputError> {
    let (name, title, lines) = match name {
        "navarro-mono" => {
            (NAMES[0], "Motion blur perception, monoscopic (chapter 5)", navarro_mono::lines()?)
        }
        "navarro-stereo" => {
            (NAMES[1], "Motion blur perception, stereoscopic (chapter 6)", navarro_stereo::lines()?)
        }
        _ => {
            let allowed = format!("{} are known", NAMES.join(" and "));
            return Err(InputError::value("replicate", "NAME", name, allowed));
        }
    };
    let counts = lines.iter().fold(Counts::default(), |mut counts, line: &Line| {
        *match line.verdict {
            Verdict::Agrees => &mut counts.agrees,
            Verdict::Conflict => &mut counts.conflict,
            Verdict::Unknown => &mut counts.unknown,
            Verdict::NotPrinted => &mut counts.not_printed,
        } += 1;
        counts
    });
    Ok(Replication { name, title, citation: "Navarro, PhD thesis, 2012", counts, lines })
}

impl Line {
    /// A printed number that our code computes; it agrees if it rounds to what was printed.
    fn number(section: &'static str, what: &str, printed: f64, decimals: usize, ours: f64) -> Self {
        let agrees = implied::rounds_to(ours, printed, decimals);
        let ours = Value::Number(ours, decimals.clamp(4, 6));
        Self::compared(section, what, Value::Number(printed, decimals), ours, agrees)
    }

    /// A printed whole number that our code computes.
    fn count(section: &'static str, what: &str, printed: u64, ours: u64) -> Self {
        Self::compared(section, what, Value::Count(printed), Value::Count(ours), printed == ours)
    }

    /// A printed statement and what speaks for or against it.
    fn compared(
        section: &'static str,
        what: &str,
        printed: impl Into<Value>,
        ours: impl Into<Value>,
        agrees: bool,
    ) -> Self {
        let verdict = if agrees { Verdict::Agrees } else { Verdict::Conflict };
        let (published, ours) = (Some(printed.into()), Ok(ours.into()));
        Self { section, what: what.into(), published, ours, verdict, note: None }
    }

    /// What was not printed, but follows.
    fn ours(section: &'static str, what: &str, ours: impl Into<Value>) -> Self {
        let (published, ours, verdict) = (None, Ok(ours.into()), Verdict::NotPrinted);
        Self { section, what: what.into(), published, ours, verdict, note: None }
    }

    /// What was printed, or not, and does not follow, for a reason.
    fn unknown(
        section: &'static str,
        what: &str,
        printed: Option<Value>,
        reason: impl Into<String>,
    ) -> Self {
        let (ours, verdict) = (Err(reason.into()), Verdict::Unknown);
        Self { section, what: what.into(), published: printed, ours, verdict, note: None }
    }

    fn noting(self, note: impl Into<String>) -> Self {
        Self { note: Some(note.into()), ..self }
    }
}

impl Serialize for Line {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(None)?;
        map.serialize_entry("section", self.section)?;
        map.serialize_entry("what", &self.what)?;
        let published = self.published.as_ref().ok_or_else(|| "not printed".to_string());
        entry(&mut map, "published", &published)?;
        entry(&mut map, "ours", &self.ours)?;
        map.serialize_entry("verdict", &self.verdict)?;
        if let Some(note) = &self.note {
            map.serialize_entry("note", note)?;
        }
        map.end()
    }
}

impl From<&str> for Value {
    fn from(words: &str) -> Self {
        Self::Words(words.into())
    }
}

impl From<String> for Value {
    fn from(words: String) -> Self {
        Self::Words(words)
    }
}

impl From<u64> for Value {
    fn from(count: u64) -> Self {
        Self::Count(count)
    }
}

impl From<PValue> for Value {
    fn from(p: PValue) -> Self {
        Self::P(p)
    }
}

impl fmt::Display for Value {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Count(count) => write!(f, "{count}"),
            Self::Number(number, decimals) => write!(f, "{number:.decimals$}"),
            Self::P(p) => f.write_str(&p.equation()),
            Self::Groups(groups) => {
                let groups: Vec<String> =
                    groups.iter().map(|group| format!("{{{}}}", group.join(" "))).collect();
                f.write_str(&groups.join(" "))
            }
            Self::Words(words) => f.write_str(words),
        }
    }
}

fn plain_number<S: Serializer>(number: &f64, _: &usize, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_f64(*number)
}
