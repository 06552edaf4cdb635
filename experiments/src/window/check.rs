//! The check of the display in a window, before a session or by itself.

use super::frames::FrameView;
use super::pages;
use super::shell::{self, App, Next, Shell, ShellError};
use crate::display::check::{Angle, DisplayCheck, Measurement};
use shutterlab_data_schema::DisplayProfile;
use std::time::{Duration, Instant};
use winit::keyboard::{Key, NamedKey};

/// The check gave no result.
#[derive(Debug, thiserror::Error)]
pub enum CheckError {
    /// The window or its device failed.
    #[error(transparent)]
    Window(#[from] ShellError),
    /// The window was closed before the end.
    #[error("display check: the window was closed before the end; nothing was found out")]
    Cancelled,
}

/// Checks the display of `profile` in a window with `frames` frames. Must be called from the main
/// thread, once per process.
///
/// # Errors
/// There is no window, or it was closed.
pub fn check(profile: &DisplayProfile, frames: usize) -> Result<DisplayCheck, CheckError> {
    let mut checker =
        Checker { profile, checking: Checking::new(frames), view: None, result: None, left: false };
    shell::run("Shutterlab – display check", profile, &mut checker)?;
    checker.result.ok_or(CheckError::Cancelled)
}

/// A check under way in a window.
pub(super) struct Checking {
    measurement: Measurement,
    began: Instant,
    is_bright: bool,
}

/// How long to wait before trying again to draw in a window that cannot be seen.
pub(super) const HIDDEN_POLL: Duration = Duration::from_millis(20);

impl Checking {
    pub(super) fn new(frames: usize) -> Self {
        Self { measurement: Measurement::new(frames), began: Instant::now(), is_bright: false }
    }

    /// Presents the next frame if its time has come, with `words` on it, and says when to call again;
    /// none if all is measured. The patch for a photodiode changes with each frame.
    pub(super) fn redraw(
        &mut self,
        shell: &mut Shell,
        view: &FrameView,
        words: &str,
    ) -> Result<Option<Next>, ShellError> {
        let Some(due) = self.due() else { return Ok(None) };
        if due > Instant::now() {
            return Ok(Some(Next::Only(due)));
        }
        let bright = self.is_bright;
        let done = (100.0 * self.measurement.progress()).floor();
        let shown = shell.draw(
            |pass, _, window_px| view.paint_patch(pass, window_px, bright),
            |ui| pages::caption(ui, &format!("{words}\n{done} %")),
        )?;
        let Some(at) = shown else { return Ok(Some(Next::At(Instant::now() + HIDDEN_POLL))) };
        self.is_bright = !bright;
        self.measurement.presented(at.saturating_duration_since(self.began).as_secs_f64());
        Ok(self.due().map(Next::Only))
    }

    /// What was found out.
    pub(super) fn judge(
        &self,
        shell: &Shell,
        profile: &DisplayProfile,
        angle: Option<Angle>,
    ) -> DisplayCheck {
        self.measurement.judge(shell.facts(), profile, angle)
    }

    fn due(&self) -> Option<Instant> {
        let due_s = self.measurement.due_s()?;
        Some(self.began + Duration::from_secs_f64(due_s.max(0.0)))
    }
}

struct Checker<'a> {
    profile: &'a DisplayProfile,
    checking: Checking,
    view: Option<FrameView>,
    result: Option<DisplayCheck>,
    left: bool,
}

impl App for Checker<'_> {
    type Error = ShellError;

    fn start(&mut self, shell: &mut Shell) -> Result<(), ShellError> {
        pages::set_style(shell.egui());
        self.view = Some(FrameView::new(shell, self.profile));
        Ok(())
    }

    fn key(&mut self, key: &Key, _: Instant) -> bool {
        self.left |= *key == Key::Named(NamedKey::Escape);
        true
    }

    fn redraw(&mut self, shell: &mut Shell) -> Result<Next, ShellError> {
        let Some(view) = self.view.as_ref().filter(|_| !self.left) else { return Ok(Next::Exit) };
        let words = "The display is being measured. Escape ends it.";
        let next = self.checking.redraw(shell, view, words)?;
        Ok(next.unwrap_or_else(|| {
            self.result = Some(self.checking.judge(shell, self.profile, None));
            Next::Exit
        }))
    }
}
