// The search of mesh hierarchies: twin of bvh.rs and ray.rs, over the buffer of upload.rs, which the
// pipeline declares as `geometry: array<vec4u>`.
//
// Two things differ from the twin. Where an edge function is 0 in single precision there is no double
// precision to ask, and 0 counts as inside: a ray within rounding of an edge meets the triangles on both
// sides of it, so nothing is lost, but which of the two is told may differ. And boxes that a ray enters
// within four units in the last place of one another may be searched in another order. A driver that
// fuses a product and a sum, which WGSL allows and Mesa's software adapter does not do, lets
// neighbours round their common edge apart, and a ray may slip through within the last bit.
//
// Directions are about as long as 1, by some powers of ten; origins are within 4e9 of 0.
//
// The module that uses it declares the constant `MESHES_MOVE`: whether any mesh has a second pose. Where
// none has, it is not read.

// In place of what there is not: a part of a mesh, or the face of a hit.
const MESH_NONE: u32 = 0xffffffffu;
const MESH_LEAF: u32 = 0x80000000u;
// One more than a search fills, since a place is written before it is known to be needed.
const MESH_STACK: u32 = 49u;
const MESH_FAR: f32 = 3e38;
const MESH_EPSILON: f32 = 1.1920929e-7;

struct MeshRange {
    min: vec3f,
    nodes: u32,
    max: vec3f,
    end_nodes: u32,
    leaves: u32,
    end_leaves: u32,
    faces: u32,
    vertices: u32,
    end_vertices: u32,
    normals: u32,
    texture_coordinates: u32,
    materials: u32,
}

struct MeshHit {
    // The triangle, as the mesh counts them, or MESH_NONE.
    face: u32,
    // In lengths of the ray's direction.
    distance: f32,
    barycentrics: vec3f,
}

// RayFrame of ray.rs.
struct MeshRay {
    axes: vec3u,
    origin: vec3f,
    shear: vec3f,
    inverse_direction: vec3f,
    origin_for_near: vec3f,
    origin_for_far: vec3f,
}

// The first triangle that the ray meets between the two distances.
fn mesh_nearest(mesh: MeshRange, origin: vec3f, direction: vec3f, time: f32, between: vec2f) -> MeshHit {
    return mesh_search(mesh, origin, direction, time, between, false);
}

// Whether the ray meets a triangle between the two distances.
fn mesh_any(mesh: MeshRange, origin: vec3f, direction: vec3f, time: f32, between: vec2f) -> bool {
    return mesh_search(mesh, origin, direction, time, between, true).face != MESH_NONE;
}

// The corners of a triangle at an instant of the shutter, one in each column.
fn mesh_corners(mesh: MeshRange, face: u32, time: f32) -> mat3x3f {
    let vertices = geometry[mesh.faces + face].xyz;
    return mat3x3f(
        mesh_vector(mesh.vertices + vertices.x, mesh.end_vertices + vertices.x, time).xyz,
        mesh_vector(mesh.vertices + vertices.y, mesh.end_vertices + vertices.y, time).xyz,
        mesh_vector(mesh.vertices + vertices.z, mesh.end_vertices + vertices.z, time).xyz,
    );
}

// What lies at `start` and, as the shutter closes, at `end`, which is the same place for a mesh at rest.
fn mesh_vector(start: u32, end: u32, time: f32) -> vec4f {
    let opening = bitcast<vec4f>(geometry[start]);
    if !MESHES_MOVE {
        return opening;
    }
    let closing = bitcast<vec4f>(geometry[end]);
    return select(opening * (1.0 - time) + closing * time, opening, start == end);
}

