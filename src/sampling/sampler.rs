//! Samplers: which words the first two blocks of a sample of a pixel hold, those of the camera's ray and
//! of its first hit, where nearly all of the noise comes from. Further blocks are random for every sampler
//! ([`StreamKey::words`]).
//!
//! - `random`: independent words.
//! - `stratified`: each pair of words is correlated multi-jittered (Kensler, *Correlated Multi-Jittered
//!   Sampling*, Pixar 2013) over all samples of the pixel, whose number it therefore has to know: fewer
//!   samples are no prefix of more.
//! - `sobol`: the words that matter together, row and instant and the choice of the light, are the first
//!   four dimensions of Sobol' (direction numbers of Joe and Kuo 2008), the others pairs of the first two
//!   in an order of their own; all with their digits scrambled after Owen, independently for each pixel
//!   (Burley, *Practical Hash-based Owen Scrambling*, JCGT 9(4), 2020, with the hash of Vegdahl 2021).
//!   Sets are padded: between two of them there is no more than chance. A prefix of 2^k samples is
//!   itself stratified.
//!
//! The point of the lens is one more padded pair, made only for cameras that have one.

use super::random::{StreamKey, mix, unit};
use shutterlab_stimuli::stimulus::Sampler;

/// The block of the words of the lens, beyond those of all hits.
const LENS_BLOCK: u32 = 0x4c45_4e53;

/// Blocks 0 and 1 of sample `sample` of pixel `pixel`, of `strata` samples in all.
pub fn first_blocks(
    sampler: Sampler,
    key: StreamKey,
    strata: u32,
    pixel: u32,
    sample: u32,
) -> [[u32; 4]; 2] {
    let random = [0, 1].map(|block| key.words(pixel, sample, block));
    // Seeds of the pixel: words of a sample beyond the last that there can be.
    let a = key.words(pixel, u32::MAX, 0);
    let b = mix(a);
    let c = mix(b);
    match sampler {
        Sampler::Random => random,
        Sampler::Stratified => {
            let [jitter, light_jitter] = random.map(|block| block.map(unit));
            let pair = |seeds, jitter| multi_jittered_pair(sample, strata, seeds, jitter);
            let [x, y] = pair([a[0], a[1], a[2]], [jitter[0], jitter[1]]);
            let [instant, shift] = pair([a[3], b[0], b[1]], [jitter[2], jitter[3]]);
            let [light, in_light] = pair([b[2], b[3], c[0]], [light_jitter[0], light_jitter[1]]);
            let [u, v] = pair([c[1], c[2], c[3]], [light_jitter[2], light_jitter[3]]);
            [[x, y, instant, shift], [light, in_light, u, v]]
        }
        Sampler::Sobol => {
            let digits = sobol_digits(sample);
            let scrambled = |n: usize| owen_hash(digits[n], a[n]).reverse_bits();
            let [instant, light, in_light, y] = [0, 1, 2, 3].map(scrambled);
            let index = sample.reverse_bits();
            let [x, shift] = sobol_pair(index, [b[0], b[1], b[2]]);
            let [u, v] = sobol_pair(index, [b[3], c[0], c[1]]);
            [[x, y, instant, shift], [light, in_light, u, v]]
        }
    }
}

/// The words for the point of the lens of sample `sample` of pixel `pixel`, of `strata` samples in all.
pub fn lens_words(
    sampler: Sampler,
    key: StreamKey,
    strata: u32,
    pixel: u32,
    sample: u32,
) -> [u32; 2] {
    let [x, y, ..] = key.words(pixel, sample, LENS_BLOCK);
    let [a, b, c, _] = key.words(pixel, u32::MAX, LENS_BLOCK);
    match sampler {
        Sampler::Random => [x, y],
        Sampler::Stratified => multi_jittered_pair(sample, strata, [a, b, c], [x, y].map(unit)),
        Sampler::Sobol => sobol_pair(sample.reverse_bits(), [a, b, c]),
    }
}

/// The first four dimensions of Sobol' at `index`: digits, lowest bit first.
fn sobol_digits(index: u32) -> [u32; 4] {
    let (mut third, mut fourth) = (0, 0);
    // The columns of their matrices, by the recurrences of x² + x + 1 and x³ + x + 1.
    let (mut v, mut w) = ([1, 3], [1, 3, 4]);
    let mut bits = index;
    while bits != 0 {
        if bits & 1 == 1 {
            third ^= v[0];
            fourth ^= w[0];
        }
        v = [v[1], v[1] ^ v[0] ^ (v[0] << 2)];
        w = [w[1], w[2], w[1] ^ w[0] ^ (w[0] << 3)];
        bits >>= 1;
    }
    [index, pascal(index), third, fourth]
}

/// One point of a scrambled (0, 2)-sequence in an order of its own; `index` is its number with the bits
/// reversed.
fn sobol_pair(index: u32, [order, x, y]: [u32; 3]) -> [u32; 2] {
    let index = owen_hash(index, order).reverse_bits();
    [owen_hash(index, x), owen_hash(pascal(index), y)].map(u32::reverse_bits)
}

