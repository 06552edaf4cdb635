//! The window in which people answer: code, instructions, practice, trials, breaks, end.
//!
//! Stimuli are drawn one image pixel to one physical pixel on neutral grey; their code values reach
//! the screen unchanged. Times are read from the monotonic clock when a frame has been submitted.
//! Closing the window at any moment leaves a session that can be continued.

mod frames;
mod pages;
pub mod shell;

use crate::presenter::{Presenter, show};
use crate::record::RecordError;
use crate::record::study::{PARTICIPANT, Study};
use crate::run::{Outcome, RunError, SessionRequest, Sitting};
use crate::session::{Input, Progress, Screen, Session};
use crate::stimuli_set::StimulusSet;
use frames::{FrameView, Loader};
use jiff::Timestamp;
use pages::Action;
use shell::{App, Next, Shell, ShellError};
use shutterlab_data_schema::response::{Answer, Clock};
use shutterlab_data_schema::{ParticipantCode, Protocol};
use std::sync::Arc;
use std::time::{Duration, Instant};
use winit::keyboard::{Key, NamedKey};

/// Runs the session of a participant in a window, from where it is to its end or until the window is
/// closed. A session that is finished is left as it is, and no window opens.
///
/// Must be called from the main thread, once per process.
///
/// # Errors
/// See [`RunError`]. Answers given before the error are saved; running again goes on after them.
pub fn run(request: &SessionRequest) -> Result<Outcome, RunError> {
    let set = Arc::new(StimulusSet::open(&request.protocol, &request.stimuli)?);
    set.verify()?;
    let stage = match &request.participant {
        Some(subject) => {
            let mut sitting = Sitting::open(request, set.clone(), subject, PARTICIPANT)?;
            if sitting.is_finished() {
                return Ok(sitting.close()?);
            }
            Stage::Known(Box::new(sitting))
        }
        // What is wrong with the study is better said now than to the participant.
        None => {
            Study::open(&request.study, &request.protocol, request.pilot)?;
            Stage::Code { text: String::new(), problem: None }
        }
    };
    let mut asker = Asker { request, set, stage, actions: vec![] };
    let ended = shell::run(&format!("Shutterlab – {}", request.protocol.title), &mut asker);
    let closed = match asker.stage {
        Stage::Code { .. } => Err(RunError::Cancelled),
        Stage::Known(mut sitting) => Ok(sitting.close()?),
        Stage::Asking(mut asking) => Ok(asking.sitting.close()?),
    };
    ended.and(closed)
}

/// The session in its window.
struct Asker<'a> {
    request: &'a SessionRequest,
    set: Arc<StimulusSet>,
    stage: Stage,
    /// What was asked for and when.
    actions: Vec<(Action, Instant)>,
}

enum Stage {
    /// Who is it?
    Code { text: String, problem: Option<String> },
    /// We know who, but the window is not there yet.
    Known(Box<Sitting>),
    /// The session runs.
    Asking(Box<Asking>),
}

struct Asking {
    sitting: Sitting,
    session: Session,
    opened: Instant,
    loader: Loader,
    view: FrameView,
    overlay: Option<Overlay>,
}

/// What is in front of the session.
enum Overlay {
    /// Does the participant really want to leave?
    Leaving,
    /// Something failed that can be tried again.
    Problem(String),
}

/// How long to wait before looking again whether a trial's frames are there.
const LOADING_POLL: Duration = Duration::from_millis(10);

/// Shortest time between two redraws, so that a window that cannot be seen does not keep a core busy.
const SHORTEST_WAIT: Duration = Duration::from_millis(1);

impl App for Asker<'_> {
    type Error = RunError;

    fn start(&mut self, shell: &mut Shell) -> Result<(), RunError> {
        pages::set_style(shell.egui());
        self.begin_if_known(shell);
        Ok(())
    }

    fn key(&mut self, key: &Key) -> bool {
        let action = match &self.stage {
            Stage::Code { .. } | Stage::Known(_) => match key {
                Key::Named(NamedKey::Enter) => Some(Action::Submit),
                Key::Named(NamedKey::Escape) => Some(Action::Leave),
                _ => None,
            },
            Stage::Asking(asking) => match &asking.overlay {
                Some(overlay) => key_over(overlay, key),
                None => key_in_session(key),
            },
        };
        self.actions.extend(action.map(|action| (action, Instant::now())));
        // A key that means something goes no further, lest it also press a button.
        action.is_some()
    }

    fn redraw(&mut self, shell: &mut Shell) -> Result<Next, RunError> {
        let asked = std::mem::take(&mut self.actions);
        if !asked.is_empty() {
            // Enter may have come in one go with the last letters: let the page take those first.
            self.draw_code(shell)?;
        }
        for (action, at) in asked {
            if self.act(action, at, shell) == Next::Exit {
                return Ok(Next::Exit);
            }
        }
        let next = match &mut self.stage {
            Stage::Asking(asking) => {
                asking.work(shell);
                asking.draw(shell, &self.request.protocol, self.request.pilot, &mut self.actions)?
            }
            Stage::Code { .. } => {
                self.draw_code(shell)?;
                Next::OnEvent
            }
            Stage::Known(_) => Next::OnEvent,
        };
        // A button was pressed: do what it says at once.
        Ok(if self.actions.is_empty() { next } else { Next::At(Instant::now()) })
    }
}

