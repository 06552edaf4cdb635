//! The session in its window: shows what the session wants to be seen, when it is due, and passes on
//! what the participant does.

use super::check::HIDDEN_POLL;
use super::frames::{Draw, FrameView, Loader};
use super::now;
use super::pages::{self, Action};
use super::shell::{Next, Shell, ShellError};
use crate::design::{Shows, Trial};
use crate::display::arrangement;
use crate::presenter::{Presenter, show};
use crate::record::RecordError;
use crate::run::Sitting;
use crate::session::{Input, Progress, Screen, Session, Viewing};
use jiff::{SignedDuration, Timestamp};
use shutterlab_data_schema::DisplayProfile;
use shutterlab_data_schema::protocol::{Eye, Protocol};
use shutterlab_data_schema::response::{Answer, Pacing, Side};
use std::time::{Duration, Instant};
use winit::keyboard::{Key, NamedKey};

/// A session under way.
pub(super) struct Asking {
    pub sitting: Sitting,
    session: Session,
    pacing: Pacing,
    profile: DisplayProfile,
    /// Where the eyes' images are from the middle of what is drawn of a frame.
    eyes: Vec<[f32; 2]>,
    opened: Instant,
    loader: Loader,
    view: FrameView,
    overlay: Option<Overlay>,
    pilot: bool,
}

/// What is in front of the session.
enum Overlay {
    /// Does the participant really want to leave?
    Leaving,
    /// Something failed that can be tried again.
    Problem(String),
}

/// How long before a screen's moment it is drawn where the display does not pace the program, to be
/// handed over at that moment. A processor that draws by itself takes up to 10 ms; keys that come in
/// meanwhile are read that much later.
const LEAD: Duration = Duration::from_millis(20);

/// How long to wait before looking again whether a trial's frames are there.
const LOADING_POLL: Duration = Duration::from_millis(10);

/// Physical pixels of grey between two images shown in one trial.
const BETWEEN_PX: u32 = 32;

impl Asking {
    pub(super) fn new(
        sitting: Sitting,
        viewing: Viewing,
        profile: &DisplayProfile,
        pilot: bool,
        shell: &Shell,
    ) -> Self {
        let pacing = viewing.pacing;
        let session = sitting.session(viewing);
        let mut asking = Self {
            loader: Loader::new(sitting.set.clone()),
            view: FrameView::new(shell, profile),
            eyes: arrangement(sitting.set.stimulus(0), profile).middles(),
            sitting,
            session,
            pacing,
            profile: profile.clone(),
            opened: Instant::now(),
            overlay: None,
            pilot,
        };
        if let Some(trial) = asking.session.trial().cloned() {
            asking.prefetch(&trial);
        }
        asking
    }

    /// What `key` means now.
    pub(super) fn meaning(&self, key: &Key) -> Option<Action> {
        match &self.overlay {
            Some(overlay) => key_over(overlay, key),
            None => key_in_session(key, &self.session.answers()),
        }
    }

    /// Does what was asked for at `at`.
    pub(super) fn act(&mut self, action: Action, at: Instant) {
        match action {
            Action::Session(Input::Interrupt) => {
                self.input(Input::Interrupt, at);
                self.overlay = Some(Overlay::Leaving);
            }
            Action::Session(input) if self.overlay.is_none() => {
                self.input(input, at);
                // At once: what comes next may be the wish to leave.
                if let Err(error) = self.session.save(&mut self.sitting.recorder) {
                    self.overlay = Some(Overlay::Problem(error.to_string()));
                }
            }
            Action::Stay | Action::Retry => self.overlay = None,
            _ => {}
        }
    }

    fn now_s(&self) -> f64 {
        self.opened.elapsed().as_secs_f64()
    }

    fn at(&self, moment_s: f64) -> Instant {
        self.opened + Duration::from_secs_f64(moment_s.max(0.0))
    }

    /// The moment for which the next screen is drawn, if it is near and the display does not set it.
    fn moment(&self) -> Option<Instant> {
        let is_ours = self.session.is_playing() && self.pacing != Pacing::FixedRefresh;
        let change = self.at(self.session.next_change_s().filter(|_| is_ours)?);
        (change <= Instant::now() + LEAD).then_some(change)
    }

    fn input(&mut self, input: Input, at: Instant) {
        let at_s = at.saturating_duration_since(self.opened).as_secs_f64();
        let ago = SignedDuration::try_from(at.elapsed()).unwrap_or_default();
        self.session.input(input, at_s, Timestamp::now() - ago);
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
        if self.view.holds() != Some(trial.number) {
            self.prefetch(&trial);
            let Some(decoded) = self.loader.take(trial.number)? else { return Ok(()) };
            self.view.upload(shell, decoded);
        }
        if self.too_small(shell).is_some() {
            return Ok(());
        }
        self.session.begin(self.now_s(), &mut self.sitting.recorder).map_err(text)?;
        if let Some(upcoming) = self.session.upcoming().cloned() {
            self.prefetch(&upcoming);
        }
        Ok(())
    }

