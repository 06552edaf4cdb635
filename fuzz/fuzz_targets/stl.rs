//! Any bytes as a STL file.
#![no_main]

use shutterlab::scene::import::stl;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| drop(stl::parse("a.stl", bytes)));
