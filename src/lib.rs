//! The renderer core of Shutterlab: every method that turns a moving scene seen through an open
//! shutter into an image; and the command line over all of Shutterlab's packages.
//!
//! Rooms, from left to right; each imports only from rooms to its left: `gpu`, [`sampling`] <
//! [`mesh`] < [`scene`] < [`shading`], [`film`] < [`raster`] < [`pipelines`] < [`render`] < `cli`.

#[cfg(feature = "cli")]
pub mod cli;
pub mod film;
#[cfg(feature = "gpu")]
pub mod gpu;
pub mod mesh;
pub mod pipelines;
pub mod raster;
pub mod render;
pub mod sampling;
pub mod scene;
pub mod shading;