    fn prefetch(&mut self, trial: &Trial) {
        let still = self.session.protocol().timeline.still.map(|still| still.frame);
        self.loader.prefetch(trial.number, vec![trial.a, trial.b], still);
    }

    /// Width and height that the trial needs, if the window has less.
    fn too_small(&self, shell: &Shell) -> Option<[u32; 2]> {
        let trial = self.session.trial()?;
        let image = arrangement(self.sitting.set.stimulus(trial.a), &self.profile).size_px;
        let shows = trial.intervals(self.session.protocol().task);
        let centres = shows.iter().flat_map(|shows| draws(*shows, image).into_iter());
        let reach = |axis: usize| {
            let centre = centres.clone().map(|(_, centre)| centre[axis].unsigned_abs()).max();
            2 * centre.unwrap_or(0) + image[axis]
        };
        let (needed, window) = ([reach(0), reach(1)], shell.size_px());
        (window[0] < needed[0] || window[1] < needed[1]).then_some(needed)
    }

    /// Draws what is to be seen and says when to draw again.
    pub(super) fn draw(
        &mut self,
        shell: &mut Shell,
        actions: &mut Vec<(Action, Instant)>,
    ) -> Result<Next, ShellError> {
        self.work(shell);
        let (pilot, progress) = (self.pilot, self.session.progress());
        if let Some(overlay) = &self.overlay {
            let words = &self.session.protocol().words;
            shell.draw(
                |_, _, _| {},
                |ui| {
                    actions.extend(now(match overlay {
                        Overlay::Leaving => pages::leaving(ui, words, progress),
                        Overlay::Problem(problem) => pages::problem(ui, words, problem),
                    }));
                    if pilot {
                        pages::pilot_banner(ui);
                    }
                },
            )?;
            return Ok(Next::OnEvent);
        }
        let too_small = self.too_small(shell);
        if too_small.is_some() {
            // What there is no room for is not seen: the trial begins again once there is.
            self.input(Input::Interrupt, Instant::now());
        }
        let moment = self.moment();
        let protocol = self.session.protocol().clone();
        let answers = self.session.answers();
        let trial = self.session.trial().cloned();
        let mut presenter = WindowPresenter {
            shell,
            moment,
            view: &self.view,
            eyes: &self.eyes,
            opened: self.opened,
            protocol: &protocol,
            answers: &answers,
            trial: trial.as_ref(),
            pilot,
            progress,
            too_small,
            actions,
            hidden: false,
        };
        let screen = show(&mut self.session, &mut presenter)?;
        if presenter.hidden {
            return Ok(Next::At(Instant::now() + HIDDEN_POLL));
        }
        let playing = self.session.is_playing();
        Ok(match (screen, self.session.next_change_s()) {
            (Screen::Over, _) => Next::Exit,
            // The display says when the next frame may come: handing it over waits for that.
            (_, Some(_)) if playing && self.pacing == Pacing::FixedRefresh => {
                Next::At(Instant::now())
            }
            (_, Some(change_s)) if playing => {
                let change = self.at(change_s);
                Next::Only(change.checked_sub(LEAD).unwrap_or(change))
            }
            (_, Some(change_s)) => Next::At(self.at(change_s)),
            (Screen::Grey, None) => Next::At(Instant::now() + LOADING_POLL),
            (_, None) => Next::OnEvent,
        })
    }
}

/// Which of the two sequences an interval draws, and where their centres are from the window's.
fn draws(shows: Shows, [width, height]: [u32; 2]) -> Vec<(Side, [i32; 2])> {
    let [x, y] = [width, height].map(|size| (size + BETWEEN_PX).div_ceil(2) as i32);
    match shows {
        Shows::Middle(side) => vec![(side, [0, 0])],
        Shows::Reference(side) => vec![(side, [0, -y])],
        Shows::Left(side) => vec![(side, [-x, y])],
        Shows::Right(side) => vec![(side, [x, y])],
        Shows::Both(left) => vec![(left, [-x, 0]), (left.other(), [x, 0])],
    }
}

