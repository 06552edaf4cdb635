//! The window in which people answer. First the operator's pages: which experiment, the check of the
//! display, who it is. Then the participant's: consent, fusion card, instructions, practice, trials,
//! breaks, end.
//!
//! Stimuli are drawn one image pixel to one physical pixel on neutral grey and their code values reach
//! the screen unchanged, unless the display profile asks for something else. Times are read from the
//! monotonic clock when a frame has been submitted. Closing the window at any moment leaves a session
//! that can be continued.

mod asking;
pub mod cards;
pub mod check;
mod experiment;
mod frames;
mod fusion;
mod operator;
mod pages;
pub mod shell;

use crate::display::check::SESSION_FRAMES;
use crate::run::{Entry, Outcome, RunError, SessionRequest, Sitting};
use asking::Asking;
use check::Checking;
use experiment::{Experiment, offer};
use frames::{Draw, FrameView};
use fusion::Fusion;
use jiff::Timestamp;
use operator::{Form, Offer};
use pages::Action;
use shell::{App, Next, Shell};
use shutterlab_data_schema::protocol::{Protocol, Unfit};
use shutterlab_data_schema::{DisplayProfile, ParticipantCode};
use std::time::Instant;
use winit::keyboard::{Key, NamedKey};

/// Runs the session of a participant in a window, from where it is to its end or until the window is
/// closed. If there are several requests, the operator chooses. A session that is finished is left as it
/// is, and no window opens.
///
/// Must be called from the main thread, once per process.
///
/// # Errors
/// See [`RunError`]. Answers given before the error are saved; running again goes on after them.
pub fn run(requests: &[SessionRequest], profile: &DisplayProfile) -> Result<Outcome, RunError> {
    let mut asker = Asker {
        requests,
        profile,
        experiment: None,
        stage: Stage::Choosing(vec![]),
        view: None,
        keys: vec![],
        actions: vec![],
    };
    if let [request] = requests {
        let mut experiment = Experiment::open(request)?;
        if experiment.sitting.as_ref().is_some_and(|sitting| sitting.is_finished())
            && let Some(mut sitting) = experiment.sitting.take()
        {
            return Ok(sitting.close()?);
        }
        asker.choose(experiment);
    } else {
        asker.stage = Stage::Choosing(requests.iter().map(offer).collect());
    }
    let ended = shell::run(&asker.title(), profile, &mut asker);
    if let Stage::Leaving(stage) = asker.stage {
        asker.stage = *stage;
    }
    if let Stage::Refused(why) = &asker.stage {
        return ended.and(Err(RunError::Unfit(why.join("; "))));
    }
    let sitting = match asker.stage {
        Stage::Asking(asking) => Some(asking.sitting),
        Stage::Known(sitting) | Stage::Resume(sitting) => Some(*sitting),
        Stage::Fusion(fusion) => Some(*fusion.sitting),
        _ => asker.experiment.and_then(|experiment| experiment.sitting),
    };
    let closed = match sitting {
        Some(mut sitting) => Ok(sitting.close()?),
        None => Err(RunError::Cancelled),
    };
    ended.and(closed)
}

/// The session in its window.
struct Asker<'a> {
    requests: &'a [SessionRequest],
    profile: &'a DisplayProfile,
    experiment: Option<Experiment<'a>>,
    stage: Stage,
    /// Draws the photodiode's patch during the check.
    view: Option<FrameView>,
    /// Keys that were pressed and when. What each means is known once those before it are done.
    keys: Vec<(Key, Instant)>,
    /// What was asked for with buttons and when.
    actions: Vec<(Action, Instant)>,
}

enum Stage {
    /// Which experiment?
    Choosing(Vec<Offer>),
    /// How does the display take frames?
    Checking(Checking),
    /// The display does not fit.
    Refused(Vec<String>),
    /// Who is it?
    Form(Form),
    /// The participant is known; go on with that session?
    Resume(Box<Sitting>),
    /// Does the participant agree?
    Consent(Entry),
    /// Do the two eyes' images reach the eyes?
    Fusion(Box<Fusion>),
    /// Does the participant want to leave before the session?
    Leaving(Box<Stage>),
    /// The session is about to begin.
    Known(Box<Sitting>),
    /// The session runs.
    Asking(Box<Asking>),
}

