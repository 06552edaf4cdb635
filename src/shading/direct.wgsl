// Light straight from the lights: twin of direct.rs. The module that uses it declares `lights`, the constants
// `LIGHTS`, `COATS` and `IS_LOCAL`, and `is_met` as world.wgsl has it.

// What the lights send to the viewer by way of a surface.
fn from_lights(surface: Surface, to_viewer: vec3f) -> vec3f {
    var radiance = vec3f(0.0);
    for (var i = 0u; i < LIGHTS; i++) {
        let arrival = light_at(lights[i], surface.point);
        let value = reflected(surface, to_viewer, arrival.direction).xyz;
        if any(value != vec3f(0.0)) && is_lit(surface, arrival.direction, arrival.distance) {
            radiance += value * arrival.irradiance;
        }
    }
    return radiance;
}

// As bsdf_evaluate.
fn reflected(surface: Surface, to_viewer: vec3f, to_light: vec3f) -> vec4f {
    if COATS {
        return bsdf_evaluate(surface.bsdf, surface.albedo, surface.normal, to_viewer, to_light);
    }
    let density = max(dot(surface.normal, to_light), 0.0) / PI;
    return vec4f(surface.albedo * density, density);
}

fn is_lit(surface: Surface, to_light: vec3f, distance: f32) -> bool {
    return dot(surface.face_normal, to_light) > 0.0
        && (IS_LOCAL || !is_met(surface.point, to_light, distance, surface.start));
}
