//! Everything that the choices of a study say about places on a scale.

use super::bootstrap::{Bootstrap, bootstrap};
use super::comparisons::Comparisons;
use super::connection::{check_connected, separation};
use super::differences::{Difference, differences};
use super::fit::{Estimation, Scale, fit};
use super::goodness_of_fit::{GoodnessOfFit, goodness_of_fit};
use super::intervals::profile_95;
use super::model::Model;
use super::simulated_fit::{SimulatedFit, simulated_fit};
use super::ties::{Davidson, davidson};
use crate::input::preferences::Preferences;
use crate::outcome::{Outcome, entry};
use rayon::prelude::*;
use serde::ser::{Serialize, SerializeMap, Serializer};

/// Beyond so many items, intervals that need many fits are left out.
const MOST_ITEMS: usize = 50;
/// How many studies are simulated to test the fit.
const SIMULATED: usize = 999;

/// Scale values of a study's items by both models, with what belongs to them.
#[derive(Clone, Debug, PartialEq)]
pub struct Scaling {
    /// The items, in the order of the input.
    pub items: Vec<String>,
    /// The number of observers, where they are known one by one.
    pub observers: Outcome<usize>,
    /// The number of answers.
    pub trials: f64,
    /// How many of them chose neither; each counts as half a win for both.
    pub ties: f64,
    /// How many pairs were compared.
    pub pairs: usize,
    /// Why there are no maximum-likelihood values, and all values are bias-reduced.
    pub separation: Option<String>,
    /// The scale of Bradley and Terry (1952).
    pub bradley_terry: Fitted,
    /// The scale of Thurstone's (1927) Case V.
    pub thurstone: Fitted,
    /// Davidson's (1970) model, in which ties have a threshold.
    pub davidson: Outcome<Davidson>,
}

/// A scale with intervals, tests and its fit. Lists of intervals are in the order of the items.
#[derive(Clone, Debug, PartialEq)]
pub struct Fitted {
    /// Values and their covariance.
    pub scale: Scale,
    /// 95 % intervals of the profile likelihood of each value.
    pub profile_95: Outcome<Vec<[f64; 2]>>,
    /// Replicates by observer.
    pub bootstrap: Outcome<Bootstrap>,
    /// How well the scale describes the choices.
    pub goodness_of_fit: GoodnessOfFit,
    /// The same by simulation.
    pub simulated_fit: Outcome<SimulatedFit>,
    /// Differences of all pairs of items.
    pub differences: Vec<Difference>,
}

/// Scales the choices of a study; random draws follow from `seed`.
///
/// # Errors
/// In words: single choices are not known, or they do not connect the items.
pub fn scaling(preferences: &Preferences, seed: u64) -> Outcome<Scaling> {
    let items = preferences.items();
    if !preferences.choices.is_empty() {
        let observers = preferences.observers.len();
        let observers = Comparisons::of_choices(items, observers, &preferences.choices);
        return of_observers(&observers, seed);
    }
    let wins = preferences.pooled().ok_or("votes alone do not tell the answers to single pairs")?;
    let pooled = Comparisons::of_wins(items, &wins);
    scale_all(
        &pooled,
        Err("a pooled matrix does not tell the answers of single observers".into()),
        seed,
    )
}

/// Scales the answers of `observers`, who judged the same items.
///
/// # Errors
/// In words: the answers do not connect the items.
pub fn of_observers(observers: &[Comparisons], seed: u64) -> Outcome<Scaling> {
    scale_all(&Comparisons::pooled(observers), Ok(observers), seed)
}

