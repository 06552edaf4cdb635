//! The scene as the pipelines see it, built from the descriptions in `shutterlab_stimuli`.

pub mod camera;
pub mod environment;
pub mod import;
pub mod motion;
pub mod shutter;

/// WGSL twin of [`environment`].
pub const ENVIRONMENT_WGSL: &str = include_str!("environment.wgsl");
/// WGSL twin of [`motion`].
pub const MOTION_WGSL: &str = include_str!("motion.wgsl");
/// WGSL twin of [`shutter`].
pub const SHUTTER_WGSL: &str = include_str!("shutter.wgsl");
