//! The row that an answer becomes.

use super::{Session, Showings};
use crate::design::{Part, Shows};
use crate::playback::Cadence;
use jiff::Timestamp;
use shutterlab_data_schema::ParticipantCode;
use shutterlab_data_schema::protocol::{Presentation, Task, Unfit};
use shutterlab_data_schema::response::{
    Answer, Clock, Pacing, Resampling, Response, Side, TrialKind,
};

/// What every response of a session has in common.
#[derive(Clone, Debug)]
pub struct Identity {
    /// Who answers.
    pub subject: ParticipantCode,
    /// The sitting, from 1.
    pub session: u32,
    /// Name of the computer.
    pub station: String,
    /// `participant`, or `simulated:NAME`.
    pub observer: String,
    /// Kind of the trials that are neither practice nor to catch.
    pub kind: TrialKind,
    /// Whether this is a trial run.
    pub pilot: bool,
    /// How it is seen.
    pub viewing: Viewing,
}

/// How the stimuli are shown, and what is known about the display.
#[derive(Clone, Debug, PartialEq)]
pub struct Viewing {
    /// The display: its name, physical pixels and scale factor.
    pub display: String,
    /// What times are read from.
    pub clock: Clock,
    /// What decides when the next frame is shown.
    pub pacing: Pacing,
    /// Refreshes per second, as measured; none if the display does not pace the program.
    pub refresh_hz: Option<f64>,
    /// Name of the display's profile.
    pub profile: String,
    /// Its hash, if there is a file.
    pub profile_sha256: Option<String>,
    /// What did not pass the check of the display.
    pub faults: Vec<String>,
    /// How the two eyes' images reach the eyes.
    pub stereo_mode: String,
    /// Physical pixels per image pixel.
    pub magnification: f64,
    /// How image pixels become physical ones.
    pub resampling: Resampling,
    /// Image pixels per degree of visual angle, if the profile tells.
    pub pixels_per_degree: Option<f64>,
}

impl Viewing {
    /// A display called `display` of which nothing else is known: pixel for pixel.
    pub fn plain(display: String, clock: Clock, refresh_hz: Option<f64>) -> Self {
        Self {
            display,
            clock,
            pacing: if refresh_hz.is_some() { Pacing::FixedRefresh } else { Pacing::Timer },
            refresh_hz,
            profile: "identity".into(),
            profile_sha256: None,
            faults: vec![],
            stereo_mode: "mono".into(),
            magnification: 1.0,
            resampling: Resampling::None,
            pixels_per_degree: None,
        }
    }

    /// How frames at `fps` fall on this display's refreshes.
    pub fn cadence(&self, fps: f64) -> Cadence {
        Cadence::paced(fps, self.pacing, self.refresh_hz)
    }

    /// Adds to the faults how films of `fps` fit the display's refresh, and says which faults `rules` do
    /// not allow.
    pub fn unfit(&mut self, rules: &Presentation, fps: f64) -> Vec<String> {
        let refresh = match (self.pacing, self.refresh_hz) {
            // The display follows the film.
            (Pacing::VariableRefresh, _) => None,
            (Pacing::FixedRefresh, Some(_)) if self.cadence(fps).is_even() => None,
            (Pacing::FixedRefresh, Some(hz)) => {
                Some(format!("refresh: {hz:.2} Hz is no whole multiple of {fps} frames per second"))
            }
            _ => Some(format!("refresh: unknown, so is whether it fits {fps} frames per second")),
        };
        let mut refused = match rules.display_check {
            Unfit::Refuse => self.faults.clone(),
            Unfit::Stamp => vec![],
        };
        if rules.refresh == Unfit::Refuse {
            refused.extend(refresh.clone());
        }
        self.faults.extend(refresh);
        refused
    }
}