fn scale_all(
    pooled: &Comparisons,
    observers: Outcome<&[Comparisons]>,
    seed: u64,
) -> Outcome<Scaling> {
    check_connected(pooled)?;
    let separation = separation(pooled);
    let estimation = match separation {
        None => Estimation::MaximumLikelihood,
        Some(_) => Estimation::BiasReduced,
    };
    let fitted = |model| -> Outcome<Fitted> {
        let scale = fit(pooled, model, estimation)?;
        Ok(Fitted {
            profile_95: profiles(pooled, &scale),
            bootstrap: observers.clone().and_then(|observers| {
                let replicates = replicates(pooled.items().len())?;
                bootstrap(observers, model, replicates, seed)
            }),
            goodness_of_fit: goodness_of_fit(pooled, &scale),
            simulated_fit: check_size(pooled.items().len())
                .and_then(|()| simulated_fit(pooled, model, SIMULATED, seed)),
            differences: differences(&scale),
            scale,
        })
    };
    Ok(Scaling {
        items: pooled.items().to_vec(),
        observers: observers.clone().map(<[_]>::len),
        trials: pooled.trials(),
        ties: pooled.ties(),
        pairs: pooled.pairs().len(),
        bradley_terry: fitted(Model::BradleyTerry)?,
        thurstone: fitted(Model::ThurstoneV)?,
        davidson: davidson(pooled),
        separation,
    })
}

fn replicates(t: usize) -> Outcome<usize> {
    check_size(t)?;
    Ok(if t <= 20 { 10_000 } else { 2_000 })
}

fn profiles(pooled: &Comparisons, scale: &Scale) -> Outcome<Vec<[f64; 2]>> {
    let t = scale.items.len();
    check_size(t)?;
    let of_item = |item| {
        let mut contrast = vec![-1.0 / t as f64; t];
        contrast[item] += 1.0;
        profile_95(pooled, scale, &contrast)
    };
    (0..t).into_par_iter().map(of_item).collect()
}

fn check_size(t: usize) -> Outcome<()> {
    match t {
        ..=MOST_ITEMS => Ok(()),
        _ => Err(format!("with more than {MOST_ITEMS} items it would take too long")),
    }
}

impl Scaling {
    /// The scales of both models.
    pub(super) fn both(&self) -> [&Fitted; 2] {
        [&self.bradley_terry, &self.thurstone]
    }
}

impl Fitted {
    /// The 95 % bootstrap interval of item `i` against the mean of all.
    pub fn bootstrap_95(&self, i: usize) -> Option<[f64; 2]> {
        self.bootstrap.as_ref().ok().map(|drawn| drawn.interval_95(|values| values[i]))
    }

    /// The profile interval of item `i`.
    pub fn profile_95(&self, i: usize) -> Option<[f64; 2]> {
        self.profile_95.as_ref().ok().map(|intervals| intervals[i])
    }
}

impl Serialize for Scaling {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(None)?;
        map.serialize_entry("items", &self.items)?;
        entry(&mut map, "observers", &self.observers)?;
        map.serialize_entry("trials", &self.trials)?;
        map.serialize_entry("ties", &self.ties)?;
        map.serialize_entry("pairs", &self.pairs)?;
        map.serialize_entry("separation", &self.separation)?;
        map.serialize_entry("bradley_terry", &self.bradley_terry)?;
        map.serialize_entry("thurstone", &self.thurstone)?;
        entry(&mut map, "davidson", &self.davidson)?;
        map.end()
    }
}

impl Serialize for Fitted {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let t = self.scale.items.len();
        let intervals = |of: &dyn Fn(usize) -> Option<[f64; 2]>| (0..t).map(of).collect::<Vec<_>>();
        let mut map = serializer.serialize_map(None)?;
        map.serialize_entry("scale", &self.scale)?;
        map.serialize_entry("wald_95", &intervals(&|i| Some(self.scale.centred(i).wald_95())))?;
        entry(&mut map, "profile_95", &self.profile_95)?;
        entry(&mut map, "bootstrap", &self.bootstrap)?;
        let drawn = self.bootstrap.as_ref().ok().map(|_| intervals(&|i| self.bootstrap_95(i)));
        map.serialize_entry("bootstrap_95", &drawn)?;
        map.serialize_entry("goodness_of_fit", &self.goodness_of_fit)?;
        entry(&mut map, "simulated_fit", &self.simulated_fit)?;
        map.serialize_entry("differences", &self.differences)?;
        map.end()
    }
}
