//! The graphics device: choosing an adapter, building compute shaders, reading buffers back.

pub mod buffers;
pub mod device;
pub mod shader;
