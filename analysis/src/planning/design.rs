//! What is asked and what is assumed.

use crate::error::InputError;
use crate::outcome::Outcome;
use serde::{Serialize, Serializer};
use shutterlab_data_schema::protocol::Task;

/// What a protocol asks of each observer.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Design {
    /// The task.
    pub task: Task,
    /// The stimuli: axes and levels of each, all with the same axes. In JSON their names.
    #[serde(serialize_with = "names")]
    pub stimuli: Vec<Vec<(String, String)>>,
    /// The pairs, each once, without practice and catch trials.
    pub pairs: Vec<AskedPair>,
    /// How long a session takes, in minutes.
    pub minutes: f64,
}

/// A pair of stimuli.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct AskedPair {
    /// Place of one among the stimuli.
    pub a: usize,
    /// Place of the other; the same place for a pair of identical stimuli.
    pub b: usize,
    /// How often each observer judges it.
    pub times: u64,
}

/// Two levels of an axis that are compared.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
pub struct Comparison {
    /// The axis.
    pub axis: String,
    /// The levels.
    pub levels: [String; 2],
}

/// What a plan assumes.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Assumptions {
    /// Numbers of observers, ascending.
    pub observers: Vec<u64>,
    /// Level of significance.
    pub alpha: f64,
    /// The preference, or share of right answers, that should be found.
    pub effect: f64,
    /// The preference for each stimulus over the next in the order of the design, if `worths` are not given.
    pub step: f64,
    /// Logarithms of the Bradley–Terry worths of the stimuli for the typical observer.
    pub worths: Option<Vec<f64>>,
    /// Standard deviation between observers of the log-worth of each stimulus, or of the log-odds of a right
    /// answer.
    pub spread: f64,
    /// Number of simulated studies.
    pub studies: u64,
    /// Seed of the simulation.
    pub seed: u64,
}

impl Default for Assumptions {
    fn default() -> Self {
        Self {
            observers: vec![5, 10, 15, 20, 24, 30, 40, 60],
            alpha: 0.01,
            effect: 0.7,
            step: 0.6,
            worths: None,
            spread: 0.5,
            studies: 1000,
            seed: 1,
        }
    }
}

impl Assumptions {
    /// Refuses numbers out of range.
    pub(super) fn check(&self, design: &Design) -> Result<(), InputError> {
        let within = |name: &str, value: f64, range: [f64; 2]| match value {
            v if v >= range[0] && v <= range[1] => Ok(()),
            v => Err(refused(name, v, format!("{} to {} are allowed", range[0], range[1]))),
        };
        within("--alpha", self.alpha, [1e-6, 0.5])?;
        within("--effect", self.effect, [0.51, 0.99])?;
        within("--step", self.step, [0.5, 0.99])?;
        within("--spread", self.spread, [0.0, 5.0])?;
        within("--studies", self.studies as f64, [1.0, 1e6])?;
        if self.observers.is_empty() || !self.observers.is_sorted() {
            let found = format!("{:?}", self.observers);
            return Err(refused("--observers", found, "ascending numbers are needed"));
        }
        for observers in &self.observers {
            within("--observers", *observers as f64, [1.0, 1000.0])?;
        }
        match &self.worths {
            Some(worths) if worths.len() != design.stimuli.len() => {
                let allowed = format!("one for each of {} stimuli", design.stimuli.len());
                Err(refused("--worths", worths.len(), allowed))
            }
            Some(worths) => {
                worths.iter().try_for_each(|worth| within("ln worth", *worth, [-50.0, 50.0]))
            }
            None => Ok(()),
        }
    }

    /// The true shares at which power is told.
    pub(super) fn shares(&self) -> Vec<f64> {
        let mut shares = vec![0.6, 0.7, 0.75, 0.8];
        if !shares.contains(&self.effect) {
            shares.push(self.effect);
            shares.sort_by(f64::total_cmp);
        }
        shares
    }

    /// The log-worths of the stimuli: as given; or a step from each to the next; or, where only stimuli that
    /// differ in one axis are compared, a step from each level to the next on every axis.
    pub(super) fn log_worths(&self, design: &Design) -> Vec<f64> {
        let step = libm::log(self.step / (1.0 - self.step));
        match &self.worths {
            Some(worths) => worths.clone(),
            None if design.complete().is_ok() => {
                (0..design.stimuli.len()).map(|place| -step * place as f64).collect()
            }
            None => {
                let levels: Vec<Vec<&String>> = (0..design.axes())
                    .map(|axis| {
                        let mut levels: Vec<&String> = Vec::new();
                        for stimulus in &design.stimuli {
                            if !levels.contains(&&stimulus[axis].1) {
                                levels.push(&stimulus[axis].1);
                            }
                        }
                        levels
                    })
                    .collect();
                let place = |axis: usize, level: &String| {
                    levels[axis].iter().position(|other| *other == level).unwrap_or(0)
                };
                let places = |stimulus: &Vec<(String, String)>| -> usize {
                    stimulus.iter().enumerate().map(|(axis, (_, level))| place(axis, level)).sum()
                };
                design.stimuli.iter().map(|stimulus| -step * places(stimulus) as f64).collect()
            }
        }
    }
}

