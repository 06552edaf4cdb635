//! Which cells of a grid are meant, as words say it.

use super::Grid;
use super::axes::{AXES, Cell, Levels};
use crate::simplification::Simplification;
use crate::stimulus::Stimulus;
use indexmap::IndexSet;
use shutterlab_data_schema::definition::{DefinitionError, nearest};

/// Which cells of a grid are meant: any of its alternatives; each alternative lists, per axis, the
/// levels it takes (an axis it does not name is free).
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Selection {
    alternatives: Vec<[Vec<String>; AXES.len()]>,
}

impl Selection {
    /// Parses selections like `material=checker,speed=S2,shutter=T4,shutter=T5`: different axes
    /// must all agree, levels of one axis are alternatives. Several texts are alternatives; none
    /// takes every cell. A level is given by its name or by what it stands for.
    ///
    /// # Errors
    /// An axis or level that `grid` does not have; the nearest known one is named.
    pub fn parse<S: AsRef<str>>(texts: &[S], grid: &Grid) -> Result<Self, DefinitionError> {
        Self::parse_among(texts, "render", &grid.axes.levels())
    }

    /// As [`Selection::parse`], among the levels that `stimuli` have. A material is given by the name of
    /// its level alone: what its grid calls it they do not know.
    ///
    /// # Errors
    /// An axis or level that none of them has; the nearest known one is named.
    pub fn parse_for_screen<S: AsRef<str>>(
        texts: &[S],
        stimuli: &[&Stimulus],
    ) -> Result<Self, DefinitionError> {
        Self::parse_among(texts, "screen", &levels_of(stimuli))
    }

    /// `verb` is what an error calls the place.
    fn parse_among<S: AsRef<str>>(
        texts: &[S],
        verb: &str,
        levels: &Levels<'_>,
    ) -> Result<Self, DefinitionError> {
        let mut alternatives = Vec::new();
        for text in texts {
            let mut axes: [Vec<String>; AXES.len()] = Default::default();
            for part in text.as_ref().split(',') {
                let refuse = |value: &str, allowed: String| {
                    DefinitionError::value(verb, "--select", value, allowed)
                };
                let Some((axis, level)) = part.split_once('=') else {
                    return Err(refuse(part, "AXIS=LEVEL is needed".into()));
                };
                let (axis, level) = (axis.trim(), level.trim());
                let known =
                    || levels.iter().enumerate().filter(|(_, (_, levels))| !levels.is_empty());
                let Some((index, (_, levels))) = known().find(|(_, (known, _))| *known == axis)
                else {
                    let names: Vec<&str> = known().map(|(_, (name, _))| *name).collect();
                    return Err(refuse(axis, unknown("axes", axis, &names)));
                };
                let Some((name, _)) =
                    levels.iter().find(|(name, value)| *name == level || value == level)
                else {
                    let names: Vec<&str> = levels.iter().map(|(name, _)| *name).collect();
                    return Err(refuse(part, unknown(&format!("levels of {axis}"), level, &names)));
                };
                axes[index].push(name.to_string());
            }
            alternatives.push(axes);
        }
        Ok(Self { alternatives })
    }

    /// Whether `stimulus` is of a cell that is meant.
    pub fn takes_stimulus(&self, stimulus: &Stimulus) -> bool {
        self.takes(AXES.map(|axis| level_of(stimulus, axis)))
    }

    pub(super) fn takes(&self, cell: Cell<'_>) -> bool {
        // The original of a model has no r: it is that of all.
        let is_taken = |((axis, levels), name): ((&str, &Vec<String>), &str)| {
            levels.is_empty()
                || levels.iter().any(|level| level == name)
                || (axis == "r" && name.is_empty())
        };
        let takes = |axes: &[_; AXES.len()]| AXES.into_iter().zip(axes).zip(cell).all(is_taken);
        self.alternatives.is_empty() || self.alternatives.iter().any(takes)
    }
}

fn level_of<'a>(stimulus: &'a Stimulus, axis: &str) -> &'a str {
    stimulus.levels.get(axis).map_or("", String::as_str)
}

/// The levels that `stimuli` have, in the order in which they come.
fn levels_of<'a>(stimuli: &[&'a Stimulus]) -> Levels<'a> {
    AXES.map(|axis| {
        let level = |stimulus: &&'a Stimulus| {
            let name = level_of(stimulus, axis);
            let value = match axis {
                "speed" => stimulus.speed_deg_per_s.to_string(),
                "shutter" => stimulus.shutter_open_fraction.to_string(),
                "samples" => stimulus.samples.to_string(),
                "method" => stimulus.method.to_string(),
                "r" => of_simplification(stimulus, |how| how.r),
                "level_of_detail" if stimulus.simplification.is_none() => "1".into(),
                "level_of_detail" => of_simplification(stimulus, |how| how.level_of_detail),
                _ => name.to_string(),
            };
            (name, value)
        };
        let levels: IndexSet<_> =
            stimuli.iter().map(level).filter(|(name, _)| !name.is_empty()).collect();
        (axis, levels.into_iter().collect())
    })
}

/// What `of` tells of how the model of `stimulus` is simplified; nothing of an original.
fn of_simplification(stimulus: &Stimulus, of: impl Fn(&Simplification) -> f64) -> String {
    stimulus.simplification.as_ref().map_or(String::new(), |how| of(how).to_string())
}

fn unknown(what: &str, name: &str, known: &[&str]) -> String {
    let hint = nearest(name, known.iter().copied())
        .map_or(String::new(), |near| format!("; did you mean {near}?"));
    format!("the {what} are {}{hint}", known.join(", "))
}
