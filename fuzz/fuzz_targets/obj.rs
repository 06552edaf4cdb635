//! Any bytes as an OBJ file.
#![no_main]

use shutterlab::scene::import::obj;
use std::path::Path;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    drop(obj::parse("a.obj", bytes, Path::new("/nowhere")));
});
