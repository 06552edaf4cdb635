//! The one integration test binary: everything together, with the built command.
#![cfg(feature = "cli")]
#![expect(clippy::unwrap_used, reason = "a test that cannot go on should panic")]

/// What the tests share: running the command, small stimuli, temporary folders.
mod support;

/// `analyze` on the published vote tables and on matrices.
mod analyze;
/// Bad input of every kind: one error line, the right exit status, nothing half-written.
mod bad_input;
/// Scattering on a graphics device, beside its twin.
#[cfg(feature = "gpu")]
mod bsdf;
/// Cohorts of simulated observers, from the file to the rows.
mod cohorts;
/// What a display profile says is what is to be seen on the screen.
#[cfg(all(feature = "window", target_os = "linux"))]
mod display;
/// `export`: what other programs make of a study.
mod export;
/// `fit` on made-up ratings and points.
mod fit;
/// Three ways to blur, and what simplified models save.
mod motion_blur;
/// The operator's pages, and what they record.
#[cfg(all(feature = "window", target_os = "linux"))]
mod operator;
/// Tests of simplified models, from the pictures to a simplified mesh.
#[cfg(feature = "screen")]
mod perception;
/// `plan`: what a study can find, for every shipped protocol.
mod plan;
/// From simulated answers back to what they were drawn from.
mod recovery;
/// `render`: manifests, resuming, the same bytes again.
mod render;
/// `replicate`: published numbers beside ours.
mod replicate;
/// Which room may import from which.
mod rooms;
/// Scenes in files, and their light maps.
mod scenes;
/// `screen`: pairs of sequences by predictors of vision.
#[cfg(feature = "screen")]
mod screen;
/// Sessions that are killed and go on.
mod sessions;
/// Shader structs against their twins in Rust.
#[cfg(feature = "gpu")]
mod shaders;
/// `simplify`: every format in and out, goals, motions, wrong words.
mod simplify;
/// `validate`: faults are found, whole files pass.
mod validate;
/// Outside validators on what a study writes.
mod validators;
/// A session in a real window, driven by keys.
#[cfg(all(feature = "window", target_os = "linux"))]
mod window;
