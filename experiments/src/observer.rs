//! Simulated observers: they answer like people of whom only the votes are known, so that a study can
//! be rehearsed from the first trial to the report. Their answers are marked as simulated everywhere.

use crate::bradley_terry::{FitError, strengths};
use crate::design::Trial;
use crate::random::{Stream, session_seed};
use crate::stimuli_set::StimulusSet;
use shutterlab_data_schema::response::{Answer, Side};
use shutterlab_data_schema::{ParticipantCode, Votes};
use shutterlab_stimuli::Stimulus;

/// A sort of simulated observer.
#[derive(Clone, Debug, PartialEq)]
pub struct SimulatedObserver {
    name: String,
    /// Items and their strengths; none for an observer who guesses.
    items: Vec<(String, f64)>,
}

/// A simulated observer cannot be made, or cannot judge the stimuli. The message begins with its name.
#[derive(Debug, PartialEq, thiserror::Error)]
pub enum ObserverError {
    /// No model has these votes.
    #[error("{name}: {source}")]
    Fit {
        /// Name of the observer.
        name: String,
        /// Why.
        source: FitError,
    },
    /// Not exactly one item of the votes is about a stimulus.
    #[error(
        "{name}: stimulus {stimulus}: {found} of the items {items} are about it: exactly one must name levels of it and no others"
    )]
    Items {
        /// Name of the observer.
        name: String,
        /// Id of the stimulus.
        stimulus: String,
        /// How many items are about it.
        found: usize,
        /// The items.
        items: String,
    },
}

impl SimulatedObserver {
    /// One who guesses: `simulated:guess`.
    pub fn guess() -> Self {
        Self { name: "guess".into(), items: vec![] }
    }

    /// One of `observers` people who gave `votes`, all of them alike: `simulated:NAME`. Probabilities
    /// follow the Bradley–Terry model whose expected votes are the given ones.
    ///
    /// # Errors
    /// No model has these votes; they are named.
    pub fn from_votes(name: &str, votes: &Votes, observers: u32) -> Result<Self, ObserverError> {
        let strengths = strengths(votes, observers)
            .map_err(|source| ObserverError::Fit { name: format!("simulated:{name}"), source })?;
        let names = votes.rows.iter().map(|row| row.item.clone());
        Ok(Self { name: name.into(), items: names.zip(strengths).collect() })
    }

    /// `simulated:NAME`, as the records have it.
    pub fn name(&self) -> String {
        format!("simulated:{}", self.name)
    }

    /// How strong each compared stimulus of `set` is for this observer.
    ///
    /// An item like `A4T3` is about the stimuli that have both levels, A4 and T3: a level's name
    /// begins at each capital letter.
    ///
    /// # Errors
    /// A stimulus that no item is about, or several are.
    pub fn strengths(&self, set: &StimulusSet) -> Result<Vec<f64>, ObserverError> {
        let stimuli = (0..set.compared).map(|index| set.stimulus(index));
        if self.items.is_empty() {
            return Ok(vec![1.0; set.compared]);
        }
        stimuli
            .map(|stimulus| {
                let about: Vec<f64> = self
                    .items
                    .iter()
                    .filter(|(item, _)| is_about(item, stimulus))
                    .map(|(_, strength)| *strength)
                    .collect();
                match about[..] {
                    [strength] => Ok(strength),
                    _ => {
                        let names: Vec<&str> = self.items.iter().map(|(n, _)| n.as_str()).collect();
                        Err(ObserverError::Items {
                            name: self.name(),
                            stimulus: stimulus.id.clone(),
                            found: about.len(),
                            items: names.join(", "),
                        })
                    }
                }
            })
            .collect()
    }
}

/// A simulated observer in one session. Answers are keyed by the trial, so a session that was
/// interrupted gets the same ones when it goes on.
#[derive(Clone, Debug)]
pub struct Judge {
    strengths: Vec<f64>,
    seed: u64,
}

/// Median response time. No finding: a plausible number, so that files look like files.
const MEDIAN_RESPONSE_S: f64 = 1.2;

/// Standard deviation of the logarithm of the response time.
const LOG_RESPONSE_SD: f64 = 0.4;

impl Judge {
    /// `observer` as `subject` in session `session` of a protocol with the seed `protocol_seed`.
    ///
    /// # Errors
    /// As [`SimulatedObserver::strengths`].
    pub fn new(
        observer: &SimulatedObserver,
        set: &StimulusSet,
        protocol_seed: u64,
        subject: &ParticipantCode,
        session: u32,
    ) -> Result<Self, ObserverError> {
        let seed = session_seed("answers", protocol_seed, subject, session);
        Ok(Self { strengths: observer.strengths(set)?, seed })
    }

