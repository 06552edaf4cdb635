// The light around the scene: twin of environment.rs. The module that uses it declares
// `environment` (the struct below), `environment_texels`, `row_sines` and, for alias.wgsl,
// `alias_slots`.

struct Environment {
    width: u32,
    height: u32,
    row_bits: u32,
    column_bits: u32,
    flux: f32,
}

struct LightSample {
    direction: vec3f,
    radiance: vec3f,
    density: f32,
}

fn environment_sample(words: vec4u) -> LightSample {
    let j = alias_draw(0u, environment.row_bits, words.x);
    let first = (1u << environment.row_bits) + (j << environment.column_bits);
    let i = alias_draw(first, environment.column_bits, words.y);

    let sin_elevation = mix(row_sines[j], row_sines[j + 1u], unit(words.w));
    let cos_elevation = sqrt(max(1.0 - sin_elevation * sin_elevation, 0.0));
    let turn = sin_cos_turns((f32(i) + unit(words.z)) / f32(environment.width));
    let direction = vec3f(-cos_elevation * turn.y, sin_elevation, -cos_elevation * turn.x);
    let radiance = unpack(environment_texels[j * environment.width + i]);
    return LightSample(direction, radiance, dot(radiance, LUMINANCE) / environment.flux);
}

// Radiance from a direction, and the density with which it is drawn, per steradian.
fn environment_evaluate(direction: vec3f, shift: vec2f) -> vec4f {
    let width = f32(environment.width);
    let height = f32(environment.height);
    let cos_elevation = sqrt(max(1.0 - direction.y * direction.y, 0.0));
    let x = (0.5 - atan2_turns(-direction.z, direction.x)) * width + shift.x;
    let y = (0.5 - 2.0 * atan2_turns(direction.y, cos_elevation)) * height + shift.y;
    let i = u32(min(x - width * floor(x / width), width - 1.0));
    let j = u32(clamp(y, 0.0, height - 1.0));
    let radiance = unpack(environment_texels[j * environment.width + i]);
    return vec4f(radiance, dot(radiance, LUMINANCE) / environment.flux);
}

// Three mantissas of 18 bits under a common power of two.
fn unpack(texel: vec2u) -> vec3f {
    let scale = bitcast<f32>((texel.y & 0x3ffu) << 23u);
    let mantissas = vec3u(
        texel.x >> 14u,
        ((texel.x & 0x3fffu) << 4u) | (texel.y >> 28u),
        (texel.y >> 10u) & 0x3ffffu,
    );
    return vec3f(mantissas) * scale;
}
