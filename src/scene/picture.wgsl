// Pictures on surfaces: twin of picture.rs and texel.rs. The module that uses it declares `geometry`,
// which begins with the texels.

struct PictureRef {
    first: u32,
    width: u32,
    height: u32,
}

// The base of the exponents of reflectances.
const REFLECTANCE_BASE: u32 = 88u;

fn picture_color(picture: PictureRef, u: f32, v: f32) -> vec3f {
    if picture.width == 0u {
        return vec3f(1.0);
    }
    let size = vec2u(picture.width, picture.height);
    let at = fract(vec2f(u, v)) * vec2f(size) - 0.5;
    let low = floor(at);
    let first = select(min(vec2u(low), size - 1u), size - 1u, low < vec2f(0.0));
    let next = select(first + 1u, vec2u(0u), first + 1u == size);
    let f = at - low;
    let upper = picture.first + first.y * picture.width;
    let lower = picture.first + next.y * picture.width;
    let above = mix(picture_texel(upper + first.x), picture_texel(upper + next.x), f.x);
    let below = mix(picture_texel(lower + first.x), picture_texel(lower + next.x), f.x);
    return mix(above, below, f.y);
}

fn picture_texel(place: u32) -> vec3f {
    return unpack(geometry[place / 4u][place % 4u], REFLECTANCE_BASE);
}

// Three mantissas of 9 bits under a common power of two.
fn unpack(texel: u32, base: u32) -> vec3f {
    let scale = bitcast<f32>(((texel & 31u) + base) << 23u);
    return vec3f(vec3u(texel >> 23u, (texel >> 14u) & 511u, (texel >> 5u) & 511u)) * scale;
}
