// Which images there are: twin of `images`. Before it comes the constant `BATCH`.

@group(0) @binding(12) var<uniform> images: array<Sample, BATCH>;

fn sample_of(pixel: u32, k: u32) -> Sample {
    return images[k];
}