impl App for Asker<'_> {
    type Error = RunError;

    fn start(&mut self, shell: &mut Shell) -> Result<(), RunError> {
        pages::set_style(shell.egui());
        Ok(())
    }

    fn key(&mut self, key: &Key, at: Instant) -> bool {
        // Where the keys go has to be known before the next one comes.
        if let Some(action @ (Action::Focus(_) | Action::Option(_))) = self.meaning(key) {
            self.move_in_form(action);
            return true;
        }
        // What the form has no use for is typed into it. Nothing else may also press a button.
        let is_ours = !matches!(key, Key::Named(NamedKey::PageUp | NamedKey::PageDown))
            && (!matches!(self.stage, Stage::Form(_)) || self.meaning(key).is_some());
        if is_ours {
            self.keys.push((key.clone(), at));
        }
        is_ours
    }

    fn redraw(&mut self, shell: &mut Shell) -> Result<Next, RunError> {
        let keys = std::mem::take(&mut self.keys);
        if !keys.is_empty() && matches!(self.stage, Stage::Form(_)) {
            // Enter may have come in one go with the last letters: let the page take those first.
            self.draw_page(shell)?;
        }
        for (action, at) in std::mem::take(&mut self.actions) {
            if self.act(action, at, shell)? == Next::Exit {
                return Ok(Next::Exit);
            }
        }
        for (key, at) in keys {
            if let Some(action) = self.meaning(&key)
                && self.act(action, at, shell)? == Next::Exit
            {
                return Ok(Next::Exit);
            }
            if let Stage::Known(_) = self.stage {
                self.begin(shell);
            }
        }
        if let Stage::Known(_) = self.stage {
            self.begin(shell);
        }
        let next = match &mut self.stage {
            Stage::Asking(asking) => asking.draw(shell, &mut self.actions)?,
            Stage::Checking(_) => self.check(shell)?,
            _ => self.draw_page(shell)?,
        };
        // A button was pressed: do what it says at once.
        Ok(if self.actions.is_empty() { next } else { Next::At(Instant::now()) })
    }
}

impl<'a> Asker<'a> {
    fn title(&self) -> String {
        match &self.experiment {
            Some(experiment) => format!("Shutterlab – {}", experiment.protocol().title),
            None => "Shutterlab".into(),
        }
    }

    /// What `key` means now.
    fn meaning(&self, key: &Key) -> Option<Action> {
        match &self.stage {
            Stage::Asking(asking) => asking.meaning(key),
            other => meaning(other, key),
        }
    }

    fn choose(&mut self, experiment: Experiment<'a>) {
        self.experiment = Some(experiment);
        self.stage = Stage::Checking(Checking::new(SESSION_FRAMES));
    }

    /// Draws a page of the operator's or the participant's before the session.
    fn draw_page(&mut self, shell: &mut Shell) -> Result<Next, RunError> {
        let pilot = self.requests.iter().any(|request| request.pilot);
        let (stage, actions) = (&mut self.stage, &mut self.actions);
        let experiment = self.experiment.as_ref();
        let protocol = experiment.map(Experiment::protocol);
        let mut page = |ui: &mut egui::Ui, action: Option<Action>| {
            actions.extend(now(action));
            if pilot {
                pages::pilot_banner(ui);
            }
        };
        match (stage, protocol) {
            (Stage::Fusion(fusion), Some(protocol)) => {
                let draw = Draw { sequence: 0, frame: 0, centre: [0, 0] };
                shell.draw(
                    |pass, number, window_px| fusion.view.paint(pass, number, window_px, &[draw]),
                    |ui| {
                        pages::caption(ui, &protocol.words.fusion);
                        page(ui, None);
                    },
                )?;
            }
            (stage, protocol) => {
                let faults = experiment.and_then(|e| e.viewing.as_ref());
                let faults = faults.map_or(&[][..], |viewing| viewing.faults.as_slice());
                let summary = experiment.map(|e| e.report.to_string()).unwrap_or_default();
                shell.draw(
                    |_, _, _| {},
                    |ui| {
                        let action = before(ui, stage, protocol, &summary, faults);
                        page(ui, action);
                    },
                )?;
            }
        }
        Ok(Next::OnEvent)
    }

