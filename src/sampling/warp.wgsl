// Warps of uniform numbers into directions: twin of warp.rs.

const PI: f32 = 3.14159265;
const LUMINANCE = vec3f(0.2126, 0.7152, 0.0722);

// (sin 2πu, cos 2πu) for u ∈ [0, 1].
fn sin_cos_turns(u: f32) -> vec2f {
    let quarter = floor(4.0 * u + 0.5);
    let a = (4.0 * u - quarter) * (0.5 * PI);
    let a2 = a * a;
    let s = a * (1.0 + a2 * (-1.0 / 6.0 + a2 * (1.0 / 120.0 + a2 * (-1.0 / 5040.0))));
    let c = 1.0 + a2 * (-0.5 + a2 * (1.0 / 24.0 + a2 * (-1.0 / 720.0 + a2 * (1.0 / 40320.0))));
    let q = u32(quarter);
    let turned = select(vec2f(s, c), vec2f(c, -s), (q & 1u) == 1u);
    return select(turned, -turned, (q & 2u) == 2u);
}

// The angle of (x, y) in turns, from −½ to ½.
fn atan2_turns(y: f32, x: f32) -> f32 {
    let a = min(abs(x), abs(y)) / max(max(abs(x), abs(y)), 1e-30);
    let s = a * a;
    let upper = 0.015706787 + s * (-0.009363046 + s * (0.003784787 + s * -0.0007257134));
    let eighth = a * (0.15915492 + s * (-0.05304923 + s * (0.031778406 + s * (-0.02228693 + s * upper))));
    let quarter = select(eighth, 0.25 - eighth, abs(y) > abs(x));
    let half = select(quarter, 0.5 - quarter, x < 0.0);
    return select(half, -half, y < 0.0);
}

// A direction about the unit normal n with density cos θ / π per steradian.
fn cosine_hemisphere(n: vec3f, u: vec2f) -> vec3f {
    let z = 1.0 - 2.0 * u.x;
    let r = sqrt(max(1.0 - z * z, 0.0));
    let turn = sin_cos_turns(u.y);
    let sum = n + vec3f(r * turn.y, r * turn.x, z);
    let length_squared = dot(sum, sum);
    if length_squared < 1e-12 {
        return n;
    }
    return sum * (1.0 / sqrt(length_squared));
}

// A uniform point of the unit disk; squares about the middle of [0, 1)² become circles.
fn concentric_disk(u: vec2f) -> vec2f {
    let p = 2.0 * u - 1.0;
    var radius = p.x;
    var turns = 0.0;
    if abs(p.x) > abs(p.y) {
        turns = 0.125 * (p.y / p.x);
    } else if p.y != 0.0 {
        radius = p.y;
        turns = 0.25 - 0.125 * (p.x / p.y);
    }
    return radius * sin_cos_turns(turns).yx;
}
