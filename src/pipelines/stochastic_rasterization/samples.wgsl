// Which samples there are: those of distribution ray tracing, number by number.

fn sample_of(pixel: u32, k: u32) -> Sample {
    let words = first_blocks(frame.key, frame.strata, pixel, frame.first_sample + k).start;
    let shutter = shutter_instant(frame.shutter_width, frame.shutter_reach, unit(words.z));
    return Sample(vec2f(unit(words.x), unit(words.y)), shutter, words.w);
}