impl Session {
    /// The row of `answer` to the present trial.
    pub(super) fn response(&self, answer: Answer, now_s: f64, utc: Timestamp) -> Option<Response> {
        let trial = self.trial()?;
        let (a, b) = (&self.set.sequences[trial.a].manifest, &self.set.sequences[trial.b].manifest);
        let candidate = match trial.reference {
            Some(Side::B) => &a.stimulus,
            _ => &b.stimulus,
        };
        let simplified = candidate.simplification.as_ref();
        let [shown_a, shown_b] = [Side::A, Side::B].map(|side| self.showings_of(side));
        let reference = (self.protocol.task == Task::Matching).then(|| self.seen.showings[0]);
        let id = |side: Side| self.set.stimulus(trial.stimulus(side)).id.clone();
        let Identity { subject, session, station, observer, kind, pilot, viewing } = &self.identity;
        let cadence = viewing.cadence(self.set.fps_shown(&self.protocol));
        let paced = viewing.pacing == Pacing::FixedRefresh;
        Some(Response {
            study: self.protocol.name.clone(),
            subject: subject.clone(),
            session: *session,
            station: station.clone(),
            block: trial.block,
            trial: trial.number,
            repetition: trial.repetition,
            attempt: self.seen.attempt,
            kind: match trial.part {
                Part::Practice => TrialKind::Practice,
                Part::Catch => TrialKind::Catch,
                Part::Test => *kind,
            },
            observer: observer.clone(),
            task: self.protocol.task,
            question: self.protocol.question.clone(),
            reference: trial.reference.map(id),
            stimulus_a: a.stimulus.id.clone(),
            exemplar_a: a.stimulus.exemplar,
            hash_a: a.sha256.clone(),
            stimulus_b: b.stimulus.id.clone(),
            exemplar_b: b.stimulus.exemplar,
            hash_b: b.sha256.clone(),
            first: trial.first,
            answer,
            selected: trial.selected(answer).map(id),
            correct: trial.right.map(|right| right == answer),
            response_time_s: microseconds(now_s - self.seen.ended_s),
            replays_reference: reference.map(|shown| shown.replays),
            replays_a: shown_a.replays,
            replays_b: shown_b.replays,
            onset_reference_s: reference.map(|shown| microseconds(shown.onset_s)),
            onset_a_s: microseconds(shown_a.onset_s),
            onset_b_s: microseconds(shown_b.onset_s),
            duration_reference_s: reference.map(|shown| microseconds(shown.duration_s)),
            duration_a_s: microseconds(shown_a.duration_s),
            duration_b_s: microseconds(shown_b.duration_s),
            late_frames_reference: reference.map(|shown| shown.faults.late),
            late_frames_a: shown_a.faults.late,
            late_frames_b: shown_b.faults.late,
            dropped_frames_reference: reference.map(|shown| shown.faults.dropped),
            dropped_frames_a: shown_a.faults.dropped,
            dropped_frames_b: shown_b.faults.dropped,
            repeated_frames_reference: reference.map(|shown| shown.faults.repeated),
            repeated_frames_a: shown_a.faults.repeated,
            repeated_frames_b: shown_b.faults.repeated,
            clock: viewing.clock,
            pacing: viewing.pacing,
            refresh_hz: viewing.refresh_hz,
            refreshes_per_frame: paced.then(|| cadence.refreshes_per_frame()),
            display: viewing.display.clone(),
            display_profile: viewing.profile.clone(),
            display_profile_sha256: viewing.profile_sha256.clone(),
            display_faults: Some(viewing.faults.join("; ")).filter(|faults| !faults.is_empty()),
            stereo_mode: viewing.stereo_mode.clone(),
            magnification: viewing.magnification,
            resampling: viewing.resampling,
            eye: self.protocol.timeline.eye,
            pixels_per_degree: a.stimulus.pixels_per_degree,
            viewed_pixels_per_degree: viewing.pixels_per_degree,
            model: candidate.model().map(String::from),
            r: simplified.map(|how| how.r),
            level_of_detail: simplified.map(|how| how.level_of_detail),
            speed_deg_per_s: candidate.speed_deg_per_s,
            pilot: *pilot,
            answered_at: format!("{utc:.6}"),
            program_version: env!("CARGO_PKG_VERSION").into(),
        })
    }

    /// The showings of the stimulus on `side`: as a candidate, where a reference is shown, too.
    fn showings_of(&self, side: Side) -> Showings {
        let Some(trial) = self.trial() else { return Showings::default() };
        let shows = |shows: &Shows| match shows {
            Shows::Middle(shown) | Shows::Left(shown) | Shows::Right(shown) => *shown == side,
            Shows::Both(_) => true,
            Shows::Reference(_) => false,
        };
        let interval = trial.intervals(self.protocol.task).iter().position(shows);
        interval.map_or(Showings::default(), |interval| self.seen.showings[interval])
    }
}

/// `seconds` without the digits that no clock has.
fn microseconds(seconds: f64) -> f64 {
    (seconds * 1e6).round() / 1e6
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_does_not_fit_is_stamped_or_refused_as_the_protocol_says() {
        let stamp = Presentation::default();
        let refuse_refresh = Presentation { refresh: Unfit::Refuse, ..stamp.clone() };
        let refuse_check = Presentation { display_check: Unfit::Refuse, ..stamp.clone() };
        for (hz, rules, stamped, refused) in [
            (Some(59.94), &refuse_refresh, 0, 0),
            (Some(144.0), &stamp, 1, 0),
            (Some(144.0), &refuse_refresh, 1, 1),
            (Some(144.0), &refuse_check, 1, 0),
            (None, &refuse_refresh, 1, 1),
        ] {
            let mut viewing = Viewing::plain("lab".into(), Clock::Submission, hz);
            assert_eq!(viewing.unfit(rules, 30.0).len(), refused, "{hz:?} {rules:?}");
            assert_eq!(viewing.faults.len(), stamped, "{hz:?} {rules:?}");
        }
        let mut viewing = Viewing::plain("lab".into(), Clock::Submission, Some(60.0));
        viewing.faults = vec!["the adapter is in software".into()];
        assert_eq!(viewing.unfit(&refuse_check, 30.0), ["the adapter is in software"]);
    }
}