/// Shows a session's screens in the window.
struct WindowPresenter<'a> {
    shell: &'a mut Shell,
    /// The moment for which this is drawn, unless it is now.
    moment: Option<Instant>,
    view: &'a FrameView,
    /// Where the eyes' images are from the middle of what is drawn of a frame.
    eyes: &'a [[f32; 2]],
    opened: Instant,
    protocol: &'a Protocol,
    answers: &'a [Answer],
    trial: Option<&'a Trial>,
    pilot: bool,
    progress: Option<Progress>,
    /// What the trial needs, if the window is smaller.
    too_small: Option<[u32; 2]>,
    actions: &'a mut Vec<(Action, Instant)>,
    /// Whether the window cannot be seen just now.
    hidden: bool,
}

impl WindowPresenter<'_> {
    /// Where fixation marks are, from the window's middle: before the trial there, then in the middle of
    /// each image; for each eye.
    fn marks(&self, screen: Screen) -> Vec<[f32; 2]> {
        let draws = self.draws(screen);
        let images = match draws.is_empty() {
            true => vec![[0, 0]],
            false => draws.iter().map(|draw| draw.centre).collect(),
        };
        let mark =
            |[x, y]: [i32; 2], [eye_x, eye_y]: [f32; 2]| [x as f32 + eye_x, y as f32 + eye_y];
        images
            .iter()
            .flat_map(|image| self.eyes.iter().map(move |eye| mark(*image, *eye)))
            .collect()
    }

    /// What is to be drawn of the sequences.
    fn draws(&self, screen: Screen) -> Vec<Draw> {
        let (Screen::Frame { interval, index }, Some(trial), None) =
            (screen, self.trial, self.too_small)
        else {
            return vec![];
        };
        let frame = self.protocol.timeline.still.map_or(index, |still| still.frame);
        let shows = trial.intervals(self.protocol.task);
        let Some(shows) = shows.get(interval) else { return vec![] };
        draws(*shows, self.view.size_px())
            .into_iter()
            .map(|(side, centre)| {
                // In the order in which they were asked for.
                let sequence = usize::from(side == Side::B);
                Draw { sequence, frame, centre }
            })
            .collect()
    }
}

impl Presenter for WindowPresenter<'_> {
    type Error = ShellError;

    fn now_s(&self) -> f64 {
        let now = Instant::now();
        let seen = self.moment.map_or(now, |moment| moment.max(now));
        seen.saturating_duration_since(self.opened).as_secs_f64()
    }

    fn present(&mut self, screen: Screen) -> Result<Option<f64>, ShellError> {
        let (draws, marks) = (self.draws(screen), self.marks(screen));
        let window = self.shell.size_px();
        let (view, too_small, progress) = (self.view, self.too_small, self.progress);
        let (protocol, pilot, actions) = (self.protocol, self.pilot, &mut *self.actions);
        let is_frame = matches!(screen, Screen::Frame { .. });
        let marked = screen == Screen::Fixation
            || is_frame && protocol.timeline.eye == Eye::Fixate && too_small.is_none();
        let answers = self.answers;
        let shown = self.shell.draw_for(
            self.moment,
            |pass, number, window_px| {
                view.paint(pass, number, window_px, &draws);
                view.paint_patch(pass, window_px, !draws.is_empty());
            },
            |ui| {
                actions.extend(now(match (screen, too_small) {
                    (Screen::Page(page), _) => pages::page(ui, page, protocol, progress),
                    (Screen::Question, _) => pages::question(ui, protocol, answers, progress),
                    (_, Some(needed)) => {
                        pages::too_small(ui, &protocol.words, window, needed);
                        None
                    }
                    _ => {
                        ui.ctx().set_cursor_icon(egui::CursorIcon::None);
                        None
                    }
                }));
                if marked {
                    pages::fixation(ui, &marks);
                }
                if pilot {
                    pages::pilot_banner(ui);
                }
            },
        )?;
        self.hidden = shown.is_none();
        // A frame that there was no room for was not seen.
        let seen = shown.filter(|_| too_small.is_none() || !is_frame);
        Ok(seen.map(|at| (at - self.opened).as_secs_f64()))
    }
}

fn key_in_session(key: &Key, answers: &[Answer]) -> Option<Action> {
    let answer = |place: usize| answers.get(place).copied().map(Input::Answer);
    let input = match key.as_ref() {
        Key::Named(NamedKey::Enter | NamedKey::Space) => Input::Continue,
        Key::Character("1") | Key::Named(NamedKey::ArrowLeft) => answer(0)?,
        Key::Character("2") | Key::Named(NamedKey::ArrowRight) => answer(1)?,
        Key::Character("3") | Key::Named(NamedKey::ArrowDown) => answer(2)?,
        Key::Character("q" | "Q") => Input::Replay(0),
        Key::Character("w" | "W") => Input::Replay(1),
        Key::Character("e" | "E") => Input::Replay(2),
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
