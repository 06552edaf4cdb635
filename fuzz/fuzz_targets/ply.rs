//! Any bytes as a PLY file.
#![no_main]

use shutterlab::scene::import::ply;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| drop(ply::parse("a.ply", bytes)));
