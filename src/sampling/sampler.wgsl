// Samplers: twin of sampler.rs. The module that uses it declares the constant `SAMPLER`.

const RANDOM: u32 = 0u;
const STRATIFIED: u32 = 1u;
const LENS_BLOCK: u32 = 0x4c454e53u;

struct FirstBlocks {
    start: vec4u,
    hit: vec4u,
}

fn first_blocks(key: vec2u, strata: u32, pixel: u32, sample: u32) -> FirstBlocks {
    if SAMPLER == RANDOM {
        return FirstBlocks(
            random_words(key, pixel, sample, 0u),
            random_words(key, pixel, sample, 1u),
        );
    }
    let a = random_words(key, pixel, 0xffffffffu, 0u);
    let b = mix_words(a);
    let c = mix_words(b);
    if SAMPLER == STRATIFIED {
        let j = units(random_words(key, pixel, sample, 0u));
        let k = units(random_words(key, pixel, sample, 1u));
        return FirstBlocks(
            vec4u(
                multi_jittered_pair(sample, strata, a.xyz, j.xy),
                multi_jittered_pair(sample, strata, vec3u(a.w, b.xy), j.zw),
            ),
            vec4u(
                multi_jittered_pair(sample, strata, vec3u(b.zw, c.x), k.xy),
                multi_jittered_pair(sample, strata, c.yzw, k.zw),
            ),
        );
    }
    let digits = sobol_digits(sample);
    let joint = reverseBits(vec4u(
        owen_hash(digits.x, a.x), owen_hash(digits.y, a.y),
        owen_hash(digits.z, a.z), owen_hash(digits.w, a.w),
    ));
    let index = reverseBits(sample);
    let lens = sobol_pair(index, b.xyz);
    let onward = sobol_pair(index, vec3u(b.w, c.xy));
    return FirstBlocks(vec4u(lens.x, joint.w, joint.x, lens.y), vec4u(joint.yz, onward));
}

// The words for the point of the lens.
fn lens_words(key: vec2u, strata: u32, pixel: u32, sample: u32) -> vec2u {
    let own = random_words(key, pixel, sample, LENS_BLOCK);
    if SAMPLER == RANDOM {
        return own.xy;
    }
    let seeds = random_words(key, pixel, 0xffffffffu, LENS_BLOCK);
    if SAMPLER == STRATIFIED {
        return multi_jittered_pair(sample, strata, seeds.xyz, units(own).xy);
    }
    return sobol_pair(reverseBits(sample), seeds.xyz);
}

fn units(words: vec4u) -> vec4f {
    return vec4f(unit(words.x), unit(words.y), unit(words.z), unit(words.w));
}

// The first four dimensions of Sobol' at `index`: digits, lowest bit first.
fn sobol_digits(index: u32) -> vec4u {
    var third = 0u;
    var fourth = 0u;
    var v = vec2u(1u, 3u);
    var w = vec3u(1u, 3u, 4u);
    for (var bits = index; bits != 0u; bits >>= 1u) {
        let taken = 0u - (bits & 1u);
        third ^= v.x & taken;
        fourth ^= w.x & taken;
        v = vec2u(v.y, v.y ^ v.x ^ (v.x << 2u));
        w = vec3u(w.yz, w.y ^ w.x ^ (w.x << 3u));
    }
    return vec4u(index, pascal(index), third, fourth);
}

// One point of a scrambled (0, 2)-sequence in an order of its own; `index` is its number with the bits
// reversed.
fn sobol_pair(index: u32, seeds: vec3u) -> vec2u {
    let ordered = reverseBits(owen_hash(index, seeds.x));
    return reverseBits(vec2u(owen_hash(ordered, seeds.y), owen_hash(pascal(ordered), seeds.z)));
}

fn owen_hash(digits: u32, seed: u32) -> u32 {
    var x = digits;
    x ^= x * 0x3d20adeau;
    x += seed;
    x *= (seed >> 16u) | 1u;
    x ^= x * 0x05526c56u;
    return x ^ (x * 0x53a22864u);
}

fn pascal(index: u32) -> u32 {
    var x = index;
    x ^= x >> 16u;
    x ^= (x & 0xff00ff00u) >> 8u;
    x ^= (x & 0xf0f0f0f0u) >> 4u;
    x ^= (x & 0xccccccccu) >> 2u;
    return x ^ ((x & 0xaaaaaaaau) >> 1u);
}

// Point `sample` of `count` correlated multi-jittered points.
fn multi_jittered_pair(sample: u32, count: u32, seeds: vec3u, jitter: vec2f) -> vec2u {
    // An adapter's square root may fall short of a whole number.
    var columns = u32(sqrt(f32(count)) + 0.5);
    columns -= u32(columns * columns > count);
    let rows = (count + columns - 1u) / columns;
    let s = permute(sample, count, seeds.x);
    let column = f32(permute(s % columns, columns, seeds.y));
    let row = f32(permute(s / columns, rows, seeds.z));
    let x = (column + (row + jitter.x) / f32(rows)) / f32(columns);
    let y = (f32(s) + jitter.y) / f32(count);
    return min(vec2u(vec2f(x, y) * 16777216.0), vec2u(0xffffffu)) << vec2u(8u);
}

// Where the permutation `seed` of 0..count takes `i`.
fn permute(start: u32, count: u32, seed: u32) -> u32 {
    let mask = 0xffffffffu >> min(countLeadingZeros(count - 1u), 31u);
    var i = start;
    loop {
        i ^= seed;
        i *= 0xe170893du;
        i ^= seed >> 16u;
        i ^= (i & mask) >> 4u;
        i ^= seed >> 8u;
        i *= 0x0929eb3fu;
        i ^= seed >> 23u;
        i ^= (i & mask) >> 1u;
        i *= 1u | (seed >> 27u);
        i *= 0x6935fa69u;
        i ^= (i & mask) >> 11u;
        i *= 0x74dcb303u;
        i ^= (i & mask) >> 2u;
        i *= 0x9e501cc3u;
        i ^= (i & mask) >> 2u;
        i *= 0xc860a3dfu;
        i &= mask;
        i ^= i >> 5u;
        if i < count {
            break;
        }
    }
    return (i + seed % count) % count;
}