/// Scrambles digits, the first of which is the lowest bit: each digit is turned or not as the digits
/// before it say.
fn owen_hash(digits: u32, seed: u32) -> u32 {
    let mut x = digits;
    x ^= x.wrapping_mul(0x3d20_adea);
    x = x.wrapping_add(seed);
    x = x.wrapping_mul((seed >> 16) | 1);
    x ^= x.wrapping_mul(0x0552_6c56);
    x ^ x.wrapping_mul(0x53a2_2864)
}

/// The digits, lowest bit first, of the second dimension of Sobol' at `index`: digit i is the sum over
/// j of C(j, i)·(bit j) modulo 2, and C(j, i) is odd where i's bits are among those of j.
fn pascal(index: u32) -> u32 {
    let mut x = index;
    x ^= x >> 16;
    x ^= (x & 0xff00_ff00) >> 8;
    x ^= (x & 0xf0f0_f0f0) >> 4;
    x ^= (x & 0xcccc_cccc) >> 2;
    x ^ ((x & 0xaaaa_aaaa) >> 1)
}

/// Point `sample` of `count` correlated multi-jittered points.
fn multi_jittered_pair(sample: u32, count: u32, seeds: [u32; 3], jitter: [f32; 2]) -> [u32; 2] {
    let columns = count.isqrt();
    let rows = count.div_ceil(columns);
    let s = permute(sample, count, seeds[0]);
    let column = permute(s % columns, columns, seeds[1]) as f32;
    let row = permute(s / columns, rows, seeds[2]) as f32;
    let x = (column + (row + jitter[0]) / rows as f32) / columns as f32;
    let y = (s as f32 + jitter[1]) / count as f32;
    [x, y].map(|u| ((u * 16_777_216.0) as u32).min(0xff_ffff) << 8)
}

