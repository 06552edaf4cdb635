// The camera: twin of camera.rs. The module that uses it declares the constants `CAMERA_MOVES` and `HAS_LENS`.

struct Camera {
    position: vec3f,
    focal_length_px: f32,
    forward: vec3f,
    shift_px: f32,
    right: vec3f,
    moves: u32,
    up: vec3f,
    look_at_distance: f32,
    travel: vec3f,
    lens_radius: f32,
    look_at_travel: vec3f,
    focus_distance: f32,
}

struct CameraRay {
    origin: vec3f,
    direction: vec3f,
}

// The ray through the point of the image x pixels to the right of its centre and y below, from a point of the lens,
// a unit disk.
fn camera_ray(camera: Camera, at: vec2f, shutter: f32, lens: vec2f) -> CameraRay {
    let x = (at.x - camera.shift_px) / camera.focal_length_px;
    let y = at.y / camera.focal_length_px;
    var origin = camera.position;
    var forward = camera.forward;
    var right = camera.right;
    var up = camera.up;
    if CAMERA_MOVES {
        let to_look_at =
            forward * camera.look_at_distance + (camera.look_at_travel - camera.travel) * shutter;
        forward = normalize_or(to_look_at, forward);
        right = normalize_or(vec3f(-forward.z, 0.0, forward.x), right);
        up = cross(right, forward);
        origin += camera.travel * shutter;
    }
    var direction = forward + right * x - up * y;
    if HAS_LENS {
        let aside = (right * lens.x + up * lens.y) * camera.lens_radius;
        origin += aside;
        direction -= aside / camera.focus_distance;
    }
    return CameraRay(origin, normalize(direction));
}

fn normalize_or(v: vec3f, otherwise: vec3f) -> vec3f {
    let squared = dot(v, v);
    if squared > 0.0 {
        return v / sqrt(squared);
    }
    return otherwise;
}

// Where a point of the lens sees what its middle sees at (x·z, y·z, z): twin of `parallax`.
fn parallax(camera: Camera, lens: vec2f) -> array<vec2f, 2> {
    if !HAS_LENS {
        return array(vec2f(0.0), vec2f(0.0));
    }
    let near = vec2f(-lens.x, lens.y) * (camera.lens_radius * camera.focal_length_px);
    return array(near, -near / camera.focus_distance);
}
