//! The points that the law of the level of detail is fitted to: the spatial frequency of the coarsest
//! level that will do, by speed.
//!
//! A level of detail is a share of faces and no frequency. What a simplified model has of that is the
//! mean perimeter of its projected triangles, in pixels; its reciprocal is the frequency ρ of the paper
//! (§5.1). Equilateral triangles of area A have the perimeter 3·√(4A/√3) = 4.559·√A.

use super::level_of_detail::{CoarsestLevel, Rule};
use crate::outcome::Outcome;
use serde::Serialize;
use std::collections::BTreeMap;

/// The highest frequency that has to be kept at a speed.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Point {
    /// Name of the model, if the law is of several.
    pub model: Option<String>,
    /// The speed v.
    pub speed: f64,
    /// The spatial frequency ρ.
    pub frequency: f64,
}

/// The spatial frequency of each model at each of its levels of detail.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Frequencies {
    /// By model: levels of detail, ascending, with their frequencies.
    models: BTreeMap<String, Vec<(f64, f64)>>,
}

impl Frequencies {
    /// Adds that `model` has `frequency` at `level`.
    ///
    /// # Errors
    /// It has another one already, which is returned.
    pub fn insert(&mut self, model: &str, level: f64, frequency: f64) -> Result<(), f64> {
        let known = self.models.entry(model.into()).or_default();
        match known.binary_search_by(|(other, _)| other.total_cmp(&level)) {
            Ok(place) if known[place].1 != frequency => Err(known[place].1),
            Ok(_) => Ok(()),
            Err(place) => {
                known.insert(place, (level, frequency));
                Ok(())
            }
        }
    }

    /// The frequency of `model` at `level`; between two known levels by a straight line through the
    /// logarithms of both, which is exact where the frequency is a power of the level.
    ///
    /// # Errors
    /// Says which model or level has no frequency.
    pub fn at(&self, model: &str, level: f64) -> Outcome<f64> {
        let known = self.models.get(model).ok_or_else(|| {
            format!("`{model}` has no spatial frequencies, and a share of faces is no frequency")
        })?;
        let above = known.partition_point(|(other, _)| *other < level);
        match (known[..above].last(), known.get(above)) {
            (_, Some((other, frequency))) if *other == level => Ok(*frequency),
            (Some((low, at_low)), Some((high, at_high))) => {
                let part = libm::log(level / low) / libm::log(high / low);
                Ok(at_low * libm::pow(at_high / at_low, part))
            }
            _ => Err(format!(
                "the spatial frequencies of `{model}` do not reach to its level of detail {level}"
            )),
        }
    }
}

/// The points that follow from the coarsest `levels` by `rule`, and in words what gives none.
pub fn points(
    levels: &[CoarsestLevel],
    rule: Rule,
    frequencies: &Frequencies,
) -> (Vec<Point>, Vec<String>) {
    let (mut points, mut left_out) = (Vec::new(), Vec::new());
    for coarsest in levels {
        let CoarsestLevel { model, speed, .. } = coarsest;
        match coarsest.level(rule).and_then(|level| frequencies.at(model, level)) {
            Ok(frequency) => {
                points.push(Point { model: Some(model.clone()), speed: *speed, frequency });
            }
            Err(reason) => left_out.push(format!("{model} at speed {speed}: {reason}.")),
        }
    }
    (points, left_out)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frequencies_between_levels_follow_a_power() {
        let mut frequencies = Frequencies::default();
        for level in [0.01_f64, 0.04, 0.16] {
            frequencies.insert("bunny", level, 0.3 * level.sqrt()).unwrap();
        }
        for level in [0.01_f64, 0.02, 0.04, 0.1, 0.16] {
            let found = frequencies.at("bunny", level).unwrap();
            assert!((found - 0.3 * level.sqrt()).abs() < 1e-15);
        }
        assert_eq!(frequencies.insert("bunny", 0.01, 0.03), Ok(()));
        assert_eq!(frequencies.insert("bunny", 0.01, 0.04), Err(0.03));
        assert!(frequencies.at("bunny", 0.2).unwrap_err().contains("do not reach to its level"));
        assert!(frequencies.at("igea", 0.2).unwrap_err().starts_with("`igea` has no spatial"));
    }

    #[test]
    fn equilateral_triangles_have_that_perimeter() {
        let side = 2.0_f64;
        let area = 0.25 * 3.0_f64.sqrt() * side * side;
        let factor = 3.0 * (4.0 / 3.0_f64.sqrt()).sqrt();
        assert!((3.0 * side - factor * area.sqrt()).abs() < 1e-12);
        assert!((factor - 4.559).abs() < 1e-3);
    }
}
