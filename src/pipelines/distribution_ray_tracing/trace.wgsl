// Distribution ray tracing of the rolling sphere: twin of reference.rs, line by line.

struct FrameParams {
    camera_position: vec3f,
    width: u32,
    camera_forward: vec3f,
    height: u32,
    camera_right: vec3f,
    focal_length_px: f32,
    camera_up: vec3f,
    sphere_radius: f32,
    rolling_x: f32,
    rolling_travel: f32,
    rolling_turns: f32,
    rolling_bounce: f32,
    floor_albedo: f32,
    floor_half_side: f32,
    first_sample: u32,
    sample_count: u32,
    key: vec2u,
    strata: u32,
    sampler: u32,
    shutter_kind: u32,
    shutter_width: f32,
    shutter_reach: f32,
    shift_px: f32,
    material: Material,
}

const MAX_HITS: u32 = 5u;

// What a ray meets, and what it comes from.
const NOTHING: u32 = 0u;
const FLOOR: u32 = 1u;
const SPHERE: u32 = 2u;

struct Hit {
    surface: u32,
    distance: f32,
}

@group(0) @binding(0) var<uniform> frame_params: FrameParams;
@group(0) @binding(1) var<uniform> environment_params: Environment;
@group(0) @binding(2) var<storage, read> environment_texels: array<u32>;
@group(0) @binding(3) var<storage, read> environment_parts: array<vec4f>;
// Per pixel: Σ radiance, and Σ luminance².
@group(0) @binding(4) var<storage, read_write> sums: array<vec4f>;

// Copies, read once per invocation: the software adapter would gather each use of a uniform buffer lane
// by lane, anew for every sample.
var<private> frame: FrameParams;
var<private> environment: Environment;

@compute @workgroup_size(8, 8)
fn trace(@builtin(global_invocation_id) id: vec3u) {
    frame = frame_params;
    environment = environment_params;
    if id.x >= frame.width || id.y >= frame.height {
        return;
    }
    let pixel = id.y * frame.width + id.x;
    var sum = sums[pixel];
    for (var i = 0u; i < frame.sample_count; i++) {
        let radiance = path_radiance(id.x, id.y, pixel, frame.first_sample + i);
        let y = dot(radiance, LUMINANCE);
        sum += vec4f(radiance, y * y);
    }
    sums[pixel] = sum;
}

// Radiance along one path through pixel (x, y).
fn path_radiance(x: u32, y: u32, pixel: u32, sample: u32) -> vec3f {
    let first = first_blocks(frame.key, frame.strata, pixel, sample);
    let start = first.start;
    let rolled = rolling_at(
        frame.rolling_x, frame.rolling_travel, frame.rolling_turns, frame.rolling_bounce,
        shutter_instant(frame.shutter_width, frame.shutter_reach, unit(start.z)), frame.sphere_radius,
    );
    let center = vec3f(rolled.x, frame.sphere_radius, 0.0);

    let right = (f32(x) + unit(start.x) - 0.5 * f32(frame.width) - frame.shift_px) / frame.focal_length_px;
    let down = (f32(y) + unit(start.y) - 0.5 * f32(frame.height)) / frame.focal_length_px;
    var origin = frame.camera_position;
    var direction = normalize(frame.camera_forward + frame.camera_right * right - frame.camera_up * down);

    var radiance = vec3f(0.0);
    var throughput = vec3f(1.0);
    // The camera's own ray has no light sample to share with.
    var cosine_density = -1.0;
    var met = intersect(center, origin, direction, NOTHING);
    var hit = 0u;
    var words = first.hit;
    // The loop ends at its bottom: where the software adapter would meet the end of the last lane at the
    // top, it would go through the body once more for nobody.
    if met.surface != NOTHING {
        loop {
            origin += direction * met.distance;
            var normal = vec3f(0.0, 1.0, 0.0);
            var albedo = vec3f(frame.floor_albedo);
            if met.surface == FLOOR {
                origin.y = 0.0;
            } else {
                normal = (origin - center) / frame.sphere_radius;
                albedo = material_albedo(frame.material, rotate_about_z(normal, rolled.y));
            }
            throughput *= albedo;

            let light = environment_sample(words.xy);
            let cosine = dot(normal, light.direction);
            if cosine > 0.0 && intersect(center, origin, light.direction, met.surface).surface == NOTHING {
                let density = light.density + cosine / PI;
                radiance += throughput * light.radiance * (cosine / PI / density);
            }

            direction = cosine_hemisphere(normal, vec2f(unit(words.z), unit(words.w)));
            cosine_density = max(dot(normal, direction), 0.0) / PI;
            met = intersect(center, origin, direction, met.surface);
            hit++;
            words = random_words(frame.key, pixel, sample, 1u + hit);
            if hit == MAX_HITS || met.surface == NOTHING {
                break;
            }
        }
    }
    if met.surface == NOTHING {
        let is_camera_ray = cosine_density < 0.0;
        let tent = vec2f(vec2u(start.w >> 16u, start.w & 0xffffu)) / 65536.0 - 0.5;
        let light = environment_evaluate(direction, select(vec2f(0.0), tent, is_camera_ray));
        // A direction along the surface may meet black: nothing over nothing.
        let shared_weight = cosine_density / max(cosine_density + light.w, 1e-30);
        radiance += throughput * light.xyz * select(shared_weight, 1.0, is_camera_ray);
    }
    return radiance;
}

// The nearest surface that a ray meets, and how far away.
fn intersect(center: vec3f, origin: vec3f, direction: vec3f, came_from: u32) -> Hit {
    if came_from != SPHERE {
        let to_center = center - origin;
        let along = dot(to_center, direction);
        let across = to_center - direction * along;
        let discriminant = frame.sphere_radius * frame.sphere_radius - dot(across, across);
        if along > 0.0 && discriminant > 0.0 {
            return Hit(SPHERE, along - sqrt(discriminant));
        }
    }
    if came_from != FLOOR && direction.y < 0.0 {
        let distance = -origin.y / direction.y;
        let at = abs(origin + direction * distance);
        if at.x <= frame.floor_half_side && at.z <= frame.floor_half_side {
            return Hit(FLOOR, distance);
        }
    }
    return Hit(NOTHING, 0.0);
}

// Turns a world-space vector of a sphere that has rolled by `turns` about −z into object space.
fn rotate_about_z(v: vec3f, turns: f32) -> vec3f {
    let turn = sin_cos_turns(fract(turns));
    return vec3f(turn.y * v.x - turn.x * v.y, turn.x * v.x + turn.y * v.y, v.z);
}
