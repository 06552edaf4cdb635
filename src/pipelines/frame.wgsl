// A frame of a stimulus: twin of frame.rs.

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
}

// Radiance of what a ray of the camera meets, in the light of the lights alone.
fn local_radiance(met: Met, origin: vec3f, direction: vec3f, tent: vec2f) -> vec3f {
    if met.object == NOTHING {
        return environment_evaluate(direction, tent).xyz;
    }
    return from_lights(surface_where(met, origin, direction), -direction);
}
