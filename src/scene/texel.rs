//! Colours in one word: three mantissas of 9 bits and a common exponent (RGB9E5, but for the exponent,
//! which counts from a base of the picture). Exact to 2⁻⁹ of the largest channel, a third of a step of an
//! 8-bit sRGB frame; two words would cost a fifth of the speed where a light map outgrows the caches.

use glam::Vec3;

/// Base of the exponents of a picture whose largest channel is `brightest`, such that this fits.
pub fn exponent_base(brightest: f32) -> u32 {
    scale_exponent(brightest).saturating_sub(31).max(1)
}

/// Three mantissas of 9 bits in the upper bits, and in the lowest 5 the biased exponent of their
/// common scale, less `base`.
pub fn pack(color: Vec3, base: u32) -> u32 {
    let color = color.max(Vec3::ZERO);
    let exponent = scale_exponent(color.max_element()).saturating_sub(base).min(31);
    let scale = f32::from_bits((exponent + base) << 23);
    let [r, g, b] = (color / scale).to_array().map(|v| (v.round() as u32).min(511));
    r << 23 | g << 14 | b << 5 | exponent
}

/// The channels that [`pack`] packed.
pub fn unpack(texel: u32, base: u32) -> Vec3 {
    let scale = f32::from_bits(((texel & 31) + base) << 23);
    let mantissas = [texel >> 23, (texel >> 14) & 511, (texel >> 5) & 511];
    Vec3::from(mantissas.map(|m| m as f32)) * scale
}

/// Biased exponent of the power of two which goes 256 to 512 times into `largest`.
fn scale_exponent(largest: f32) -> u32 {
    (largest.to_bits() >> 23).saturating_sub(8).max(1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn packing_keeps_nine_bits_of_the_largest_channel() {
        for (color, brightest) in [
            ([160.0, 145.0, 120.0], 160.0),
            ([0.22, 0.19, 1e-3], 160.0),
            ([1e5, 3.0, 0.0], 1e6),
            ([2e-9, 1e-9, 0.0], 1.0),
            ([1e-30; 3], 1e-30),
            ([511.9; 3], 511.9),
        ] {
            let base = exponent_base(brightest);
            let color = Vec3::from(color);
            let error = (unpack(pack(color, base), base) - color).abs().max_element();
            assert!(error <= color.max_element() / 512.0, "{color}: {error}");
        }
        assert_eq!(unpack(pack(Vec3::ZERO, 90), 90), Vec3::ZERO);
    }
}