    /// What the observer answers in `trial`, and after how many seconds: log-normal, whatever the
    /// stimuli. In practice, the better one is always chosen.
    pub fn answer(&self, trial: &Trial) -> (Answer, f64) {
        let mut stream = Stream::keyed(self.seed, u64::from(trial.number));
        let draw = stream.uniform();
        let selected = trial.better.unwrap_or_else(|| {
            let (a, b) = (self.strengths[trial.a], self.strengths[trial.b]);
            if draw < a / (a + b) { Side::A } else { Side::B }
        });
        let seconds = MEDIAN_RESPONSE_S * (LOG_RESPONSE_SD * stream.normal()).exp();
        (if selected == trial.first { Answer::First } else { Answer::Second }, seconds)
    }
}

fn is_about(item: &str, stimulus: &Stimulus) -> bool {
    let mut levels: Vec<String> = vec![];
    for letter in item.chars() {
        match levels.last_mut() {
            Some(level) if !letter.is_uppercase() => level.push(letter),
            _ => levels.push(letter.into()),
        }
    }
    levels.iter().all(|level| stimulus.levels.values().any(|name| name == level))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::design::plan;
    use crate::test_support::{protocol, rendered};

    /// 30 observers, 36 pairs: 1080 votes.
    fn votes() -> Votes {
        let text = "item,votes\nA5T3,190\nA4T3,170\nA3T3,150\nT4A5,140\nA4T4,120\nA3T4,110\n\
                    A5T5,90\nA4T5,70\nA3T5,40\n";
        Votes::parse(text, "test").unwrap()
    }

    fn set() -> StimulusSet {
        StimulusSet::open(&protocol(), rendered().path()).unwrap()
    }

    #[test]
    fn items_are_matched_to_stimuli_by_their_levels() {
        let observer = SimulatedObserver::from_votes("test", &votes(), 30).unwrap();
        let set = set();
        let strengths = observer.strengths(&set).unwrap();
        let best = (0..9).max_by(|a, b| strengths[*a].total_cmp(&strengths[*b])).unwrap();
        assert_eq!(set.stimulus(best).id, "M2-S2-T3-A5");
        assert_eq!(SimulatedObserver::guess().strengths(&set).unwrap(), [1.0; 9]);
    }

    #[test]
    fn a_stimulus_without_its_item_is_named() {
        let two = Votes::parse("item,votes\nA3T3,2\nA3,1\n", "test").unwrap();
        let observer = SimulatedObserver::from_votes("two", &two, 3).unwrap();
        let error = observer.strengths(&set()).unwrap_err().to_string();
        assert!(
            error.starts_with("simulated:two: stimulus M2-S2-T3-A3: 2 of the items"),
            "{error}"
        );
    }

    #[test]
    fn votes_without_a_model_name_the_observer() {
        let none = Votes::parse("item,votes\nA3,3\nA4,0\n", "test").unwrap();
        let error = SimulatedObserver::from_votes("none", &none, 3).unwrap_err().to_string();
        assert!(error.starts_with("simulated:none: votes: A4: "), "{error}");
    }

    /// 1200 simulated observers give votes in the proportions of the 30 they are modelled on.
    #[test]
    fn simulated_votes_agree_with_the_table() {
        const COHORT: u32 = 1200;
        let (votes, set, protocol) = (votes(), set(), protocol());
        let observer = SimulatedObserver::from_votes("test", &votes, 30).unwrap();
        let mut counts = [0_u32; 9];
        for number in 0..COHORT {
            let subject = format!("S{number}").parse().unwrap();
            let judge = Judge::new(&observer, &set, protocol.seed, &subject, 1).unwrap();
            for trial in plan(&protocol.design, 9, &[], u64::from(number)) {
                let (answer, seconds) = judge.answer(&trial);
                assert!(seconds > 0.0);
                counts[trial.stimulus(trial.side(answer))] += 1;
            }
        }
        for (index, count) in counts.into_iter().enumerate() {
            let row = votes.rows.iter().find(|row| is_about(&row.item, set.stimulus(index)));
            let expected = row.unwrap().votes as f64 * f64::from(COHORT) / 30.0;
            // At most 8 · ¼ · COHORT is the variance; five standard deviations.
            let bound = 5.0 * (2.0 * f64::from(COHORT)).sqrt();
            assert!((f64::from(count) - expected).abs() < bound, "{index}: {count} {expected}");
        }
    }

    #[test]
    fn practice_is_answered_rightly_and_every_answer_comes_again() {
        let (set, protocol) = (set(), protocol());
        let subject = "S1".parse().unwrap();
        let judge = Judge::new(&SimulatedObserver::guess(), &set, 1, &subject, 1).unwrap();
        let trials = plan(&protocol.design, 9, &set.practice, 4);
        assert_eq!(Some(trials[0].side(judge.answer(&trials[0]).0)), trials[0].better);
        let again = Judge::new(&SimulatedObserver::guess(), &set, 1, &subject, 1).unwrap();
        assert!(trials.iter().rev().all(|trial| judge.answer(trial) == again.answer(trial)));
    }
}
