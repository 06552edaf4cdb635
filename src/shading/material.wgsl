// Patterns of albedo: twin of material.rs.

struct Material {
    light: vec3f,
    kind: u32,
    dark: vec3f,
    frequency: f32,
    octaves: u32,
    contrast: f32,
    @align(16) picture: PictureRef,
}

const CONSTANT: u32 = 0u;
const CHECKER: u32 = 1u;
const NOISE: u32 = 2u;
const IMAGE: u32 = 3u;

// The albedo where the place of patterns is `n`, and u and v are `coordinates` or follow from n. The kind
// comes apart from the material, so that it can be a constant, which leaves its own branch alone.
fn material_albedo(kind: u32, material: Material, n: vec3f, is_given: bool, coordinates: vec2f) -> vec3f {
    if kind == CHECKER || kind == IMAGE {
        var at = coordinates;
        if !is_given {
            at = about_sphere(n);
            if kind == IMAGE {
                at.y *= 2.0;
            }
        }
        if kind == IMAGE {
            return picture_color(material.picture, at.x, at.y);
        }
        let cells = floor(material.frequency * at);
        let cell = cells.x + cells.y;
        return select(material.dark, material.light, 0.5 * cell == floor(0.5 * cell));
    }
    if kind == NOISE {
        let stretched = 0.5 + material.contrast * (fractal_noise(material, n) - 0.5);
        return material.dark + (material.light - material.dark) * clamp(stretched, 0.0, 1.0);
    }
    return material.light;
}

// The coordinates about a sphere: u, and half of v.
fn about_sphere(n: vec3f) -> vec2f {
    return vec2f(fract(atan2_turns(-n.z, n.x)), atan2_turns(sqrt(max(1.0 - n.y * n.y, 0.0)), n.y));
}

// Octaves of value noise, normalised to [0, 1].
fn fractal_noise(material: Material, n: vec3f) -> f32 {
    var sum = 0.0;
    var total = 0.0;
    var amplitude = 1.0;
    var frequency = material.frequency;
    for (var octave = 0u; octave < material.octaves; octave++) {
        sum += amplitude * value_noise(n * frequency, octave);
        total += amplitude;
        amplitude *= 0.5;
        frequency *= 2.0;
    }
    return sum / total;
}

// Random values at the points of the integer lattice, joined by smoothsteps.
fn value_noise(p: vec3f, octave: u32) -> f32 {
    let base = floor(p);
    let f = p - base;
    let w = f * f * (3.0 - 2.0 * f);
    let lattice = bitcast<vec3u>(vec3i(base));
    let along_x = mix(
        vec4f(
            lattice_value(lattice, octave),
            lattice_value(lattice + vec3u(0u, 1u, 0u), octave),
            lattice_value(lattice + vec3u(0u, 0u, 1u), octave),
            lattice_value(lattice + vec3u(0u, 1u, 1u), octave),
        ),
        vec4f(
            lattice_value(lattice + vec3u(1u, 0u, 0u), octave),
            lattice_value(lattice + vec3u(1u, 1u, 0u), octave),
            lattice_value(lattice + vec3u(1u, 0u, 1u), octave),
            lattice_value(lattice + vec3u(1u, 1u, 1u), octave),
        ),
        w.x,
    );
    let along_y = mix(along_x.xz, along_x.yw, w.y);
    return mix(along_y.x, along_y.y, w.z);
}

fn lattice_value(lattice: vec3u, octave: u32) -> f32 {
    let scaled = lattice * vec3u(73856093u, 19349663u, 83492791u);
    var h = scaled.x ^ scaled.y ^ scaled.z ^ (octave * 0x9e3779b9u);
    h = (h ^ (h >> 16u)) * 0x7feb352du;
    h = (h ^ (h >> 15u)) * 0x846ca68bu;
    return unit(h ^ (h >> 16u));
}
