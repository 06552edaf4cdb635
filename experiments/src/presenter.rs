//! Presenters: what shows a session's screens and says when. The window is one; here is the other, a
//! simulated display with a known refresh, on which the logic of timing is tested.

use crate::session::{Screen, Session};
use shutterlab_data_schema::response::Clock;
use std::convert::Infallible;

/// Shows screens and knows when it did.
pub trait Presenter {
    /// Why a screen could not be shown.
    type Error;

    /// What its times are read from.
    fn clock(&self) -> Clock;

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

/// A display that shows each screen at its next refresh, in a time of its own that passes only when
/// something is shown.
#[derive(Clone, Debug)]
pub struct SimulatedDisplay {
    refresh_hz: f64,
    refreshes: u64,
}

impl SimulatedDisplay {
    /// A display that refreshes `refresh_hz` times a second.
    pub fn new(refresh_hz: f64) -> Self {
        Self { refresh_hz, refreshes: 0 }
    }

    /// Its name for the records.
    pub fn name(&self) -> String {
        format!("simulated, {} Hz", self.refresh_hz)
    }

    /// Lets at least `seconds` pass without showing anything new.
    pub fn wait(&mut self, seconds: f64) {
        self.refreshes += (seconds.max(0.0) * self.refresh_hz).ceil() as u64;
    }
}

impl Presenter for SimulatedDisplay {
    type Error = Infallible;

    fn clock(&self) -> Clock {
        Clock::Simulated
    }

    fn now_s(&self) -> f64 {
        self.refreshes as f64 / self.refresh_hz
    }

    /// Shows at the coming refresh, and returns once it is past.
    fn present(&mut self, _: Screen) -> Result<Option<f64>, Infallible> {
        let shown_s = self.now_s();
        self.refreshes += 1;
        Ok(Some(shown_s))
    }
}