    /// Goes on with the check of the display, and judges at its end.
    fn check(&mut self, shell: &mut Shell) -> Result<Next, RunError> {
        let Stage::Checking(checking) = &mut self.stage else { return Ok(Next::OnEvent) };
        let view = self.view.get_or_insert_with(|| FrameView::new(shell, self.profile));
        if let Some(next) = checking.redraw(shell, view, "The display is being checked.")? {
            return Ok(next);
        }
        let Some(experiment) = &mut self.experiment else { return Ok(Next::Exit) };
        let check = checking.judge(shell, self.profile, Some(experiment.angle()));
        let refused = experiment.take_check(shell, self.profile, check);
        let sitting = experiment.sitting.take();
        self.stage = match sitting {
            _ if !refused.is_empty() => Stage::Refused(refused),
            Some(sitting) => Stage::Resume(Box::new(sitting)),
            None => {
                let code = experiment.request.participant.as_ref();
                let code = code.map_or(String::new(), ToString::to_string);
                let fields = &experiment.protocol().participant;
                if !code.is_empty() && fields.is_empty() {
                    self.actions.push((Action::Submit, Instant::now()));
                }
                Stage::Form(Form::new(fields, code))
            }
        };
        Ok(Next::At(Instant::now()))
    }

    fn act(&mut self, action: Action, at: Instant, shell: &Shell) -> Result<Next, RunError> {
        match (&mut self.stage, action) {
            // Back to the form; the session that was found is let go.
            (Stage::Resume(sitting), Action::Stay) => {
                sitting.close()?;
                self.stage = self.empty_form();
            }
            (_, Action::Leave) => return Ok(Next::Exit),
            (Stage::Leaving(_), Action::Stay) => {
                if let Stage::Leaving(stage) = self.take_stage() {
                    self.stage = *stage;
                }
            }
            (_, Action::AskToLeave) => self.stage = Stage::Leaving(Box::new(self.take_stage())),
            (Stage::Choosing(offers), Action::Choose(place)) => {
                let request = self.requests.get(place);
                if let (Some(offer), Some(request)) = (offers.get_mut(place), request)
                    && offer.obstacle.is_none()
                {
                    match Experiment::open(request) {
                        Ok(experiment) => self.choose(experiment),
                        Err(error) => offer.obstacle = Some(error.to_string()),
                    }
                }
            }
            (Stage::Form(_), Action::Submit) => self.submit_form(shell),
            (Stage::Resume(_), Action::Submit) => {
                if let Stage::Resume(sitting) = self.take_stage() {
                    self.stage = self.before_session(sitting, shell);
                }
            }
            (Stage::Consent(_), Action::Submit) => {
                if let Stage::Consent(entry) = self.take_stage() {
                    self.enter(Entry { consented_at: Some(Timestamp::now()), ..entry }, shell);
                }
            }
            (Stage::Fusion(_), Action::Choose(place)) => self.read_card(place, shell),
            (Stage::Asking(asking), action) => asking.act(action, at),
            _ => {}
        }
        Ok(Next::OnEvent)
    }

    fn move_in_form(&mut self, action: Action) {
        let fields = self.experiment.as_ref().map_or(&[][..], |e| &e.protocol().participant);
        if let Stage::Form(form) = &mut self.stage {
            match action {
                Action::Focus(by) => form.move_focus(by),
                Action::Option(by) => form.move_choice(fields, by),
                _ => {}
            }
        }
    }

