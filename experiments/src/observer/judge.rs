//! A simulated observer in one session.
//!
//! From the probability p of the first of the two answers that a model gives, with L(x) = 1 / (1 + exp(−x)):
//!
//! ```text
//! not sure   first: L(ln(p/(1−p)) − τ)     second: L(−ln(p/(1−p)) − τ)     not sure: the rest
//! bias       first: (1 − |b|) first + max(b, 0)     second: (1 − |b|) second + max(−b, 0)
//! lapse      first: λ/2 + (1 − λ) first     second: λ/2 + (1 − λ) second
//!            λ = lapse rate + fatigue · (n − 1)/(N − 1) in trial n of N
//! ```
//!
//! τ is the band in log-odds; with Bradley–Terry worths that is the model of [RaoKupper1967] with
//! θ = exp(τ). Who lapses or follows a bias is never unsure. Practice and catch pairs are obvious: only a
//! lapse makes an answer to a catch pair wrong, nothing one in practice; but who guesses, guesses there, too.

use super::model::{Perception, logistic};
use super::{Habits, Instructed};
use crate::design::{Part, Trial};
use crate::random::{Stream, session_seed};
use shutterlab_data_schema::ParticipantCode;
use shutterlab_data_schema::protocol::Task;
use shutterlab_data_schema::response::Answer;

/// A simulated observer in one session. Answers are keyed by the trial, so a session that was
/// interrupted gets the same ones when it goes on.
#[derive(Clone, Debug)]
pub struct Judge {
    perception: Perception,
    habits: Habits,
    task: Task,
    seed: u64,
    trials: u32,
}

impl Judge {
    pub(super) fn new(
        sort: &Instructed,
        seed: u64,
        subject: &ParticipantCode,
        session: u32,
        trials: u32,
    ) -> Self {
        // Whoever comes for another session is the same person.
        let mut person = Stream::new(session_seed("observer", seed, subject, 0));
        let perception = sort.perception.of_one(sort.habits.spread, &mut person);
        let mut habits = sort.habits;
        if !sort.not_sure {
            habits.not_sure_band = 0.0;
        }
        if sort.task == Task::SameDifferent {
            habits.side_bias = 0.0;
        }
        let seed = session_seed("answers", seed, subject, session);
        Self { perception, habits, task: sort.task, seed, trials }
    }

    /// What the observer answers in `trial`, and after how many seconds: log-normal, whatever the
    /// stimuli.
    pub fn answer(&self, trial: &Trial) -> (Answer, f64) {
        let mut stream = Stream::keyed(self.seed, u64::from(trial.number));
        let draw = stream.uniform();
        let ([first, second], answers) = (self.probabilities(trial), self.answers());
        let answer = if draw < first {
            answers[0]
        } else if self.habits.not_sure_band > 0.0 && draw >= first + second {
            Answer::NotSure
        } else {
            answers[1]
        };
        let times = self.habits.response_s;
        (answer, times.median * (times.log_sd * stream.normal()).exp())
    }

    /// Probabilities of the task's two answers in `trial`: first and second, or same and different. The
    /// rest is that of "not sure".
    pub fn probabilities(&self, trial: &Trial) -> [f64; 2] {
        let guesses = matches!(self.perception, Perception::Guess);
        let obvious = trial.right.filter(|_| trial.part != Part::Test && !guesses);
        let attentive = match obvious {
            Some(right) => self.answers().map(|answer| f64::from(u8::from(answer == right))),
            None => {
                let p = self.perception.first_answer(self.task, trial);
                self.biased(self.decided(p))
            }
        };
        let lapse = if trial.part == Part::Practice { 0.0 } else { self.lapse_rate(trial.number) };
        attentive.map(|p| 0.5 * lapse + (1.0 - lapse) * p)
    }

    fn answers(&self) -> [Answer; 2] {
        match self.task {
            Task::TwoAfc | Task::Matching => [Answer::First, Answer::Second],
            Task::SameDifferent => [Answer::Same, Answer::Different],
        }
    }

    fn decided(&self, p: f64) -> [f64; 2] {
        let band = self.habits.not_sure_band;
        if band == 0.0 {
            return [p, 1.0 - p];
        }
        let log_odds = (p / (1.0 - p)).ln();
        [log_odds, -log_odds].map(|evidence| logistic(evidence - band))
    }

    fn biased(&self, [first, second]: [f64; 2]) -> [f64; 2] {
        let bias = self.habits.side_bias;
        let model = 1.0 - bias.abs();
        [model * first + bias.max(0.0), model * second + (-bias).max(0.0)]
    }

    fn lapse_rate(&self, trial: u32) -> f64 {
        let done = f64::from(trial.saturating_sub(1));
        let last = f64::from(self.trials.saturating_sub(1)).max(1.0);
        self.habits.lapse_rate + self.habits.fatigue * (done / last).min(1.0)
    }
}
