//! The histogram for r: how many images of models simplified with each r look like the original (Zhang
//! et al. 2014, Fig. 8d), and how sure the best one is.

use super::answers::Ratings;
use super::images::Counts;
use super::rating::reaches;
use crate::maths::resampling::{Bootstrap, replicates};
use crate::outcome::{Outcome, entry};
use serde::Serialize;
use serde::ser::{SerializeMap, Serializer};

/// An r is chosen when it is ahead in this part of the resamples.
const DECIDED: f64 = 0.95;

/// Images over the threshold, by r.
#[derive(Clone, Debug, PartialEq)]
pub struct Histogram {
    /// One bin for each r, ascending.
    pub bins: Vec<Bin>,
    /// The r that is ahead in 95 % of the resamples or more.
    pub chosen: Outcome<f64>,
    /// Whether each r was rated with the same models, levels of detail and speeds.
    pub balanced: bool,
    /// How many observers were drawn from; none if the answers to each image were drawn.
    pub observers: Option<usize>,
    /// How many resamples were drawn.
    pub replicates: usize,
}

/// The images of one r.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Bin {
    /// The weight's exponent.
    pub r: f64,
    /// Its images that have a rating.
    pub images: u64,
    /// Those with a rating of 0.8 or more.
    pub over: u64,
    /// `over`/`images`.
    pub share: Option<f64>,
    /// Its bootstrap interval.
    pub share_95: Option<[f64; 2]>,
    /// In which part of the resamples its share is the largest; r that are level share a resample.
    pub won: Option<f64>,
}

/// The histogram of `answers`, with `count` resamples drawn with `seed`.
///
/// # Formula
/// ```text
/// share(r) = #{images of r with u₁/(u₁ + u₂) ≥ 0.8} / #{images of r with answers}
/// ```
pub fn histogram(answers: &Ratings, count: usize, seed: u64) -> Histogram {
    let rs = answers.rs();
    let place: Vec<usize> =
        answers.images().iter().map(|image| rs.partition_point(|r| *r < image.r)).collect();
    let tally = |counts: &[Counts]| {
        let mut tally = vec![(0, 0); rs.len()];
        for (counts, place) in counts.iter().zip(&place).filter(|(c, _)| c.trials() > 0) {
            tally[*place].0 += u64::from(reaches(counts.same, counts.trials()));
            tally[*place].1 += 1;
        }
        tally
    };
    let share = |(over, images): (u64, u64)| (images > 0).then(|| over as f64 / images as f64);
    let enough = answers.enough_to_draw();
    let drawn = if enough.is_ok() { count } else { 0 };
    let resampled: Vec<Vec<Option<f64>>> = replicates(drawn, seed, |random| {
        tally(&answers.draw(random)).into_iter().map(share).collect()
    });
    let mut won = vec![0.0; rs.len()];
    for shares in &resampled {
        let ahead = winners(shares);
        ahead.iter().for_each(|place| won[*place] += 1.0 / ahead.len() as f64);
    }
    let observed = tally(&answers.counts());
    let bins: Vec<Bin> = observed
        .iter()
        .enumerate()
        .map(|(i, (over, images))| {
            let shares: Vec<Option<f64>> = resampled.iter().map(|shares| shares[i]).collect();
            Bin {
                r: rs[i],
                images: *images,
                over: *over,
                share: share(observed[i]),
                // Resampled ratings scatter more than those rated, which makes up for few observers.
                share_95: Bootstrap::percentile(&shares, None)
                    .ok()
                    .map(|bootstrap| bootstrap.interval_95),
                won: (drawn > 0).then(|| won[i] / drawn as f64),
            }
        })
        .collect();
    let balanced = balanced(answers, &rs);
    let chosen = choose(&bins, balanced, enough);
    Histogram { bins, chosen, balanced, observers: answers.observers(), replicates: drawn }
}

/// The places of the largest share.
fn winners(shares: &[Option<f64>]) -> Vec<usize> {
    let most = shares.iter().flatten().copied().fold(f64::NEG_INFINITY, f64::max);
    (0..shares.len()).filter(|i| shares[*i] == Some(most)).collect()
}

/// Whether every r comes with the same images that have answers.
fn balanced(answers: &Ratings, rs: &[f64]) -> bool {
    let counts = answers.counts();
    let of_r = |r: f64| {
        let images = answers.images().iter().zip(&counts);
        let rated = images.filter(move |(image, counts)| image.r == r && counts.trials() > 0);
        rated
            .map(|(image, _)| (&image.model, image.speed, image.level_of_detail))
            .collect::<Vec<_>>()
    };
    rs.windows(2).all(|pair| of_r(pair[0]) == of_r(pair[1]))
}