fn mesh_ray(mesh: MeshRange, origin: vec3f, direction: vec3f) -> MeshRay {
    let size = abs(direction);
    let is_x = size.x >= size.y && size.x >= size.z;
    let z = select(select(2u, 1u, size.y >= size.z), 0u, is_x);
    let next = select(z + 1u, 0u, z == 2u);
    let last = select(z - 1u, 2u, z == 0u);
    let axes = vec3u(select(vec2u(next, last), vec2u(last, next), direction[z] < 0.0), z);
    let turned = vec3f(direction[axes.x], direction[axes.y], direction[z]);
    let extent = max(abs(mesh.min - origin), abs(mesh.max - origin));
    let slack = max(extent.x, max(extent.y, extent.z)) * (10.0 * 0.5 * MESH_EPSILON);
    // Finite, so that a ray along a face of a box gives 0 there and not 0·∞.
    let inverse = 1.0 / select(direction, vec3f(1e-28), size < vec3f(1e-28));
    let ahead = select(vec3f(slack), vec3f(-slack), inverse < vec3f(0.0));
    return MeshRay(
        axes,
        vec3f(origin[axes.x], origin[axes.y], origin[z]),
        vec3f(turned.xy, 1.0) / turned.z,
        inverse,
        origin + ahead,
        origin - ahead,
    );
}

fn mesh_search(
    mesh: MeshRange, origin: vec3f, direction: vec3f, time: f32, between: vec2f, any: bool,
) -> MeshHit {
    let ray = mesh_ray(mesh, origin, direction);
    var hit = MeshHit(MESH_NONE, min(between.y, MESH_FAR), vec3f(0.0));
    // What is to be searched, the nearest on top. The twin also keeps where the ray enters it, to pass it by
    // once something nearer is hit; writing that down here costs what it saves.
    var children: array<u32, MESH_STACK>;
    var height = 0u;
    var child = 0u;
    // Loops end at their bottom, and all rays that are searched side by side go down to a leaf before
    // any looks into it: the software adapter goes through both sides of an `if`.
    loop {
        loop {
            if (child & MESH_LEAF) == 0u {
                let entered = mesh_enter(mesh, ray, child, time, vec2f(between.x, hit.distance));
                let below = geometry[mesh.nodes + 7u * child + 6u];
                // Farthest first. A place without a child is written and not kept.
                children[height] = mesh_pick(below, entered.w);
                height += select(1u, 0u, entered.w == MESH_NONE);
                children[height] = mesh_pick(below, entered.z);
                height += select(1u, 0u, entered.z == MESH_NONE);
                children[height] = mesh_pick(below, entered.y);
                height += select(1u, 0u, entered.y == MESH_NONE);
                child = mesh_pick(below, entered.x);
                if entered.x == MESH_NONE {
                    child = MESH_NONE;
                    if height > 0u {
                        height--;
                        child = children[height];
                    }
                }
            }
            if (child & MESH_LEAF) != 0u {
                break;
            }
        }
        if child != MESH_NONE {
            mesh_meet(mesh, ray, child & ~MESH_LEAF, time, between.x, &hit);
            child = MESH_NONE;
            if any && hit.face != MESH_NONE {
                height = 0u;
            }
            if height > 0u {
                height--;
                child = children[height];
            }
        }
        if child == MESH_NONE {
            break;
        }
    }
    return hit;
}

// The children that a ray enters, in the order in which it does: the bits of where it enters, with the
// child's lane in the last two. MESH_NONE for the others.
fn mesh_enter(mesh: MeshRange, ray: MeshRay, node: u32, time: f32, between: vec2f) -> vec4u {
    let at = 7u * node;
    let x = mesh_slab(mesh, ray, at, 0u, time);
    let y = mesh_slab(mesh, ray, at, 1u, time);
    let z = mesh_slab(mesh, ray, at, 2u, time);
    let near = max(max(x[0], y[0]), max(z[0], vec4f(between.x)));
    let far = min(min(x[1], y[1]), min(z[1], vec4f(between.y)));
    let keys = (bitcast<vec4u>(near) & vec4u(~3u)) | vec4u(0u, 1u, 2u, 3u);
    let entered = select(vec4u(MESH_NONE), keys, near <= far * (1.0 + 3.0 * MESH_EPSILON));
    // Numbers that are not negative are in the order of their bits.
    let low = min(entered.xz, entered.yw);
    let high = max(entered.xz, entered.yw);
    let middle = vec2u(max(low.x, low.y), min(high.x, high.y));
    return vec4u(
        min(low.x, low.y),
        min(middle.x, middle.y),
        max(middle.x, middle.y),
        max(high.x, high.y),
    );
}