    fn empty_form(&self) -> Stage {
        let fields = self.experiment.as_ref().map(|e| &e.protocol().participant);
        Stage::Form(Form::new(fields.map_or(&[][..], Vec::as_slice), String::new()))
    }

    /// The stage, with an empty form in its place.
    fn take_stage(&mut self) -> Stage {
        let empty = self.empty_form();
        std::mem::replace(&mut self.stage, empty)
    }

    /// Takes the form in: a known participant goes on, a new one is asked for consent or entered.
    fn submit_form(&mut self, shell: &Shell) {
        let (Stage::Form(form), Some(experiment)) = (&mut self.stage, &self.experiment) else {
            return;
        };
        match submitted(form, experiment) {
            Ok(Submitted::Known(sitting)) => self.stage = Stage::Resume(sitting),
            Ok(Submitted::New(entry)) if experiment.protocol().text.consent.is_some() => {
                self.stage = Stage::Consent(entry);
            }
            Ok(Submitted::New(entry)) => self.enter(entry, shell),
            Err(problem) => form.problem = Some(problem),
        }
    }

    /// Enters a new participant and opens the session.
    fn enter(&mut self, entry: Entry, shell: &Shell) {
        let Some(experiment) = &self.experiment else { return };
        self.stage = match Sitting::open(experiment.request, experiment.set.clone(), &entry) {
            Ok(sitting) => self.before_session(Box::new(sitting), shell),
            Err(error) => {
                let mut form =
                    Form::new(&experiment.protocol().participant, entry.subject.to_string());
                form.problem = Some(error.to_string());
                Stage::Form(form)
            }
        };
    }

    /// The fusion card, if there is something to fuse; then the session.
    fn before_session(&self, sitting: Box<Sitting>, shell: &Shell) -> Stage {
        if !self.experiment.as_ref().is_some_and(Experiment::is_stereo) {
            return Stage::Known(sitting);
        }
        Stage::Fusion(Box::new(Fusion::new(sitting, self.profile, shell)))
    }

    /// Takes what was read from the fusion card.
    fn read_card(&mut self, place: usize, shell: &Shell) {
        let Stage::Fusion(fusion) = &mut self.stage else { return };
        let Some(is_read) = fusion.read(place, shell) else { return };
        let Stage::Fusion(fusion) = self.take_stage() else { return };
        self.stage = Stage::Known(fusion.sitting);
        if is_read {
            return;
        }
        let fault = "fusion card: not read".to_string();
        let Some(experiment) = &mut self.experiment else { return };
        if experiment.protocol().presentation.display_check == Unfit::Refuse {
            if let Stage::Known(sitting) =
                std::mem::replace(&mut self.stage, Stage::Refused(vec![fault]))
            {
                experiment.sitting = Some(*sitting);
            }
        } else if let Some(viewing) = &mut experiment.viewing {
            viewing.faults.push(fault);
        }
    }

    /// Begins the session that is known.
    fn begin(&mut self, shell: &Shell) {
        if let Some(viewing) = self.experiment.as_ref().and_then(|e| e.viewing.clone())
            && let Stage::Known(sitting) = self.take_stage()
        {
            let pilot = self.requests.iter().any(|request| request.pilot);
            let asking = Asking::new(*sitting, viewing, self.profile, pilot, shell);
            self.stage = Stage::Asking(Box::new(asking));
        }
    }
}

/// Who is in the form.
enum Submitted {
    /// Somebody who has a session already.
    Known(Box<Sitting>),
    /// Somebody new.
    New(Entry),
}

