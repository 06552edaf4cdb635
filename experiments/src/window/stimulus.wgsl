// Draws one frame, pixel for pixel: the viewport has the size of the frame, so the centre of each
// pixel of the viewport falls into exactly one texel, and its code value goes to the screen as it is.

@group(0) @binding(0) var frame: texture_2d<f32>;

struct Corner {
    @builtin(position) clip: vec4<f32>,
    // (0, 0) is the frame's top left, (1, 1) its bottom right.
    @location(0) place: vec2<f32>,
}

// One triangle that covers the viewport.
@vertex
fn corner(@builtin(vertex_index) index: u32) -> Corner {
    let place = vec2<f32>(f32(index & 1u), f32(index >> 1u)) * 2.0;
    return Corner(vec4<f32>(place.x * 2.0 - 1.0, 1.0 - place.y * 2.0, 0.0, 1.0), place);
}

@fragment
fn texel(in: Corner) -> @location(0) vec4<f32> {
    let texel = vec2<i32>(in.place * vec2<f32>(textureDimensions(frame)));
    return vec4<f32>(textureLoad(frame, texel, 0).rgb, 1.0);
}
