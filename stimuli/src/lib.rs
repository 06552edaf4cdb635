//! What to show: scenes, viewing geometry and grids of stimuli, and the sequences made from them.
//!
//! A [`Grid`] is axes × levels. Each cell resolves to a [`Stimulus`] with every parameter that its
//! pixels depend on. [`generate()`] lets a [`Render`] make the frames and writes them as a
//! sequence folder, which counts as finished only when its [`Manifest`] is there.
//!
//! This crate knows no renderer: the renderer core implements [`Render`].

pub mod assets;
pub mod contrast_sensitivity;
pub mod frames;
pub mod generate;
pub mod grid;
pub mod letters;
pub mod manifest;
pub mod overview;
pub mod scene;
#[cfg(feature = "screen")]
pub mod screen;
pub mod simplification;
pub mod stereo;
pub mod stimulus;
pub mod verify;
pub mod video;
pub mod viewing;

pub use frames::LinearImage;
pub use generate::{Render, generate};
pub use grid::{Grid, Selection};
pub use manifest::{Device, Manifest, Sequence};
pub use scene::Scene;
pub use simplification::Simplification;
pub use stimulus::Stimulus;