/// Reads the form; an error says what is to be mended in it.
fn submitted(form: &mut Form, experiment: &Experiment<'_>) -> Result<Submitted, String> {
    let text = |error: &dyn std::fmt::Display| error.to_string();
    let subject: ParticipantCode = form.code.parse().map_err(|e| text(&e))?;
    if experiment.study.find(&subject).map_err(|e| text(&e))?.is_none() {
        let fields = form.answers(&experiment.protocol().participant)?;
        return Ok(Submitted::New(Entry { fields, ..Entry::person(&subject) }));
    }
    let entry = Entry::person(&subject);
    let sitting = Sitting::open(experiment.request, experiment.set.clone(), &entry);
    let mut sitting = sitting.map_err(|e| text(&e))?;
    if sitting.is_finished() {
        sitting.close().map_err(|e| text(&e))?;
        return Err(format!("The session of {subject} is already finished."));
    }
    Ok(Submitted::Known(Box::new(sitting)))
}

/// Draws a page that is only words and fields.
fn before(
    ui: &mut egui::Ui,
    stage: &mut Stage,
    protocol: Option<&Protocol>,
    summary: &str,
    faults: &[String],
) -> Option<Action> {
    match (stage, protocol) {
        (Stage::Choosing(offers), _) => operator::choose(ui, offers),
        (Stage::Refused(why), _) => operator::refused(ui, why),
        (Stage::Form(form), Some(protocol)) => {
            operator::form(ui, form, &protocol.participant, summary, faults)
        }
        (Stage::Resume(sitting), _) => operator::resume(ui, &sitting.outcome()),
        (Stage::Leaving(_), Some(protocol)) => pages::leaving(ui, &protocol.words, None),
        (Stage::Consent(_), Some(protocol)) => {
            let text = protocol.text.consent.as_deref().unwrap_or_default();
            pages::consent(ui, text, &protocol.words)
        }
        _ => None,
    }
}

/// What a key means before the session.
fn meaning(stage: &Stage, key: &Key) -> Option<Action> {
    use NamedKey::{ArrowDown, ArrowLeft, ArrowRight, ArrowUp, Enter, Escape, Tab};
    match (stage, key.as_ref()) {
        (Stage::Checking(_), _) => None,
        (Stage::Choosing(offers), Key::Character(key)) => {
            let number = operator::KEYS.find(&key.to_lowercase())?;
            operator::open(offers).map(|(place, _)| Action::Choose(place)).nth(number)
        }
        (Stage::Form(_), Key::Named(ArrowUp)) => Some(Action::Focus(-1)),
        (Stage::Form(_), Key::Named(ArrowDown | Tab)) => Some(Action::Focus(1)),
        (Stage::Form(form), Key::Named(ArrowLeft)) if !form.is_in_code() => {
            Some(Action::Option(-1))
        }
        (Stage::Form(form), Key::Named(ArrowRight)) if !form.is_in_code() => {
            Some(Action::Option(1))
        }
        (Stage::Form(_) | Stage::Resume(_), Key::Named(Enter)) => Some(Action::Submit),
        (Stage::Resume(_), Key::Named(Escape)) => Some(Action::Stay),
        (Stage::Consent(_), Key::Character("y" | "Y")) => Some(Action::Submit),
        (Stage::Consent(_), Key::Character("n" | "N")) => Some(Action::Leave),
        (Stage::Fusion(_), Key::Named(ArrowUp)) => Some(Action::Choose(0)),
        (Stage::Fusion(_), Key::Named(ArrowDown)) => Some(Action::Choose(1)),
        (Stage::Fusion(_), Key::Named(ArrowLeft)) => Some(Action::Choose(2)),
        (Stage::Fusion(_), Key::Named(ArrowRight)) => Some(Action::Choose(3)),
        (Stage::Consent(_) | Stage::Fusion(_), Key::Named(Escape)) => Some(Action::AskToLeave),
        (Stage::Leaving(_), Key::Named(Enter | Escape)) => Some(Action::Stay),
        (Stage::Leaving(_), Key::Character("l" | "L")) => Some(Action::Leave),
        (Stage::Refused(_), Key::Named(Enter)) | (_, Key::Named(Escape)) => Some(Action::Leave),
        _ => None,
    }
}

/// `action` as asked for at this moment.
fn now(action: Option<Action>) -> Option<(Action, Instant)> {
    action.map(|action| (action, Instant::now()))
}
