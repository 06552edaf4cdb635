//! Presenters: what shows a session's screens and says when. The window is one; here is the other, a
//! simulated display with a known refresh and planted faults, on which the logic of timing is tested.

use crate::session::{Screen, Session, Viewing};
use shutterlab_data_schema::response::{Clock, Pacing};
use std::convert::Infallible;

/// Shows screens and knows when it did.
pub trait Presenter {
    /// Why a screen could not be shown.
    type Error;

    /// Seconds since the session was opened.
    fn now_s(&self) -> f64;

    /// Shows `screen` and returns when it was shown, or none if it could not be shown this time
    /// (the window is hidden, say) and should be tried again.
    ///
    /// # Errors
    /// The display failed for good.
    fn present(&mut self, screen: Screen) -> Result<Option<f64>, Self::Error>;
}

/// Shows what `session` wants to be seen now, and tells it when that was.
///
/// # Errors
/// The presenter failed.
pub fn show<P: Presenter>(session: &mut Session, presenter: &mut P) -> Result<Screen, P::Error> {
    let screen = session.screen(presenter.now_s());
    if let Some(at_s) = presenter.present(screen)? {
        session.shown(screen, at_s);
    }
    Ok(screen)
}

/// A display in a time of its own, which passes only when something is shown or waited for.
///
/// At a fixed rate each screen is shown at the coming refresh that is free, and the program goes on at the
/// next one, or, as real ones do, as soon as there is room in the display's queue. At a variable rate each is shown when it is given, but no sooner than the fastest refresh allows.
#[derive(Clone, Debug)]
pub struct SimulatedDisplay {
    rate: Rate,
    now_s: f64,
    /// Hold-ups to come: what is shown first at or after this moment comes so many seconds late.
    hiccups: Vec<(f64, f64)>,
}

#[derive(Clone, Copy, Debug)]
enum Rate {
    /// `queue` is how many refreshes early the program may go on: none if it goes on after the refresh.
    Fixed {
        hz: f64,
        queue: Option<u32>,
        next_free: f64,
    },
    Variable {
        fastest_hz: f64,
        last_s: f64,
    },
}

/// Where a moment lies on the grid of refreshes: rounding errors of sums of periods.
const ROUNDING_REFRESHES: f64 = 1e-6;

impl SimulatedDisplay {
    /// A display that refreshes `hz` times a second.
    pub fn new(hz: f64) -> Self {
        let rate = Rate::Fixed { hz, queue: None, next_free: 0.0 };
        Self { rate, now_s: 0.0, hiccups: vec![] }
    }

    /// The same display with a queue of `screens`: the program goes on while so many wait to be shown, and
    /// so it is ahead of what is seen. With 0 it waits for the refresh before a screen is shown, not after.
    pub fn with_queue(mut self, screens: u32) -> Self {
        if let Rate::Fixed { queue, .. } = &mut self.rate {
            *queue = Some(screens);
        }
        self
    }

    /// A display that refreshes when it is given something, `fastest_hz` times a second at most.
    pub fn variable(fastest_hz: f64) -> Self {
        let rate = Rate::Variable { fastest_hz, last_s: f64::NEG_INFINITY };
        Self { rate, now_s: 0.0, hiccups: vec![] }
    }

    /// Plants a hold-up: what is shown first at or after `at_s` comes `late_s` late.
    pub fn hold_up(&mut self, at_s: f64, late_s: f64) {
        self.hiccups.push((at_s, late_s));
    }

    /// What the records say of it.
    pub fn viewing(&self) -> Viewing {
        match self.rate {
            Rate::Fixed { hz, .. } => {
                Viewing::plain(format!("simulated, {hz} Hz"), Clock::Simulated, Some(hz))
            }
            Rate::Variable { fastest_hz, .. } => Viewing {
                pacing: Pacing::VariableRefresh,
                ..Viewing::plain(
                    format!("simulated, variable to {fastest_hz} Hz"),
                    Clock::Simulated,
                    None,
                )
            },
        }
    }

    /// Lets `seconds` pass without showing anything new.
    pub fn wait(&mut self, seconds: f64) {
        self.now_s += seconds.max(0.0);
    }

    /// Waits until `moment_s`, as a program does that is not paced by its display.
    pub fn wait_until(&mut self, moment_s: f64) {
        if let Rate::Variable { .. } = self.rate {
            self.now_s = self.now_s.max(moment_s);
        }
    }

    /// The first refresh that can show what is given at `moment_s`.
    fn refresh_s(&self, moment_s: f64) -> f64 {
        match self.rate {
            Rate::Fixed { hz, next_free, .. } => {
                (moment_s * hz - ROUNDING_REFRESHES).ceil().max(next_free) / hz
            }
            Rate::Variable { fastest_hz, last_s } => moment_s.max(last_s + 1.0 / fastest_hz),
        }
    }
}

impl Presenter for SimulatedDisplay {
    type Error = Infallible;

    fn now_s(&self) -> f64 {
        self.now_s
    }

    fn present(&mut self, _: Screen) -> Result<Option<f64>, Infallible> {
        let mut shown_s = self.refresh_s(self.now_s);
        let due = |&(at_s, _): &(f64, f64)| at_s <= shown_s;
        if let Some((_, late_s)) = self.hiccups.iter().position(due).map(|i| self.hiccups.remove(i))
        {
            shown_s = self.refresh_s(shown_s + late_s);
        }
        match &mut self.rate {
            Rate::Fixed { hz, queue, next_free } => {
                let refresh = (shown_s * *hz).round();
                *next_free = refresh + 1.0;
                match queue {
                    None => self.now_s = *next_free / *hz,
                    // All that the program knows is when it could go on.
                    Some(screens) => {
                        self.now_s = self.now_s.max((refresh - f64::from(*screens)) / *hz);
                        return Ok(Some(self.now_s));
                    }
                }
            }
            Rate::Variable { last_s, .. } => {
                *last_s = shown_s;
                self.now_s = shown_s;
            }
        }
        Ok(Some(shown_s))
    }
}

#[cfg(test)]
mod tests;