/// Where the permutation `seed` of `0..count` takes `i` (Kensler 2013, listing 5).
fn permute(i: u32, count: u32, seed: u32) -> u32 {
    let mask = u32::MAX >> (count - 1).leading_zeros().min(31);
    let mut i = i;
    loop {
        i ^= seed;
        i = i.wrapping_mul(0xe170_893d);
        i ^= seed >> 16;
        i ^= (i & mask) >> 4;
        i ^= seed >> 8;
        i = i.wrapping_mul(0x0929_eb3f);
        i ^= seed >> 23;
        i ^= (i & mask) >> 1;
        i = i.wrapping_mul(1 | (seed >> 27));
        i = i.wrapping_mul(0x6935_fa69);
        i ^= (i & mask) >> 11;
        i = i.wrapping_mul(0x74dc_b303);
        i ^= (i & mask) >> 2;
        i = i.wrapping_mul(0x9e50_1cc3);
        i ^= (i & mask) >> 2;
        i = i.wrapping_mul(0xc860_a3df);
        i &= mask;
        i ^= i >> 5;
        if i < count {
            return (i + seed % count) % count;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SAMPLERS: [Sampler; 3] = [Sampler::Random, Sampler::Stratified, Sampler::Sobol];

    /// Row, instant, light and the place in the light, then x and shift, the pair to go on by, and the lens.
    fn words(sampler: Sampler, key: StreamKey, count: u32, pixel: u32, sample: u32) -> [u32; 10] {
        let [[x, y, instant, shift], [light, in_light, u, v]] =
            first_blocks(sampler, key, count, pixel, sample);
        let [lens, in_lens] = lens_words(sampler, key, count, pixel, sample);
        [instant, light, in_light, y, x, shift, u, v, lens, in_lens]
    }

    fn points(sampler: Sampler, count: u32, pixel: u32) -> Vec<[f64; 10]> {
        let key = StreamKey::new(7, "points", 0, 0, 3);
        (0..count)
            .map(|s| words(sampler, key, count, pixel, s).map(|w| f64::from(unit(w))))
            .collect()
    }

    /// The first points of Sobol' in four dimensions, as the direction numbers of Joe and Kuo give them.
    #[test]
    fn the_digits_are_those_of_sobol() {
        let value = |digits: u32| f64::from(digits.reverse_bits()) / 4_294_967_296.0;
        let dimension = |n: usize| (0..8).map(|i| value(sobol_digits(i)[n])).collect::<Vec<_>>();
        assert_eq!(dimension(0), [0.0, 0.5, 0.25, 0.75, 0.125, 0.625, 0.375, 0.875]);
        assert_eq!(dimension(1), [0.0, 0.5, 0.75, 0.25, 0.625, 0.125, 0.375, 0.875]);
        assert_eq!(dimension(2), [0.0, 0.5, 0.75, 0.25, 0.375, 0.875, 0.625, 0.125]);
        assert_eq!(dimension(3), [0.0, 0.5, 0.75, 0.25, 0.125, 0.625, 0.875, 0.375]);
    }

    /// Of each aligned 2^k points of the Sobol' sampler, every elementary interval of area 2^−k holds
    /// exactly one, in instant and light as in the padded pairs; so it does for every prefix of 2^k.
    /// And each of the joint dimensions alone has one in each 2^−k.
    #[test]
    fn scrambling_keeps_every_elementary_interval() {
        for pixel in 0..8 {
            let points = points(Sampler::Sobol, 256, pixel);
            for k in 0..=8_u32 {
                for run in points.chunks(1 << k) {
                    for pair in [0, 4, 6, 8] {
                        for across in 0..=k {
                            let (columns, rows) = (1_u32 << across, 1_u32 << (k - across));
                            let mut seen = vec![false; 1 << k];
                            for p in run {
                                let column = (p[pair] * f64::from(columns)) as usize;
                                let row = (p[pair + 1] * f64::from(rows)) as usize;
                                seen[row * columns as usize + column] = true;
                            }
                            assert!(seen.iter().all(|&seen| seen), "{pixel} {k} {pair} {across}");
                        }
                    }
                    for dimension in 0..10 {
                        let mut seen = vec![false; 1 << k];
                        run.iter()
                            .for_each(|p| seen[(p[dimension] * run.len() as f64) as usize] = true);
                        assert!(seen.iter().all(|&seen| seen), "{pixel} {k} {dimension}");
                    }
                }
            }
        }
    }

    /// Each 1/n of either axis holds one of n stratified points, for any n.
    #[test]
    fn stratified_points_fill_every_row_and_column() {
        for count in [1, 2, 4, 7, 12, 100, 128, 384] {
            for axis in 0..10 {
                let mut strata: Vec<u32> = points(Sampler::Stratified, count, 5)
                    .iter()
                    .map(|p| (p[axis] * f64::from(count) + 1e-4) as u32)
                    .collect();
                strata.sort_unstable();
                strata.dedup();
                // The last of the columns is short where the count is no product of the sides.
                let columns = (f64::from(count)).sqrt() as u32;
                let is_product = count % columns == 0;
                if [3, 5, 2, 7, 9].contains(&axis) || is_product {
                    assert_eq!(strata.len(), count as usize, "{count}, axis {axis}");
                }
            }
        }
    }

    /// Over pixels any sample of any sampler is uniform, and its numbers are independent: with 2¹⁶
    /// draws, within five standard errors.
    #[test]
    fn every_sample_alone_is_uniform_and_independent() {
        let key = StreamKey::new(1, "uniform", 0, 0, 0);
        const N: u32 = 1 << 16;
        for sampler in SAMPLERS {
            for sample in [0, 1, 77] {
                let mut means = [0.0; 10];
                let mut products = [[0.0; 10]; 10];
                for pixel in 0..N {
                    let u =
                        words(sampler, key, 128, pixel, sample).map(|w| f64::from(unit(w)) - 0.5);
                    for a in 0..10 {
                        means[a] += u[a] / f64::from(N);
                        for b in 0..a {
                            products[a][b] += 12.0 * u[a] * u[b] / f64::from(N);
                        }
                    }
                }
                assert!(means.iter().all(|m| m.abs() < 5.0 * 0.0011), "{sampler:?} {means:?}");
                assert!(
                    products.iter().flatten().all(|p| p.abs() < 5.0 * 0.0039),
                    "{sampler:?} {sample} {products:?}"
                );
            }
        }
    }

    /// A product over all words, which padding must leave unbiased, integrates to its known value:
    /// ∫ Π 2u = 1; and the error of a smooth integral over the joint words is far below that of chance.
    #[test]
    fn padded_sets_integrate_products() {
        let key = StreamKey::new(9, "product", 0, 0, 0);
        const N: u32 = 256;
        const PIXELS: u32 = 400;
        for sampler in SAMPLERS {
            let (mut sum, mut square) = (0.0, 0.0);
            for pixel in 0..PIXELS {
                let points: Vec<[f64; 10]> = (0..N)
                    .map(|s| words(sampler, key, N, pixel, s).map(|w| f64::from(unit(w))))
                    .collect();
                let mean = |f: &dyn Fn(&[f64; 10]) -> f64| {
                    points.iter().map(f).sum::<f64>() / f64::from(N)
                };
                sum += mean(&|u| u.iter().map(|u| 2.0 * u).product()) / f64::from(PIXELS);
                let smooth = mean(&|u| u[0] * u[1] * u[2] * u[3]) - 0.0625;
                square += smooth * smooth / f64::from(PIXELS);
            }
            // The variance of the product is (4/3)¹⁰ − 1 = 16.76, of the smooth one 3⁻⁴ − 4⁻⁴.
            let standard_error = (16.76 / f64::from(N * PIXELS)).sqrt();
            assert!((sum - 1.0).abs() < 5.0 * standard_error, "{sampler:?} {sum}");
            let by_chance = (1.0 / 81.0 - 1.0 / 256.0) / f64::from(N);
            let ratio = square / by_chance;
            match sampler {
                Sampler::Random => assert!((0.7..1.4).contains(&ratio), "{ratio}"),
                // Its pairs are padded, so the product of four has a random part.
                Sampler::Stratified => assert!(ratio < 0.6, "{ratio}"),
                Sampler::Sobol => assert!(ratio < 0.05, "{ratio}"),
            }
        }
    }
}
