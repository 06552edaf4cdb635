// Which samples there are: those of distribution ray tracing, number by number.

fn sample_of(pixel: u32, k: u32) -> Sample {
    let number = frame.first_sample + k;
    let words = first_blocks(frame.key, frame.strata, pixel, number).start;
    let shutter = shutter_instant(frame.shutter_width, frame.shutter_reach, unit(words.z));
    return Sample(vec2f(unit(words.x), unit(words.y)), lens_of(pixel, number), shutter, words.w);
}
