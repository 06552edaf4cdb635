// Moving triangles in homogeneous coordinates: twin of motion.rs. The module that uses it declares `geometry` and
// the constants `TILE` and `LAYERS`.

// Nearer to the camera's plane nothing is seen.
const NEAR: f32 = 1e-6;

// A part of the shutter interval in which every vertex of an object goes straight and evenly.
struct Segment {
    // From the object's own space to (x·z, y·z, z), as the segment begins and as it ends.
    to_image: mat4x3f,
    to_image_at_end: mat4x3f,
    // Where between its two poses a mesh is then.
    poses: vec2f,
    // How many of the object's segments come before, and how many there are.
    before: f32,
    count: f32,
    object: u32,
    triangles: u32,
    faces: u32,
    vertices: u32,
    end_vertices: u32,
    // The first of the workgroups that put its triangles into tiles.
    first_group: u32,
}

// What tiles are put together with.
struct Band {
    // Tiles per row; the first that is drawn; and the rows that are drawn together.
    columns: u32,
    first_column: u32,
    first_row: u32,
    end_row: u32,
    // 1 if entries are written, 0 if they are only counted.
    fills: u32,
    // What is nearest, and layers of depth per metre behind it.
    nearest: f32,
    layers_per_m: f32,
    // How far a point at depth z is moved at most by where on the lens it is seen from, in (x·z, y·z): the first, times
    // 1 − z times the second.
    blur_px: f32,
    inverse_focus: f32,
}

// (x·z, y·z, z) of the corners, one in each column, as a segment begins and as it ends.
struct MovingTriangle {
    start: mat3x3f,
    end: mat3x3f,
}

fn moving_triangle(segment: Segment, face: u32) -> MovingTriangle {
    let corners = geometry[segment.faces + face].xyz;
    var moving: MovingTriangle;
    for (var k = 0u; k < 3u; k++) {
        let vertex = segment.vertices + corners[k];
        let end_vertex = segment.end_vertices + corners[k];
        moving.start[k] = to_image(segment.to_image, mesh_vector(vertex, end_vertex, segment.poses.x).xyz);
        moving.end[k] = to_image(segment.to_image_at_end, mesh_vector(vertex, end_vertex, segment.poses.y).xyz);
    }
    return moving;
}

// In the order of the twin's sums.
fn to_image(matrix: mat4x3f, p: vec3f) -> vec3f {
    return matrix[0] * p.x + matrix[1] * p.y + matrix[2] * p.z + matrix[3];
}

// Depth of what of the triangle is seen at `time` at a point of the image, from whichever side; or −1. `near` is by how
// much all places in (x·z, y·z) are moved.
fn hit(moving: MovingTriangle, point: vec2f, near: vec2f, time: f32) -> f32 {
    let p = moving.start[0] + (moving.end[0] - moving.start[0]) * time;
    let q = moving.start[1] + (moving.end[1] - moving.start[1]) * time;
    let r = moving.start[2] + (moving.end[2] - moving.start[2]) * time;
    let a = p.xy + near - point * p.z;
    let b = q.xy + near - point * q.z;
    let c = r.xy + near - point * r.z;
    let edges = vec3f(b.x * c.y - b.y * c.x, c.x * a.y - c.y * a.x, a.x * b.y - a.y * b.x);
    let sum = edges.x + edges.y + edges.z;
    let is_inside = all(edges >= vec3f(0.0)) | all(edges <= vec3f(0.0));
    let weights = edges * (1.0 / select(sum, 1.0, sum == 0.0));
    let depth = p.z * weights.x + q.z * weights.y + r.z * weights.z;
    return select(-1.0, depth, is_inside & (sum != 0.0) & (depth > NEAR));
}
