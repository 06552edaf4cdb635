// The light around the scene: twin of environment.rs. The module that uses it declares
// `environment` (the struct below), `environment_texels` and `environment_parts`.

struct Environment {
    width: u32,
    height: u32,
    exponent_base: u32,
    part_bits: u32,
    inverse_flux: f32,
    part_scale: f32,
}

struct LightSample {
    direction: vec3f,
    radiance: vec3f,
    density: f32,
}

fn environment_sample(words: vec2u) -> LightSample {
    let part = environment_parts[words.x >> (32u - environment.part_bits)];
    let x = part.x + part.z * unit(words.x << environment.part_bits);
    let y = part.y + part.w * unit(words.y);
    let polar = sin_cos_turns(0.5 * y / f32(environment.height));
    let turn = sin_cos_turns(x / f32(environment.width));
    let direction = vec3f(-polar.x * turn.y, polar.y, -polar.x * turn.x);
    let radiance = environment_texel(x, y);
    let density = dot(radiance, LUMINANCE);
    let ratio = density * polar.x * (part.z * part.w) * environment.part_scale;
    return LightSample(direction, radiance * ratio, density * environment.inverse_flux);
}

// Radiance from a direction, and the density a light sample there is weighed with, per steradian.
fn environment_evaluate(direction: vec3f, shift: vec2f) -> vec4f {
    let width = f32(environment.width);
    let height = f32(environment.height);
    let cos_elevation = sqrt(max(1.0 - direction.y * direction.y, 0.0));
    let x = (0.5 - atan2_turns(-direction.z, direction.x)) * width + shift.x;
    let y = (0.5 - 2.0 * atan2_turns(direction.y, cos_elevation)) * height + shift.y;
    let around = x + select(0.0, width, x < 0.0) - select(0.0, width, x >= width);
    let radiance = environment_texel(around, clamp(y, 0.0, height));
    return vec4f(radiance, dot(radiance, LUMINANCE) * environment.inverse_flux);
}

// Radiance at a place of the map, in texels.
fn environment_texel(x: f32, y: f32) -> vec3f {
    let i = min(u32(x), environment.width - 1u);
    let j = min(u32(y), environment.height - 1u);
    return unpack(environment_texels[j * environment.width + i], environment.exponent_base);
}
