// Lights without extent: twin of light.rs.

struct Light {
    place: vec3f,
    is_point: u32,
    color: vec3f,
}

struct Arrival {
    direction: vec3f,
    distance: f32,
    irradiance: vec3f,
}

fn light_at(light: Light, point: vec3f) -> Arrival {
    if light.is_point == 0u {
        return Arrival(light.place, 3.4e38, light.color);
    }
    let offset = light.place - point;
    let squared = max(dot(offset, offset), 1e-12);
    let distance = sqrt(squared);
    return Arrival(offset / distance, distance, light.color / squared);
}
