// Which images there are, and what is seen in them: twin of reference.rs. Before it comes the constant `BATCH`.

@group(0) @binding(11) var<uniform> images: array<Sample, BATCH>;
// One more than the object and its face that is seen in each pixel of each image.
@group(0) @binding(12) var visibility: texture_2d_array<u32>;

fn sample_of(pixel: u32, k: u32) -> Sample {
    return images[k];
}

fn seen_by(place: vec2u, k: u32) -> vec2u {
    return textureLoad(visibility, place, k, 0).xy;
}
