//! How to ask: designs, sessions, records, observers and the window.
//!
//! A [`Protocol`](shutterlab_data_schema::Protocol) names stimuli; a
//! [`StimulusSet`](stimuli_set::StimulusSet) is those stimuli as rendered sequences; [`design`]
//! decides who is compared with whom and in which order. [`session`] is one participant's sitting as
//! a state machine without input or output: it says what to show, takes keys and clock readings, and
//! hands over each finished answer. [`record`] writes the answer down before the session moves on.
//!
//! People sit in front of a [`window`](window::run), simulated [`observer`]s in front of a
//! [`presenter::SimulatedDisplay`]; everything else is the same code for both.

pub mod bradley_terry;
pub mod cohort;
pub mod design;
pub mod display;
pub mod observer;
pub mod playback;
pub mod presenter;
pub mod protocols;
pub mod random;
pub mod record;
pub mod run;
pub mod session;
pub mod stimuli_set;
#[cfg(test)]
mod test_support;
#[cfg(feature = "window")]
pub mod window;

pub use cohort::{CohortOutcome, CohortRequest, run_cohort};
pub use observer::SimulatedObserver;
pub use run::{Outcome, RunError, SessionRequest, run_simulated};