// Where a ray enters and leaves the slabs of four boxes along an axis.
fn mesh_slab(mesh: MeshRange, ray: MeshRay, node: u32, axis: u32, time: f32) -> mat2x4f {
    let inverse = ray.inverse_direction[axis];
    let first = node + select(axis, axis + 3u, inverse < 0.0);
    let last = node + select(axis + 3u, axis, inverse < 0.0);
    let enters = mesh_vector(mesh.nodes + first, mesh.end_nodes + first, time);
    let leaves = mesh_vector(mesh.nodes + last, mesh.end_nodes + last, time);
    return mat2x4f(
        (enters - ray.origin_for_near[axis]) * inverse,
        (leaves - ray.origin_for_far[axis]) * inverse,
    );
}

// The element of `all` in the lane that the last two bits of `key` tell.
fn mesh_pick(all: vec4u, key: u32) -> u32 {
    let pair = select(all.xy, all.zw, (key & 2u) != 0u);
    return select(pair.x, pair.y, (key & 1u) != 0u);
}

// Lets `hit` be the ray's hit with a triangle of a leaf, where it is nearer.
fn mesh_meet(mesh: MeshRange, ray: MeshRay, leaf: u32, time: f32, near: f32, hit: ptr<function, MeshHit>) {
    let at = 10u * leaf;
    let a = mesh_corner(mesh, ray, at, time);
    let b = mesh_corner(mesh, ray, at + 3u, time);
    let c = mesh_corner(mesh, ray, at + 6u, time);
    let u = c[0] * b[1] - c[1] * b[0];
    let v = a[0] * c[1] - a[1] * c[0];
    let w = b[0] * a[1] - b[1] * a[0];
    let determinant = u + v + w;
    let least = min(min(u, v), w);
    let most = max(max(u, v), w);
    let flat = determinant == vec4f(0.0);
    let divisor = select(determinant, vec4f(1.0), flat);
    let distance = (u * a[2] + v * b[2] + w * c[2]) / divisor;
    let inside = (least >= vec4f(0.0)) | (most <= vec4f(0.0));
    let met = inside & !flat & (distance > vec4f(near));
    let distances = select(vec4f(MESH_FAR), distance, met);
    let nearest = min(min(distances.x, distances.y), min(distances.z, distances.w));
    if nearest < (*hit).distance {
        let lane = select(
            select(2u, 3u, distances.z > nearest),
            select(0u, 1u, distances.x > nearest),
            min(distances.x, distances.y) == nearest,
        );
        (*hit).face = mesh_pick(geometry[mesh.leaves + at + 9u], lane);
        (*hit).distance = nearest;
        let edges = vec3u(
            mesh_pick(bitcast<vec4u>(u), lane),
            mesh_pick(bitcast<vec4u>(v), lane),
            mesh_pick(bitcast<vec4u>(w), lane),
        );
        (*hit).barycentrics =
            bitcast<vec3f>(edges) / bitcast<f32>(mesh_pick(bitcast<vec4u>(determinant), lane));
    }
}

// A corner of the four triangles of a leaf: across, across and along the ray from its origin.
fn mesh_corner(mesh: MeshRange, ray: MeshRay, corner: u32, time: f32) -> mat3x4f {
    let at = corner + ray.axes;
    let x = mesh_vector(mesh.leaves + at.x, mesh.end_leaves + at.x, time) - ray.origin.x;
    let y = mesh_vector(mesh.leaves + at.y, mesh.end_leaves + at.y, time) - ray.origin.y;
    let z = mesh_vector(mesh.leaves + at.z, mesh.end_leaves + at.z, time) - ray.origin.z;
    return mat3x4f(x - ray.shear.x * z, y - ray.shear.y * z, ray.shear.z * z);
}
