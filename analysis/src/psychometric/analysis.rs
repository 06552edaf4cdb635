//! What follows from answers by level: the fit, its threshold with three intervals, its goodness.

use super::bootstrap::{by_observer, parametric};
use super::fit::{PsychometricFit, fit};
use super::function::Model;
use super::goodness::{GoodnessOfFit, goodness_of_fit};
use super::table::Answers;
use super::threshold::{Threshold, threshold};
use crate::maths::resampling::Bootstrap;
use crate::outcome::{Outcome, entry};
use serde::ser::{Serialize, SerializeMap, Serializer};

/// A psychometric function and its threshold.
#[derive(Clone, Debug, PartialEq)]
pub struct PsychometricAnalysis {
    /// The fitted function.
    pub fit: PsychometricFit,
    /// The level at which it reaches the chance asked for.
    pub threshold: Outcome<Threshold>,
    /// Its bootstrap interval.
    pub bootstrap: Outcome<Bootstrap>,
    /// How many observers were drawn from; none if answers were drawn from the fitted function.
    pub observers: Option<usize>,
    /// Tests of the deviance.
    pub goodness_of_fit: Outcome<GoodnessOfFit>,
}

/// Fits `model` to `answers` and finds where it reaches `chance`. `replicates` are drawn with `seed` for
/// the bootstrap and again for the goodness of fit.
///
/// # Errors
/// As [`fit`].
pub fn analyze(
    answers: &Answers,
    model: Model,
    chance: f64,
    replicates: usize,
    seed: u64,
) -> Outcome<PsychometricAnalysis> {
    let fit = fit(&answers.levels, model)?;
    let threshold = threshold(&fit, chance);
    let bootstrap = match (&threshold, &answers.observers) {
        (Err(reason), _) => Err(reason.clone()),
        (Ok(found), _) if found.profile_95_reason.is_some() => {
            Err("the profile interval is open, and resamples cannot close it".into())
        }
        (_, Some(observers)) => by_observer(&fit, observers, chance, replicates, seed),
        _ => parametric(&fit, chance, replicates, seed),
    };
    let goodness_of_fit = goodness_of_fit(&fit, replicates, seed);
    let observers = answers.observers.as_ref().map(Vec::len);
    Ok(PsychometricAnalysis { fit, threshold, bootstrap, observers, goodness_of_fit })
}

impl Serialize for PsychometricAnalysis {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(None)?;
        map.serialize_entry("fit", &self.fit)?;
        entry(&mut map, "threshold", &self.threshold)?;
        entry(&mut map, "bootstrap", &self.bootstrap)?;
        map.serialize_entry("observers", &self.observers)?;
        entry(&mut map, "goodness_of_fit", &self.goodness_of_fit)?;
        map.end()
    }
}

#[cfg(test)]
mod tests {
    use super::super::function::Shape;
    use super::super::section::section;
    use super::super::table::parse;
    use super::*;

    #[test]
    fn an_open_profile_interval_leaves_no_bootstrap() {
        let answers =
            parse("level,chosen,trials\n1,10,20\n2,9,20\n3,11,20\n4,11,20\n", "t").unwrap();
        let model = Model::yes_no(Shape::Logistic);
        let found = analyze(&answers, model, 0.5, 99, 1).unwrap();
        assert!(section(&found).sentences[0].starts_with("The table does not say whether people"));
        assert!(found.threshold.unwrap().profile_95_reason.is_some());
        assert!(found.bootstrap.unwrap_err().contains("profile interval is open"));
    }
}
