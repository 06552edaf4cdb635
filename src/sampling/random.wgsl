// Counter-based random numbers: twin of random.rs.

// The hash pcg4d of Jarzynski and Olano 2020.
fn pcg4d(input: vec4u) -> vec4u {
    let mixed = mix_words(input * 1664525u + 1013904223u);
    return mix_words(mixed ^ (mixed >> vec4u(16u)));
}

fn mix_words(input: vec4u) -> vec4u {
    var v = input;
    v.x += v.y * v.w;
    v.y += v.z * v.x;
    v.z += v.x * v.y;
    v.w += v.y * v.z;
    return v;
}

fn random_words(key: vec2u, pixel: u32, sample: u32, block: u32) -> vec4u {
    return pcg4d(vec4u(pixel, sample, key.x + block * 0x9e3779b9u, key.y));
}

// The upper 24 bits of a word as a number in [0, 1).
fn unit(word: u32) -> f32 {
    return f32(word >> 8u) * (1.0 / 16777216.0);
}