impl Asker<'_> {
    /// Draws the page that asks for the code, if that is where the session is.
    fn draw_code(&mut self, shell: &mut Shell) -> Result<(), RunError> {
        let Stage::Code { text, problem } = &mut self.stage else { return Ok(()) };
        let (pilot, actions) = (self.request.pilot, &mut self.actions);
        shell.draw(
            grey(),
            |_| {},
            |ui| {
                actions.extend(now(pages::code(ui, text, problem.as_deref())));
                if pilot {
                    pages::pilot_banner(ui);
                }
            },
        )?;
        Ok(())
    }

    fn act(&mut self, action: Action, at: Instant, shell: &Shell) -> Next {
        match (&mut self.stage, action) {
            (_, Action::Leave) => return Next::Exit,
            (Stage::Code { .. }, Action::Submit) => {
                self.submit_code();
                self.begin_if_known(shell);
            }
            (Stage::Asking(asking), Action::Session(Input::Interrupt)) => {
                asking.input(Input::Interrupt, at);
                asking.overlay = Some(Overlay::Leaving);
            }
            (Stage::Asking(asking), Action::Session(input)) if asking.overlay.is_none() => {
                asking.input(input, at);
            }
            (Stage::Asking(asking), Action::Stay | Action::Retry) => asking.overlay = None,
            _ => {}
        }
        Next::OnEvent
    }

    fn submit_code(&mut self) {
        let Stage::Code { text, problem } = &mut self.stage else { return };
        let opened = text.parse::<ParticipantCode>().map_err(|error| error.to_string()).and_then(
            |subject| {
                Sitting::open(self.request, self.set.clone(), &subject, PARTICIPANT)
                    .map_err(|error| error.to_string())
            },
        );
        match opened {
            Ok(sitting) if sitting.is_finished() => {
                *problem = Some(format!("The session of {} is already finished.", text.trim()));
            }
            Ok(sitting) => self.stage = Stage::Known(Box::new(sitting)),
            Err(error) => *problem = Some(error),
        }
    }

    fn begin_if_known(&mut self, shell: &Shell) {
        let unknown = Stage::Code { text: String::new(), problem: None };
        self.stage = match std::mem::replace(&mut self.stage, unknown) {
            Stage::Known(sitting) => Stage::Asking(Box::new(Asking::new(*sitting, shell))),
            other => other,
        };
    }
}

impl Asking {
    fn new(sitting: Sitting, shell: &Shell) -> Self {
        let session = sitting.session(shell.display(), Clock::Submission);
        let mut loader = Loader::new(sitting.set.clone());
        if let Some(trial) = session.trial() {
            loader.prefetch(trial);
        }
        let view = FrameView::new(shell);
        Self { sitting, session, opened: Instant::now(), loader, view, overlay: None }
    }

    fn now_s(&self) -> f64 {
        self.opened.elapsed().as_secs_f64()
    }

    fn input(&mut self, input: Input, at: Instant) {
        let at_s = at.saturating_duration_since(self.opened).as_secs_f64();
        self.session.input(input, at_s, Timestamp::now());
    }

    /// Saves an answer that waits to be saved, and begins a trial that waits to begin.
    fn work(&mut self, shell: &Shell) {
        if self.overlay.is_none()
            && let Err(problem) = self.save_and_begin(shell)
        {
            self.overlay = Some(Overlay::Problem(problem));
        }
    }

    fn save_and_begin(&mut self, shell: &Shell) -> Result<(), String> {
        let text = |error: RecordError| error.to_string();
        self.session.save(&mut self.sitting.recorder).map_err(text)?;
        let Some(trial) = self.session.waiting().cloned() else { return Ok(()) };
        if self.view.trial() != Some(trial.number) {
            let Some(decoded) = self.loader.take(&trial)? else { return Ok(()) };
            self.view.upload(shell, decoded);
        }
        if self.is_too_small(shell) {
            return Ok(());
        }
        self.session.begin(self.now_s(), &mut self.sitting.recorder).map_err(text)?;
        if let Some(upcoming) = self.session.upcoming() {
            self.loader.prefetch(upcoming);
        }
        Ok(())
    }

    fn image_px(&self) -> [u32; 2] {
        self.sitting.set.stimulus(0).frame_size_px()
    }

    fn is_too_small(&self, shell: &Shell) -> bool {
        let (window, image) = (shell.size_px(), self.image_px());
        window[0] < image[0] || window[1] < image[1]
    }