impl Design {
    /// Refuses a design that asks nothing or about stimuli that are not there.
    pub(super) fn check(&self) -> Result<(), InputError> {
        let axes = self.axes();
        if self.stimuli.len() < 2 || self.stimuli.iter().any(|stimulus| stimulus.len() != axes) {
            let allowed = "at least two with the same axes are needed";
            return Err(refused("stimuli", self.stimuli.len(), allowed));
        }
        let is_there = |pair: &AskedPair| pair.a.max(pair.b) < self.stimuli.len() && pair.times > 0;
        if self.answers() == 0 || !self.pairs.iter().all(is_there) {
            return Err(refused("pairs", self.pairs.len(), "pairs of the stimuli are needed"));
        }
        Ok(())
    }

    fn axes(&self) -> usize {
        self.stimuli.first().map_or(0, Vec::len)
    }

    /// Answers of each observer.
    pub fn answers(&self) -> u64 {
        self.pairs.iter().map(|pair| pair.times).sum()
    }

    /// How often each observer judges a pair of different stimuli.
    ///
    /// # Errors
    /// Says that it is not the same for all.
    pub fn times(&self) -> Outcome<u64> {
        let mut times = self.pairs.iter().filter(|pair| pair.a != pair.b).map(|pair| pair.times);
        match times.next() {
            Some(first) if times.all(|other| other == first) => Ok(first),
            Some(_) => Err("some pairs are judged more often than others".into()),
            None => Err("no two different stimuli are compared".into()),
        }
    }

    /// How often each observer judges every pair of all stimuli.
    ///
    /// # Errors
    /// Says that not every pair is judged, or not equally often.
    pub fn complete(&self) -> Outcome<u64> {
        let t = self.stimuli.len();
        let different = self.pairs.iter().filter(|pair| pair.a != pair.b).count();
        if different < t * (t - 1) / 2 {
            return Err(format!(
                "scores, ζ and u need every pair of stimuli: {different} of {} are asked",
                t * (t - 1) / 2
            ));
        }
        self.times()
    }

    /// The comparisons of two levels of an axis, over the pairs that differ in nothing else, by how many
    /// answers each observer gives to them.
    ///
    /// # Errors
    /// Says that no such comparison has more than one pair.
    pub fn comparisons(&self) -> Outcome<Vec<(u64, Vec<Comparison>)>> {
        let mut counted: Vec<(Comparison, u64, usize)> = Vec::new();
        for AskedPair { a, b, times } in &self.pairs {
            let both = self.stimuli[*a].iter().zip(&self.stimuli[*b]);
            let differing: Vec<_> = both.filter(|(one, other)| one.1 != other.1).collect();
            let [(one, other)] = differing[..] else { continue };
            let mut levels = [one.1.clone(), other.1.clone()];
            levels.sort();
            let comparison = Comparison { axis: one.0.clone(), levels };
            match counted.iter_mut().find(|(there, ..)| *there == comparison) {
                Some((_, answers, pairs)) => (*answers, *pairs) = (*answers + times, *pairs + 1),
                None => counted.push((comparison, *times, 1)),
            }
        }
        counted.sort();
        let mut groups: Vec<(u64, Vec<Comparison>)> = Vec::new();
        for (comparison, answers, _) in counted.into_iter().filter(|(_, _, pairs)| *pairs > 1) {
            match groups.iter_mut().find(|(there, _)| *there == answers) {
                Some((_, group)) => group.push(comparison),
                None => groups.push((answers, vec![comparison])),
            }
        }
        match groups.is_empty() {
            true => Err("no two levels of an axis are compared in more than one pair".into()),
            false => Ok(groups),
        }
    }

    /// Name of a stimulus: its levels.
    pub fn name(&self, place: usize) -> String {
        self.stimuli.get(place).map_or(String::new(), |levels| name(levels))
    }
}

fn name(levels: &[(String, String)]) -> String {
    levels.iter().map(|(_, level)| level.as_str()).collect::<Vec<_>>().join("-")
}

fn names<S: Serializer>(
    stimuli: &[Vec<(String, String)>],
    serializer: S,
) -> Result<S::Ok, S::Error> {
    serializer.collect_seq(stimuli.iter().map(|levels| name(levels)))
}

fn refused(name: &str, value: impl ToString, allowed: impl Into<String>) -> InputError {
    InputError::value("plan", name, value, allowed)
}
