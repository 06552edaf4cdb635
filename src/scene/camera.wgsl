// The pinhole camera: twin of camera.rs. The module that uses it declares the constant `CAMERA_MOVES`.

struct Camera {
    position: vec3f,
    focal_length_px: f32,
    forward: vec3f,
    shift_px: f32,
    right: vec3f,
    moves: u32,
    up: vec3f,
    focus_distance: f32,
    travel: vec3f,
    look_at_travel: vec3f,
}

struct CameraRay {
    origin: vec3f,
    direction: vec3f,
}

// The ray through the point of the image x pixels to the right of its centre and y below.
fn camera_ray(camera: Camera, at: vec2f, shutter: f32) -> CameraRay {
    let x = (at.x - camera.shift_px) / camera.focal_length_px;
    let y = at.y / camera.focal_length_px;
    if !CAMERA_MOVES {
        return CameraRay(camera.position, normalize(camera.forward + camera.right * x - camera.up * y));
    }
    let to_look_at =
        camera.forward * camera.focus_distance + (camera.look_at_travel - camera.travel) * shutter;
    let forward = normalize_or(to_look_at, camera.forward);
    let right = normalize_or(vec3f(-forward.z, 0.0, forward.x), camera.right);
    let up = cross(right, forward);
    return CameraRay(camera.position + camera.travel * shutter, normalize(forward + right * x - up * y));
}

fn normalize_or(v: vec3f, otherwise: vec3f) -> vec3f {
    let squared = dot(v, v);
    if squared > 0.0 {
        return v / sqrt(squared);
    }
    return otherwise;
}
