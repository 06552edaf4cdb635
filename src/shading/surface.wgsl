// What a path finds where it meets something: twin of surface.rs. The module that uses it declares
// `objects`, `materials`, `bsdfs`, `poses`, `meshes`, `geometry` and the constants `OBJECTS`,
// `MANY_OBJECTS`, `SPHERES`, `PLANES` and `KINDS`.

struct Surface {
    point: vec3f,
    normal: vec3f,
    face_normal: vec3f,
    albedo: vec3f,
    bsdf: Bsdf,
    // The sphere or plane that the point is on.
    start: u32,
}

// What rounding can move a point of a mesh, as part of its largest coordinate.
const SLACK: f32 = 4e-6;

fn surface_where(met: Met, origin: vec3f, direction: vec3f) -> Surface {
    if MANY_OBJECTS {
        return surface_of(met.object, met, origin, direction);
    }
    // Unrolled, all that is known of an object when the shader is built is known to its copy.
    var surface: Surface;
    // unroll
    for (var i = 0u; i < OBJECTS; i++) {
        if i == met.object {
            surface = surface_of(i, met, origin, direction);
        }
    }
    return surface;
}

fn surface_of(i: u32, met: Met, origin: vec3f, direction: vec3f) -> Surface {
    let point = origin + direction * met.distance;
    if i < SPHERES {
        let outward = normalize_or(point - poses[i].centre, vec3f(0.0, 1.0, 0.0));
        let on_sphere = poses[i].centre + outward * objects[i].size;
        let normal = facing(outward, direction);
        var n = outward;
        if KINDS[i] != CONSTANT {
            n = to_object(objects[i], poses[i], outward);
        }
        let albedo = material_albedo(KINDS[i], materials[i], n, false, vec2f(0.0));
        return Surface(on_sphere, normal, normal, albedo, bsdfs[i], i);
    }
    if i >= SPHERES + PLANES {
        return surface_of_mesh(i, met, direction);
    }
    let up = plane_normal(objects[i], poses[i]);
    let offset = point - poses[i].centre;
    let normal = facing(up, direction);
    var n = offset;
    if KINDS[i] != CONSTANT {
        n = to_plane(objects[i], poses[i], offset) / objects[i].size;
    }
    let albedo = material_albedo(KINDS[i], materials[i], n, true, 0.5 * n.xz + 0.5);
    return Surface(point - up * dot(up, offset), normal, normal, albedo, bsdfs[i], i);
}

fn surface_of_mesh(i: u32, met: Met, direction: vec3f) -> Surface {
    let mesh = meshes[i - SPHERES - PLANES];
    let corners = mesh_corners(mesh, met.face, poses[i].time);
    let local = corners * met.barycentrics;
    let across = cross(corners[1] - corners[0], corners[2] - corners[0]);
    let face = to_world(objects[i], poses[i], normalize_or(across, vec3f(0.0, 1.0, 0.0)));
    let face_normal = facing(face, direction);
    var normal = face_normal;
    let vertices = geometry[mesh.faces + met.face];
    if mesh.normals != MESH_NONE {
        let sum = weighted(mesh.normals, vertices.xyz, met.barycentrics);
        var smoothed = to_world(objects[i], poses[i], normalize_or(sum, vec3f(0.0)));
        smoothed = select(smoothed, -smoothed, dot(smoothed, face_normal) < 0.0);
        // What turns away from the viewer would be black: there the face itself is seen.
        normal = select(face_normal, smoothed, dot(smoothed, direction) < 0.0);
    }
    var coordinates = vec2f(0.0);
    let is_given = mesh.texture_coordinates != MESH_NONE;
    if is_given {
        let at = weighted(mesh.texture_coordinates, vertices.xyz, met.barycentrics);
        coordinates = vec2f(at.x, 1.0 - at.y);
    }
    // Patterns stick to the surface: they are those of the first pose.
    let first = weighted(mesh.vertices, vertices.xyz, met.barycentrics);
    let n = normalize_or(first, vec3f(0.0, 1.0, 0.0));
    var albedo = material_albedo(KINDS[i], materials[i], n, is_given, coordinates);
    if mesh.materials != MESH_NONE {
        let at = mesh.materials + 2u * vertices.w;
        let picture = PictureRef(geometry[at].w, geometry[at + 1u].x, geometry[at + 1u].y);
        albedo *= bitcast<vec3f>(geometry[at].xyz) * picture_color(picture, coordinates.x, coordinates.y);
    }
    let place = poses[i].centre + to_world(objects[i], poses[i], local);
    let reach = max(abs(place), abs(local));
    let slack = SLACK * max(reach.x, max(reach.y, reach.z));
    return Surface(place + face_normal * slack, normal, face_normal, albedo, bsdfs[i], NOTHING);
}

// The mean of three vectors of a mesh with weights.
fn weighted(first: u32, vertices: vec3u, weights: vec3f) -> vec3f {
    return bitcast<vec4f>(geometry[first + vertices.x]).xyz * weights.x
        + bitcast<vec4f>(geometry[first + vertices.y]).xyz * weights.y
        + bitcast<vec4f>(geometry[first + vertices.z]).xyz * weights.z;
}

// `normal` on the side that a ray in `direction` comes from.
fn facing(normal: vec3f, direction: vec3f) -> vec3f {
    return select(normal, -normal, dot(normal, direction) > 0.0);
}