fn choose(bins: &[Bin], balanced: bool, enough: Outcome<()>) -> Outcome<f64> {
    if bins.iter().all(|bin| bin.images == 0) {
        return Err("no image has an answer".into());
    }
    if let [only] = bins {
        return Err(format!(
            "models were simplified with r = {} only: there is nothing to choose",
            only.r
        ));
    }
    let shares: Vec<Option<f64>> = bins.iter().map(|bin| bin.share).collect();
    let ahead = winners(&shares);
    let list = |places: &[usize], number: &dyn Fn(&Bin) -> String| {
        places.iter().map(|i| number(&bins[*i])).collect::<Vec<_>>().join(", ")
    };
    let [best] = ahead[..] else {
        let rs = list(&ahead, &|bin| bin.r.to_string());
        return Err(format!("r is hardly identifiable: as many images reach 0.8 with r = {rs}"));
    };
    let Bin { r, over, images, .. } = bins[best];
    if !balanced {
        return Err(format!(
            "r = {r} has the largest share of images that reach 0.8, but not every r was rated \
             with the same models, levels of detail and speeds, so the shares do not compare"
        ));
    }
    enough.map_err(|reason| format!("how sure r = {r} is ahead does not follow: {reason}"))?;
    let won = bins[best].won.unwrap_or(0.0);
    if won >= DECIDED {
        return Ok(r);
    }
    let mut others: Vec<usize> =
        (0..bins.len()).filter(|i| *i != best && bins[*i].won > Some(0.0)).collect();
    others.sort_by(|a, b| {
        bins[*b].won.partial_cmp(&bins[*a].won).unwrap_or(std::cmp::Ordering::Equal)
    });
    let others =
        list(&others, &|bin| format!("r = {} in {:.0} %", bin.r, 100.0 * bin.won.unwrap_or(0.0)));
    Err(format!(
        "r is hardly identifiable: most images reach 0.8 with r = {r} ({over} of {images}), but \
         it is ahead in {:.0} % of the resamples only ({others}); 95 % are needed",
        100.0 * won
    ))
}

impl Serialize for Histogram {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(None)?;
        map.serialize_entry("bins", &self.bins)?;
        entry(&mut map, "chosen", &self.chosen)?;
        map.serialize_entry("balanced", &self.balanced)?;
        map.serialize_entry("observers", &self.observers)?;
        map.serialize_entry("replicates", &self.replicates)?;
        map.end()
    }
}

#[cfg(test)]
mod tests {
    use super::super::answers::RatingTrial;
    use super::*;
    use shutterlab_data_schema::fitted::VelocityUnit;

    /// Answers of 20 observers to ten images per r, of which the first `over` are called the same by 19.
    fn answers(over: &[(f64, usize)]) -> Vec<RatingTrial> {
        let images =
            over.iter().flat_map(|(r, over)| (0..10).map(move |image| (*r, image, image < *over)));
        let trials = images.flat_map(|(r, image, good)| {
            (0..20).map(move |observer| RatingTrial {
                observer,
                model: format!("model-{image}"),
                r,
                level_of_detail: 0.1,
                speed: 2.0,
                same: Some(if good { observer != 3 } else { observer < 10 }),
            })
        });
        trials.collect()
    }

    fn found(trials: &[RatingTrial]) -> Histogram {
        histogram(&Ratings::from_trials(trials, VelocityUnit::PixelsPerShutter).unwrap(), 499, 1)
    }

    #[test]
    fn a_clear_winner_is_chosen() {
        let histogram = found(&answers(&[(0.0, 2), (4.0, 9), (8.0, 5)]));
        assert_eq!(histogram.chosen, Ok(4.0));
        let four = &histogram.bins[1];
        assert_eq!((four.over, four.images), (9, 10));
        assert!(four.won > Some(0.95));
        assert!(four.share_95.unwrap()[0] <= 0.9);
    }

    #[test]
    fn what_is_not_decided_is_said_in_words() {
        let reason = |trials: &[RatingTrial]| found(trials).chosen.unwrap_err();
        assert!(reason(&answers(&[(2.0, 7), (4.0, 7)])).contains("reach 0.8 with r = 2, 4"));
        assert!(
            reason(&answers(&[(4.0, 7)])).starts_with("models were simplified with r = 4 only")
        );
        let mut unsure = answers(&[(2.0, 7), (4.0, 7)]);
        unsure.iter_mut().for_each(|trial| trial.same = None);
        assert_eq!(reason(&unsure), "no image has an answer");
        let mut uneven = answers(&[(2.0, 3), (4.0, 7)]);
        uneven.retain(|trial| trial.r == 4.0 || trial.model != "model-9");
        assert!(reason(&uneven).contains("not every r was rated with the same"));
        let mut one = answers(&[(2.0, 3), (4.0, 7)]);
        one.retain(|trial| trial.observer == 0);
        // What one observer says is alike for both: all images.
        assert!(reason(&one).contains("hardly identifiable"), "{}", reason(&one));
        // One observer decides for r = 2: the image rests on a single answer.
        let mut close = answers(&[(2.0, 6), (4.0, 6)]);
        for trial in close.iter_mut().filter(|t| t.r == 2.0 && t.model == "model-7") {
            trial.same = Some(trial.observer < 16);
        }
        assert!(reason(&close).contains("of the resamples only (r = 4 in"), "{}", reason(&close));
    }
}
