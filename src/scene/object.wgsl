// Objects of a scene during one frame: twin of object.rs. The module that uses it declares the constants
// `PLANES_TURN` and `PLANES_TILT`.

struct Object {
    to_axis: mat3x3f,
    from_axis: mat3x3f,
    position: vec3f,
    size: f32,
    direction: vec3f,
    distance: f32,
    travel: f32,
    bounce: f32,
    turns: f32,
    turns_per_m: f32,
    pose: f32,
    poses_per_m: f32,
}

struct Pose {
    centre: vec3f,
    turns: f32,
    time: f32,
}

// Where it is when the part `shutter` ∈ [−½, ½] of the shutter interval has passed.
fn object_at(object: Object, shutter: f32) -> Pose {
    let free = object.distance + object.travel * shutter;
    var distance = free;
    if free > object.bounce {
        distance = 2.0 * object.bounce - free;
    } else if free < -object.bounce {
        distance = -2.0 * object.bounce - free;
    }
    let moved = distance - object.distance;
    let poses = object.pose + moved * object.poses_per_m;
    return Pose(
        object.position + object.direction * distance,
        object.turns + moved * object.turns_per_m,
        clamp(1.0 - abs(1.0 - (poses - 2.0 * floor(0.5 * poses))), 0.0, 1.0),
    );
}

// A world-space direction in the object's own space.
fn to_object(object: Object, pose: Pose, v: vec3f) -> vec3f {
    let a = object.to_axis * v;
    let turn = sin_cos_turns(fract(pose.turns));
    return object.from_axis * vec3f(turn.y * a.x + turn.x * a.y, turn.y * a.y - turn.x * a.x, a.z);
}

// A direction of the object's own space in world space.
fn to_world(object: Object, pose: Pose, v: vec3f) -> vec3f {
    let a = v * object.from_axis;
    let turn = sin_cos_turns(fract(pose.turns));
    return vec3f(turn.y * a.x - turn.x * a.y, turn.y * a.y + turn.x * a.x, a.z) * object.to_axis;
}

// The same for a plane, which seldom turns, or is tilted at all.
fn to_plane(object: Object, pose: Pose, v: vec3f) -> vec3f {
    if PLANES_TURN {
        return to_object(object, pose, v);
    }
    if PLANES_TILT {
        return object.to_axis * v;
    }
    return v;
}

// Unit normal of a plane, in world space.
fn plane_normal(object: Object, pose: Pose) -> vec3f {
    let up = vec3f(0.0, 1.0, 0.0);
    if PLANES_TURN {
        return to_world(object, pose, up);
    }
    if PLANES_TILT {
        return up * object.to_axis;
    }
    return up;
}

// Distance along a ray to the sphere, or −1. A ray that begins on it meets it only from inside.
fn meet_sphere(object: Object, centre: vec3f, origin: vec3f, direction: vec3f, is_on: bool) -> f32 {
    let to_centre = centre - origin;
    let along = dot(to_centre, direction);
    let across = to_centre - direction * along;
    let discriminant = object.size * object.size - dot(across, across);
    var distance = -1.0;
    if discriminant > 0.0 {
        let half_chord = sqrt(discriminant);
        let least = select(0.0, 1e-3 * object.size, is_on);
        let near = along - half_chord;
        let met = select(along + half_chord, near, (near > least) & !is_on);
        distance = select(-1.0, met, met > least);
    }
    return distance;
}

// Whether a ray may meet a mesh, which reaches `size` far from its centre.
fn may_meet(object: Object, centre: vec3f, origin: vec3f, direction: vec3f) -> bool {
    let to_centre = centre - origin;
    let along = max(dot(to_centre, direction), 0.0);
    let across = to_centre - direction * along;
    return dot(across, across) <= object.size * object.size;
}

// Distance along a ray that begins elsewhere to the plane, or −1.
fn meet_plane(object: Object, pose: Pose, origin: vec3f, direction: vec3f) -> f32 {
    let normal = plane_normal(object, pose);
    let offset = origin - pose.centre;
    let distance = -dot(normal, offset) / dot(normal, direction);
    let at = abs(to_plane(object, pose, offset + direction * distance));
    let is_met = (distance > 0.0) & (at.x <= object.size) & (at.z <= object.size);
    return select(-1.0, distance, is_met);
}
