//! Any bytes as a glTF file, as JSON or binary, with the pictures in it.
#![no_main]

use shutterlab::scene::import::{Texture, gltf, image};
use std::path::Path;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let Ok(model) = gltf::parse("a.gltf", bytes, Path::new("/nowhere")) else { return };
    for material in model.materials {
        if let Some(texture @ Texture::Embedded { .. }) = material.texture {
            drop(image::texture(&texture));
        }
    }
});
