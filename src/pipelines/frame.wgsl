// A frame of a stimulus: twin of frame.rs; and what all shaders of frames bind, in the order of resources.rs. The module
// that uses it declares the constants of a `Variant`.

struct FrameParams {
    camera: Camera,
    width: u32,
    height: u32,
    first_sample: u32,
    sample_count: u32,
    key: vec2u,
    strata: u32,
    sampler: u32,
    shutter_kind: u32,
    shutter_width: f32,
    shutter_reach: f32,
    is_local: u32,
    first_pixel: vec2u,
}

@group(0) @binding(0) var<uniform> frame_params: FrameParams;
@group(0) @binding(1) var<uniform> object_params: array<Object, OBJECTS>;
@group(0) @binding(2) var<uniform> material_params: array<Material, OBJECTS>;
@group(0) @binding(3) var<uniform> environment_params: Environment;
@group(0) @binding(4) var<uniform> bsdf_params: array<Bsdf, OBJECTS>;
@group(0) @binding(5) var<uniform> lights: array<Light, max(LIGHTS, 1u)>;
@group(0) @binding(6) var<uniform> mesh_params: array<MeshRange, max(MESHES, 1u)>;
// Pictures, then meshes.
@group(0) @binding(7) var<storage, read> geometry: array<vec4u>;
@group(0) @binding(8) var<storage, read> environment_texels: array<u32>;
// Per pixel: Σ radiance, and Σ luminance².
@group(0) @binding(9) var<storage, read_write> sums: array<vec4f>;
// For global illumination alone.
@group(0) @binding(10) var<storage, read> environment_parts: array<vec4f>;

// Copies, read once per invocation: the software adapter would gather each use of a uniform buffer lane
// by lane, anew for every sample.
var<private> frame: FrameParams;
var<private> objects: array<Object, OBJECTS>;
var<private> materials: array<Material, OBJECTS>;
var<private> environment: Environment;
var<private> bsdfs: array<Bsdf, OBJECTS>;
var<private> meshes: array<MeshRange, max(MESHES, 1u)>;

// Where the objects are at the instant of a sample.
var<private> poses: array<Pose, OBJECTS>;

fn read_frame() {
    frame = frame_params;
    objects = object_params;
    materials = material_params;
    environment = environment_params;
    bsdfs = bsdf_params;
    meshes = mesh_params;
}

// The point of the lens, a unit disk, that a sample is seen from: twin of `FrameParams::lens`.
fn lens_of(pixel: u32, sample: u32) -> vec2f {
    if !HAS_LENS {
        return vec2f(0.0);
    }
    let words = lens_words(frame.key, frame.strata, pixel, sample);
    return concentric_disk(vec2f(unit(words.x), unit(words.y)));
}

// Where a sample looks the environment up beside its direction: twin of `tent`.
fn tent(word: u32) -> vec2f {
    return vec2f(vec2u(word >> 16u, word & 0xffffu)) / 65536.0 - 0.5;
}

// Adds a sample of a pixel to its sum.
fn with_sample(sum: vec4f, radiance: vec3f) -> vec4f {
    let y = dot(radiance, LUMINANCE);
    return sum + vec4f(radiance, y * y);
}

// Radiance of what a ray of the camera meets, in the light of the lights alone.
fn local_radiance(met: Met, origin: vec3f, direction: vec3f, tent: vec2f) -> vec3f {
    if met.object == NOTHING {
        return environment_evaluate(direction, tent).xyz;
    }
    return from_lights(surface_where(met, origin, direction), -direction);
}
