// The search over all objects: twin of world.rs. The module that uses it declares `objects`, `poses`,
// `meshes` and the constants `OBJECTS`, `SPHERES` and `PLANES`; the objects are spheres, planes, meshes.

const NOTHING: u32 = 0xffffffffu;
const FAR: f32 = 3.4e38;

struct Met {
    object: u32,
    distance: f32,
    face: u32,
    barycentrics: vec3f,
}

// The first thing that a ray meets; `start` is the sphere or plane on which it begins.
fn nearest(origin: vec3f, direction: vec3f, start: u32) -> Met {
    var met = Met(NOTHING, FAR, 0u, vec3f(0.0));
    // unroll
    for (var i = 0u; i < SPHERES; i++) {
        let distance = meet_sphere(objects[i], poses[i].centre, origin, direction, i == start);
        if (distance > 0.0) & (distance < met.distance) {
            met.object = i;
            met.distance = distance;
        }
    }
    // unroll
    for (var i = SPHERES; i < SPHERES + PLANES; i++) {
        // A ray that begins on a plane does not meet it.
        if i != start {
            let distance = meet_plane(objects[i], poses[i], origin, direction);
            if (distance > 0.0) & (distance < met.distance) {
                met.object = i;
                met.distance = distance;
            }
        }
    }
    // unroll
    for (var i = SPHERES + PLANES; i < OBJECTS; i++) {
        if may_meet(objects[i], poses[i].centre, origin, direction) {
            let begin = to_object(objects[i], poses[i], origin - poses[i].centre);
            let along = to_object(objects[i], poses[i], direction);
            let mesh = meshes[i - SPHERES - PLANES];
            let hit = mesh_nearest(mesh, begin, along, poses[i].time, vec2f(0.0, met.distance));
            if hit.face != MESH_NONE {
                met = Met(i, hit.distance, hit.face, hit.barycentrics);
            }
        }
    }
    return met;
}

// Whether a ray meets anything nearer than `far`.
fn is_met(origin: vec3f, direction: vec3f, far: f32, start: u32) -> bool {
    var met = false;
    // unroll
    for (var i = 0u; i < SPHERES; i++) {
        let distance = meet_sphere(objects[i], poses[i].centre, origin, direction, i == start);
        met |= (distance > 0.0) & (distance < far);
    }
    // unroll
    for (var i = SPHERES; i < SPHERES + PLANES; i++) {
        if i != start {
            let distance = meet_plane(objects[i], poses[i], origin, direction);
            met |= (distance > 0.0) & (distance < far);
        }
    }
    // unroll
    for (var i = SPHERES + PLANES; i < OBJECTS; i++) {
        if !met && may_meet(objects[i], poses[i].centre, origin, direction) {
            let begin = to_object(objects[i], poses[i], origin - poses[i].centre);
            let along = to_object(objects[i], poses[i], direction);
            met = mesh_any(meshes[i - SPHERES - PLANES], begin, along, poses[i].time, vec2f(0.0, far));
        }
    }
    return met;
}
