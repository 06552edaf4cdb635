//! Any bytes as a light map; the seeds are Radiance files.
#![no_main]

use shutterlab::scene::import::image::light_map_from;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| drop(light_map_from("a.hdr", bytes)));