    fn draw(
        &mut self,
        shell: &mut Shell,
        protocol: &Protocol,
        pilot: bool,
        actions: &mut Vec<(Action, Instant)>,
    ) -> Result<Next, RunError> {
        if let Some(overlay) = &self.overlay {
            shell.draw(
                grey(),
                |_| {},
                |ui| {
                    actions.extend(now(match overlay {
                        Overlay::Leaving => pages::leaving(ui),
                        Overlay::Problem(problem) => pages::problem(ui, problem),
                    }));
                    if pilot {
                        pages::pilot_banner(ui);
                    }
                },
            )?;
            return Ok(Next::OnEvent);
        }
        let too_small = self.is_too_small(shell).then(|| self.image_px());
        if too_small.is_some() {
            // What there is no room for is not seen: the trial begins again once there is.
            self.input(Input::Interrupt, Instant::now());
        }
        let progress = self.session.progress();
        let view = &self.view;
        let opened = self.opened;
        let mut presenter =
            WindowPresenter { shell, view, opened, protocol, pilot, progress, too_small, actions };
        let screen = show(&mut self.session, &mut presenter)?;
        Ok(match (screen, self.session.next_change_s()) {
            (Screen::Over, _) => Next::Exit,
            (_, Some(change_s)) => {
                let change = self.opened + Duration::from_secs_f64(change_s.max(0.0));
                Next::At(change.max(Instant::now() + SHORTEST_WAIT))
            }
            (Screen::Grey, None) => Next::At(Instant::now() + LOADING_POLL),
            (_, None) => Next::OnEvent,
        })
    }
}

/// Shows a session's screens in the window.
struct WindowPresenter<'a> {
    shell: &'a mut Shell,
    view: &'a FrameView,
    opened: Instant,
    protocol: &'a Protocol,
    pilot: bool,
    progress: Option<Progress>,
    /// Size of the stimuli, if the window is smaller.
    too_small: Option<[u32; 2]>,
    actions: &'a mut Vec<(Action, Instant)>,
}

impl Presenter for WindowPresenter<'_> {
    type Error = ShellError;

    fn clock(&self) -> Clock {
        Clock::Submission
    }

    fn now_s(&self) -> f64 {
        self.opened.elapsed().as_secs_f64()
    }

    fn present(&mut self, screen: Screen) -> Result<Option<f64>, ShellError> {
        let window = self.shell.size_px();
        let (view, too_small, progress) = (self.view, self.too_small, self.progress);
        let (protocol, pilot, actions) = (self.protocol, self.pilot, &mut *self.actions);
        let shown = self.shell.draw(
            grey(),
            |pass| {
                if let (Screen::Frame { interval, index }, None) = (screen, too_small) {
                    view.paint(pass, window, interval, index);
                }
            },
            |ui| {
                actions.extend(now(match (screen, too_small) {
                    (Screen::Page(page), _) => pages::page(ui, page, &protocol.text, progress),
                    (Screen::Question, _) => pages::question(ui, &protocol.question, progress),
                    (Screen::Grey | Screen::Frame { .. }, Some(image)) => {
                        pages::too_small(ui, window, image);
                        None
                    }
                    _ => {
                        ui.ctx().set_cursor_icon(egui::CursorIcon::None);
                        None
                    }
                }));
                if pilot {
                    pages::pilot_banner(ui);
                }
            },
        )?;
        // A frame that there was no room for was not seen.
        let seen = shown.filter(|_| too_small.is_none() || !matches!(screen, Screen::Frame { .. }));
        Ok(seen.map(|at| (at - self.opened).as_secs_f64()))
    }
}

/// `action` as asked for at this moment.
fn now(action: Option<Action>) -> Option<(Action, Instant)> {
    action.map(|action| (action, Instant::now()))
}

fn key_in_session(key: &Key) -> Option<Action> {
    let input = match key.as_ref() {
        Key::Named(NamedKey::Enter | NamedKey::Space) => Input::Continue,
        Key::Character("1") | Key::Named(NamedKey::ArrowLeft) => Input::Answer(Answer::First),
        Key::Character("2") | Key::Named(NamedKey::ArrowRight) => Input::Answer(Answer::Second),
        Key::Character("q" | "Q") => Input::Replay(Answer::First),
        Key::Character("w" | "W") => Input::Replay(Answer::Second),
        Key::Named(NamedKey::Escape) => Input::Interrupt,
        _ => return None,
    };
    Some(Action::Session(input))
}

fn key_over(overlay: &Overlay, key: &Key) -> Option<Action> {
    match (overlay, key.as_ref()) {
        (_, Key::Character("l" | "L")) => Some(Action::Leave),
        (Overlay::Leaving, Key::Named(NamedKey::Enter | NamedKey::Escape)) => Some(Action::Stay),
        (Overlay::Problem(_), Key::Named(NamedKey::Enter)) => Some(Action::Retry),
        _ => None,
    }
}

/// The neutral grey of [`pages::GREY`]; the surface takes code values as they are.
fn grey() -> wgpu::Color {
    let code = f64::from(pages::GREY) / 255.0;
    wgpu::Color { r: code, g: code, b: code, a: 1.0 }
}
