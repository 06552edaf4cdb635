//! The scene as the pipelines see it, built from the descriptions in `shutterlab_stimuli`.

pub mod camera;
pub mod environment;
pub mod export;
pub mod import;
pub mod light;
pub mod made;
pub mod object;
pub mod picture;
pub mod screen_motion;
pub mod shutter;
pub mod texel;
pub mod world;

/// WGSL twin of [`camera`].
pub const CAMERA_WGSL: &str = include_str!("camera.wgsl");
/// WGSL twin of [`environment`].
pub const ENVIRONMENT_WGSL: &str = include_str!("environment.wgsl");
/// WGSL twin of [`light`].
pub const LIGHT_WGSL: &str = include_str!("light.wgsl");
/// WGSL twin of [`object`].
pub const OBJECT_WGSL: &str = include_str!("object.wgsl");
/// WGSL twin of [`picture`] and [`texel`].
pub const PICTURE_WGSL: &str = include_str!("picture.wgsl");
/// WGSL twin of [`shutter`].
pub const SHUTTER_WGSL: &str = include_str!("shutter.wgsl");
/// WGSL twin of [`world`].
pub const WORLD_WGSL: &str = include_str!("world.wgsl");
