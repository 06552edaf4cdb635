//! What is about to be asked: a protocol with its stimuli and its study, and how the display shows them.

use super::operator::Offer;
use super::shell::Shell;
use crate::design::DesignReport;
use crate::display::check::{Angle, DisplayCheck};
use crate::display::{arrangement, is_side_by_side};
use crate::record::participants::PARTICIPANT;
use crate::record::study::Study;
use crate::run::{Entry, RunError, SessionRequest, Sitting};
use crate::session::Viewing;
use crate::stimuli_set::StimulusSet;
use shutterlab_data_schema::DisplayProfile;
use shutterlab_data_schema::display::StereoMode;
use shutterlab_data_schema::protocol::Protocol;
use shutterlab_data_schema::response::{Clock, Resampling};
use std::sync::Arc;

/// What the operator is offered.
pub(super) fn offer(request: &SessionRequest) -> Offer {
    let opened = StimulusSet::open(&request.protocol, &request.stimuli);
    Offer {
        name: request.protocol.name.clone(),
        title: request.protocol.title.clone(),
        obstacle: opened.err().map(|error| error.to_string()),
    }
}

/// One protocol with its stimuli and its study.
pub(super) struct Experiment<'a> {
    pub request: &'a SessionRequest,
    pub set: Arc<StimulusSet>,
    pub study: Study,
    /// What awaits the participant.
    pub report: DesignReport,
    /// The session, if the participant was given and is known.
    pub sitting: Option<Sitting>,
    pub viewing: Option<Viewing>,
}

impl<'a> Experiment<'a> {
    /// What is wrong with stimuli or study is better said now than to the participant.
    pub(super) fn open(request: &'a SessionRequest) -> Result<Self, RunError> {
        let set = Arc::new(StimulusSet::open(&request.protocol, &request.stimuli)?);
        set.verify()?;
        let study = request.study(PARTICIPANT)?;
        let report = request.design_of(&set)?;
        let known = match &request.participant {
            Some(subject) => study.find(subject)?.map(|_| subject),
            None => None,
        };
        let sitting = known
            .map(|subject| Sitting::open(request, set.clone(), &Entry::person(subject)))
            .transpose()?;
        Ok(Self { request, set, study, report, sitting, viewing: None })
    }

    pub(super) fn protocol(&self) -> &'a Protocol {
        &self.request.protocol
    }

    pub(super) fn is_stereo(&self) -> bool {
        is_side_by_side(self.set.stimulus(0))
    }

    /// How large the stimuli are to appear.
    pub(super) fn angle(&self) -> Angle {
        let stimulus = self.set.stimulus(0);
        Angle {
            image_width_px: stimulus.image.width_px,
            pixels_per_degree: stimulus.pixels_per_degree,
        }
    }

    /// Takes in what was measured; returns what of it the protocol does not allow.
    pub(super) fn take_check(
        &mut self,
        shell: &Shell,
        profile: &DisplayProfile,
        check: DisplayCheck,
    ) -> Vec<String> {
        let stimulus = self.set.stimulus(0);
        let arrangement = arrangement(stimulus, profile);
        let mixed = if arrangement.mixes() { Resampling::Linear } else { profile.resampling() };
        let mut viewing = Viewing {
            display: shell.display(),
            clock: Clock::Submission,
            pacing: check.pacing,
            refresh_hz: check.refresh_hz,
            profile: profile.name.clone(),
            profile_sha256: profile.sha256.clone(),
            faults: check.faults,
            stereo_mode: arrangement.mode.map_or("mono", StereoMode::name).into(),
            magnification: profile.magnification,
            resampling: mixed,
            pixels_per_degree: profile.pixels_per_degree(stimulus.image.width_px),
        };
        let fps = self.set.fps_shown(self.protocol());
        let refused = viewing.unfit(&self.protocol().presentation, fps);
        self.viewing = Some(viewing);
        refused
    }
}
