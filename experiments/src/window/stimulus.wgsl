// Draws one frame as the display profile says, in the viewport that is as large as the drawing: the
// centre of each pixel of the viewport belongs to one physical pixel. Does what `display::compose` does.

// As `Settings` in frames.rs writes them.
struct Settings {
    stored_px: vec2<i32>,
    image_px: vec2<i32>,
    view_px: vec2<i32>,
    size_px: vec2<i32>,
    mode: i32,
    // 0: image pixels are repeated, 1: neighbours are mixed.
    is_linear: i32,
    magnification: f32,
    // For red, green and blue of the anaglyph: shares of the left eye's light, then of the right's.
    dubois: array<vec4<f32>, 6>,
    // By code value: light it stands for, light that the display emits for it, code to send, in [0, 1].
    codes: array<vec4<f32>, 256>,
}

const AS_STORED = 0;
const SIDE_BY_SIDE = 1;
const CROSSED = 2;
const HALF_WIDTH = 3;
const TOP_BOTTOM = 4;
const ANAGLYPH = 5;
const ROW_INTERLEAVED = 6;
const TWO_WINDOWS = 7;

@group(0) @binding(0) var frame: texture_2d<f32>;
@group(0) @binding(1) var<uniform> settings: Settings;

struct Corner {
    @builtin(position) position: vec4<f32>,
    // (0, 0) is the drawing's top left, (1, 1) its bottom right.
    @location(0) place: vec2<f32>,
    @location(1) @interpolate(flat) instance: u32,
}

// One triangle that covers the viewport.
@vertex
fn corner(@builtin(vertex_index) index: u32, @builtin(instance_index) instance: u32) -> Corner {
    let place = vec2<f32>(f32(index & 1u), f32(index >> 1u)) * 2.0;
    return Corner(vec4<f32>(place.x * 2.0 - 1.0, 1.0 - place.y * 2.0, 0.0, 1.0), place, instance);
}

// What a physical pixel shows: which eye's image, and the pixel of that eye's view.
struct Shown {
    eye: i32,
    place: vec2<i32>,
}

// The instance is the number of the window.
fn shown(in: Corner) -> Shown {
    let at = vec2<i32>(in.place * vec2<f32>(settings.size_px));
    let part = at / settings.view_px;
    var eye = 0;
    switch settings.mode {
        case SIDE_BY_SIDE, HALF_WIDTH: { eye = part.x; }
        case CROSSED: { eye = 1 - part.x; }
        case TOP_BOTTOM: { eye = part.y; }
        case ROW_INTERLEAVED: { eye = i32(in.position.y) % 2; }
        case TWO_WINDOWS: { eye = i32(in.instance); }
        default: {}
    }
    return Shown(eye, at % settings.view_px);
}

// Where each physical pixel shows one image pixel. Apart from `mixed`, for an adapter that is a program
// executes whatever a shader might do.
@fragment
fn copied(in: Corner) -> @location(0) vec4<f32> {
    let shown = shown(in);
    let code = stored(shown.eye, shown.place / i32(settings.magnification));
    return vec4<f32>(
        settings.codes[code.r].z,
        settings.codes[code.g].z,
        settings.codes[code.b].z,
        1.0,
    );
}

// Where a physical pixel mixes several.
@fragment
fn mixed(in: Corner) -> @location(0) vec4<f32> {
    let shown = shown(in);
    if settings.mode == ANAGLYPH {
        return encoded(anaglyph(light(0, shown.place), light(1, shown.place)));
    }
    return encoded(light(shown.eye, shown.place));
}

// The instance is 1 for the bright patch and 0 for the dark one.
@fragment
fn patch_pixel(in: Corner) -> @location(0) vec4<f32> {
    return vec4<f32>(vec3<f32>(f32(in.instance)), 1.0);
}

// Light of an eye's image at a physical pixel of its view.
fn light(eye: i32, place: vec2<i32>) -> vec3<f32> {
    if settings.is_linear == 0 {
        return image(eye, place / i32(settings.magnification));
    }
    let last = settings.image_px - 1;
    let at = clamp(
        (vec2<f32>(place) + 0.5) / settings.magnification - 0.5,
        vec2<f32>(0.0),
        vec2<f32>(last),
    );
    let near = vec2<i32>(floor(at));
    let far = min(near + 1, last);
    let by = at - floor(at);
    let top = mix(image(eye, near), image(eye, vec2<i32>(far.x, near.y)), by.x);
    let bottom = mix(image(eye, vec2<i32>(near.x, far.y)), image(eye, far), by.x);
    return mix(top, bottom, by.y);
}

// Light of an eye's image at an image pixel.
fn image(eye: i32, at: vec2<i32>) -> vec3<f32> {
    if settings.mode == HALF_WIDTH {
        let left = vec2<i32>(2 * at.x, at.y);
        return mix(decoded(stored(eye, left)), decoded(stored(eye, left + vec2<i32>(1, 0))), 0.5);
    }
    return decoded(stored(eye, at));
}

// Code values of an eye's image at a stored pixel.
fn stored(eye: i32, at: vec2<i32>) -> vec3<u32> {
    let texel = textureLoad(frame, at + vec2<i32>(eye * settings.stored_px.x, 0), 0);
    return vec3<u32>(round(texel.rgb * 255.0));
}

fn decoded(code: vec3<u32>) -> vec3<f32> {
    return vec3<f32>(
        settings.codes[code.r].x,
        settings.codes[code.g].x,
        settings.codes[code.b].x,
    );
}

fn anaglyph(left: vec3<f32>, right: vec3<f32>) -> vec3<f32> {
    var mixed = vec3<f32>(0.0);
    for (var channel = 0; channel < 3; channel++) {
        mixed[channel] = 1e-3 * (dot(settings.dubois[2 * channel].xyz, left)
            + dot(settings.dubois[2 * channel + 1].xyz, right));
    }
    return mixed;
}

fn encoded(light: vec3<f32>) -> vec4<f32> {
    return vec4<f32>(encoded_one(light.r), encoded_one(light.g), encoded_one(light.b), 1.0);
}

// The code value for which the display's light is nearest.
fn encoded_one(light: f32) -> f32 {
    if light <= 0.0 {
        return 0.0;
    }
    if light >= 1.0 {
        return 1.0;
    }
    // The last code that emits no more.
    var code = 0u;
    for (var step = 128u; step > 0u; step /= 2u) {
        if settings.codes[code + step].y <= light {
            code += step;
        }
    }
    let is_upper = light - settings.codes[code].y >= settings.codes[code + 1u].y - light;
    return f32(code + u32(is_upper)) / 255.0;
}
