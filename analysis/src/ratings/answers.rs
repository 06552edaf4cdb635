//! The answers that ratings are made of: who said "same" and who "different" of which image.

use super::images::{Counts, Image};
use crate::maths::bootstrap::enough_observers;
use crate::maths::resampling::{binomial, drawn};
use crate::outcome::Outcome;
use rand::Rng;
use shutterlab_data_schema::Response;
use shutterlab_data_schema::fitted::VelocityUnit;
use shutterlab_data_schema::response::{Answer, TrialKind};
use std::cmp::Ordering;
use std::collections::BTreeMap;

/// One answer to the question whether the image of a simplified model looks the same as that of the
/// original.
#[derive(Clone, Debug, PartialEq)]
pub struct RatingTrial {
    /// Number of who answered.
    pub observer: usize,
    /// Name of the model.
    pub model: String,
    /// The weight's exponent that it was simplified with.
    pub r: f64,
    /// Part of the original's faces, above 0 up to 1.
    pub level_of_detail: f64,
    /// Speed of the model, in the unit of the [`Ratings`].
    pub speed: f64,
    /// Whether it looks the same; none for "not sure".
    pub same: Option<bool>,
}

/// The answers to all images.
#[derive(Clone, Debug, PartialEq)]
pub struct Ratings {
    /// The unit of all speeds.
    pub speed_unit: VelocityUnit,
    /// Whether the answers were simulated, where that is known.
    pub simulated: Option<bool>,
    /// How many answers of a study do not say of which simplified model they are, and are left out.
    pub unnamed: usize,
    images: Vec<Image>,
    answers: Answers,
}

/// Counts in the order of the images.
#[derive(Clone, Debug, PartialEq)]
enum Answers {
    /// Of each observer.
    Observers(Vec<Vec<Counts>>),
    /// Of all observers together.
    Together(Vec<Counts>),
}

impl Ratings {
    /// The answers of single trials.
    ///
    /// # Errors
    /// A trial has values that nothing can have, or there is no trial.
    pub fn from_trials(trials: &[RatingTrial], speed_unit: VelocityUnit) -> Outcome<Self> {
        let mut images = Vec::with_capacity(trials.len());
        for trial in trials {
            let RatingTrial { model, r, level_of_detail, speed, .. } = trial.clone();
            images.push(Image { model, r, speed, level_of_detail }.checked()?);
        }
        let of_trials = images.clone();
        images.sort_by(Image::order);
        images.dedup();
        if images.is_empty() {
            return Err("there is no answer to an image of a simplified model".into());
        }
        let mut observers: Vec<usize> = trials.iter().map(|trial| trial.observer).collect();
        observers.sort_unstable();
        observers.dedup();
        let mut answers = vec![vec![Counts::default(); images.len()]; observers.len()];
        for (trial, image) in trials.iter().zip(&of_trials) {
            // Both were found among these above.
            let observer = observers.partition_point(|observer| *observer < trial.observer);
            let place = images.partition_point(|other| other.order(image) == Ordering::Less);
            let counts = &mut answers[observer][place];
            match trial.same {
                Some(true) => counts.same += 1,
                Some(false) => counts.different += 1,
                None => counts.not_sure += 1,
            }
        }
        let answers = Answers::Observers(answers);
        Ok(Self { speed_unit, simulated: None, unnamed: 0, images, answers })
    }

