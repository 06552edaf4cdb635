// Which triangle is seen in each pixel at an instant.

struct Place {
    // From the object's own space to clip space.
    to_clip: mat4x4f,
    object: u32,
    // Where its triangles begin, as `MeshRange` has it.
    faces: u32,
    vertices: u32,
    end_vertices: u32,
    // Between its two poses.
    time: f32,
}

struct Corner {
    @builtin(position) position: vec4f,
    @location(0) @interpolate(flat, either) seen: vec2u,
}

@group(0) @binding(0) var<uniform> place: Place;
@group(0) @binding(1) var<storage, read> geometry: array<vec4u>;

@vertex
fn corner(@builtin(vertex_index) index: u32) -> Corner {
    let face = index / 3u;
    let vertex = geometry[place.faces + face][index % 3u];
    let at = mesh_vector(place.vertices + vertex, place.end_vertices + vertex, place.time).xyz;
    return Corner(place.to_clip * vec4f(at, 1.0), vec2u(place.object, face));
}

// One more than the object, as 0 is nothing.
@fragment
fn see(corner: Corner) -> @location(0) vec2u {
    return corner.seen + vec2u(1u, 0u);
}