    /// The answers of a study: of the `rows`, each a trial of the task same-different that counts, those that
    /// say of which model they are. Trials in which the original was compared with itself are no ratings.
    /// Speeds are in degrees per second.
    ///
    /// # Errors
    /// No row says model, r and level of detail; or as [`Ratings::from_trials`].
    pub fn from_responses(rows: &[&Response]) -> Outcome<Self> {
        let mut observers: BTreeMap<String, usize> = BTreeMap::new();
        let mut unnamed = 0;
        let trials: Vec<RatingTrial> = rows
            .iter()
            .filter(|row| row.stimulus_a != row.stimulus_b)
            .filter_map(|row| {
                let same = match row.answer {
                    Answer::Same => Some(true),
                    Answer::Different => Some(false),
                    Answer::NotSure => None,
                    Answer::First | Answer::Second => return None,
                };
                let (Some(model), Some(r), Some(level_of_detail)) =
                    (row.model.clone(), row.r, row.level_of_detail)
                else {
                    unnamed += 1;
                    return None;
                };
                let speed = row.speed_deg_per_s;
                let next = observers.len();
                let observer = *observers.entry(row.subject.to_string()).or_insert(next);
                Some(RatingTrial { observer, model, r, level_of_detail, speed, same })
            })
            .collect();
        if trials.is_empty() {
            return Err(
                "no answer says of which simplified model it is: the columns model, r and \
                        level_of_detail are empty"
                    .into(),
            );
        }
        let ratings = Self::from_trials(&trials, VelocityUnit::DegreesPerSecond)?;
        let simulated = rows.iter().any(|row| row.kind == TrialKind::Simulated);
        Ok(Self { simulated: Some(simulated), unnamed, ..ratings })
    }

    /// The answers of all observers together; each image once.
    pub(super) fn together(rows: Vec<(Image, Counts)>, speed_unit: VelocityUnit) -> Self {
        let mut rows = rows;
        rows.sort_by(|(a, _), (b, _)| a.order(b));
        let (images, counts) = rows.into_iter().unzip();
        Self { speed_unit, simulated: None, unnamed: 0, images, answers: Answers::Together(counts) }
    }

    /// The images, by model, r, speed and level of detail.
    pub fn images(&self) -> &[Image] {
        &self.images
    }

    /// How many observers there are, if they are told apart.
    pub fn observers(&self) -> Option<usize> {
        match &self.answers {
            Answers::Observers(observers) => Some(observers.len()),
            Answers::Together(_) => None,
        }
    }

    /// Whether an observer answered to an image more than once.
    pub fn repeated(&self) -> bool {
        match &self.answers {
            Answers::Observers(observers) => {
                observers.iter().flatten().any(|counts| counts.trials() + counts.not_sure > 1)
            }
            Answers::Together(_) => false,
        }
    }

    /// The answers to each image.
    pub fn counts(&self) -> Vec<Counts> {
        match &self.answers {
            Answers::Observers(observers) => self.weighted(observers, &vec![1; observers.len()]),
            Answers::Together(counts) => counts.clone(),
        }
    }

    /// The answers to each image of all observers but number `left_out`.
    pub(super) fn counts_without(&self, left_out: usize) -> Vec<Counts> {
        match &self.answers {
            Answers::Observers(observers) => {
                let times = (0..observers.len()).map(|observer| u64::from(observer != left_out));
                self.weighted(observers, &times.collect::<Vec<_>>())
            }
            Answers::Together(counts) => counts.clone(),
        }
    }

    /// Whether there are observers enough to draw from.
    pub(super) fn enough_to_draw(&self) -> Outcome<()> {
        self.observers().map_or(Ok(()), enough_observers)
    }

    /// The answers of as many observers drawn with replacement; if observers are not told apart, as many
    /// answers to each image, drawn from those it has.
    pub(super) fn draw(&self, random: &mut impl Rng) -> Vec<Counts> {
        match &self.answers {
            Answers::Observers(observers) => {
                self.weighted(observers, &drawn(observers.len(), random))
            }
            Answers::Together(counts) => {
                let redrawn = |counts: &Counts| {
                    let trials = counts.trials();
                    let share = counts.same as f64 / trials.max(1) as f64;
                    let same = binomial(trials, share, random);
                    Counts { same, different: trials - same, ..*counts }
                };
                counts.iter().map(redrawn).collect()
            }
        }
    }

    /// Only the images of models simplified with `r`.
    pub fn only_r(&self, r: f64) -> Self {
        let keep: Vec<bool> = self.images.iter().map(|image| image.r == r).collect();
        fn kept<T: Clone>(all: &[T], keep: &[bool]) -> Vec<T> {
            all.iter().zip(keep).filter(|(_, keep)| **keep).map(|(one, _)| one.clone()).collect()
        }
        let answers = match &self.answers {
            Answers::Observers(observers) => {
                Answers::Observers(observers.iter().map(|counts| kept(counts, &keep)).collect())
            }
            Answers::Together(counts) => Answers::Together(kept(counts, &keep)),
        };
        Self { images: kept(&self.images, &keep), answers, ..*self }
    }

    /// The values of r that images have, ascending.
    pub fn rs(&self) -> Vec<f64> {
        let mut rs: Vec<f64> = self.images.iter().map(|image| image.r).collect();
        rs.sort_by(f64::total_cmp);
        rs.dedup();
        rs
    }

    /// The models, in alphabetic order.
    pub fn models(&self) -> Vec<String> {
        let mut models: Vec<String> = self.images.iter().map(|image| image.model.clone()).collect();
        models.dedup();
        models
    }

    fn weighted(&self, observers: &[Vec<Counts>], times: &[u64]) -> Vec<Counts> {
        let mut sum = vec![Counts::default(); self.images.len()];
        for (counts, times) in observers.iter().zip(times).filter(|(_, times)| **times > 0) {
            sum.iter_mut().zip(counts).for_each(|(sum, counts)| sum.add(*counts, *times));
        }
        sum
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::maths::random::stream;

    fn trial(
        observer: usize,
        model: &str,
        level_of_detail: f64,
        same: Option<bool>,
    ) -> RatingTrial {
        RatingTrial { observer, model: model.into(), r: 4.0, level_of_detail, speed: 5.0, same }
    }

    fn trials() -> Vec<RatingTrial> {
        vec![
            trial(7, "igea", 0.1, Some(true)),
            trial(7, "bunny", 0.1, Some(false)),
            trial(3, "bunny", 0.1, Some(true)),
            trial(3, "bunny", 0.05, None),
        ]
    }

    #[test]
    fn trials_are_counted_by_image() {
        let ratings = Ratings::from_trials(&trials(), VelocityUnit::DegreesPerSecond).unwrap();
        let counts = |same, different, not_sure| Counts { same, different, not_sure };
        assert_eq!(ratings.counts(), [counts(0, 0, 1), counts(1, 1, 0), counts(1, 0, 0)]);
        assert_eq!(
            (ratings.observers(), ratings.models()),
            (Some(2), vec!["bunny".into(), "igea".into()])
        );
        assert!(!ratings.repeated());
        assert!(ratings.only_r(2.0).images().is_empty());
    }

    #[test]
    fn other_numbers_for_observers_and_another_order_change_nothing() {
        let unit = VelocityUnit::PixelsPerShutter;
        let ours = Ratings::from_trials(&trials(), unit).unwrap();
        let mut others = trials();
        others.reverse();
        others.iter_mut().for_each(|trial| trial.observer *= 10);
        assert_eq!(ours, Ratings::from_trials(&others, unit).unwrap());
    }

    #[test]
    fn values_that_nothing_can_have_are_refused() {
        let refused = |change: &dyn Fn(&mut RatingTrial)| {
            let mut trials = trials();
            change(&mut trials[1]);
            Ratings::from_trials(&trials, VelocityUnit::PixelsPerShutter).unwrap_err()
        };
        assert!(
            refused(&|t| t.level_of_detail = 0.0)
                .starts_with("level_of_detail of `bunny`: 0: above")
        );
        assert!(refused(&|t| t.r = f64::NAN).starts_with("r of `bunny`: NaN"));
        assert!(refused(&|t| t.speed = -1.0).starts_with("speed of `bunny`: -1"));
        let none = Ratings::from_trials(&[], VelocityUnit::PixelsPerShutter).unwrap_err();
        assert!(none.starts_with("there is no answer"));
    }

    #[test]
    fn whole_observers_are_drawn() {
        let ratings = Ratings::from_trials(&trials(), VelocityUnit::PixelsPerShutter).unwrap();
        for index in 0..20 {
            let drawn = ratings.draw(&mut stream(1, index));
            let [unsure, bunny, igea] = [drawn[0], drawn[1], drawn[2]];
            assert_eq!(
                (bunny.trials(), igea.same, unsure.not_sure),
                (2, bunny.different, bunny.same)
            );
        }
        assert!(ratings.enough_to_draw().unwrap_err().contains("at least 5 observers, here are 2"));
    }
}
