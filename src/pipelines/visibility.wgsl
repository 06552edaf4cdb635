// What samples see, shaded by the lights alone and added up: twin of `Frame::local_radiance` and of what leads to it. The
// module that uses it declares `sample_of`.

struct Sample {
    // The point of the pixel, from 0 to 1, and that of the lens, a unit disk.
    @align(16) in_pixel: vec2f,
    lens: vec2f,
    // The instant, as part of the shutter interval from its middle.
    shutter: f32,
    // Looks the environment up a little aside.
    word: u32,
}

// One more than the object and its face that each sample of each pixel sees.
@group(0) @binding(11) var visibility: texture_2d_array<u32>;

@compute @workgroup_size(8, 8)
fn shade(@builtin(global_invocation_id) id: vec3u) {
    read_frame();
    let place = frame.first_pixel + id.xy;
    if place.x >= frame.width || place.y >= frame.height {
        return;
    }
    let pixel = place.y * frame.width + place.x;
    var sum = sums[pixel];
    for (var k = 0u; k < frame.sample_count; k++) {
        let seen = textureLoad(visibility, place, k, 0).xy;
        sum = with_sample(sum, radiance_of(sample_of(pixel, k), vec2f(place), seen));
    }
    sums[pixel] = sum;
}

// Radiance of what a sample of the pixel at `corner` sees: one more than the object, and its face.
fn radiance_of(sample: Sample, corner: vec2f, seen: vec2u) -> vec3f {
    let size = vec2f(vec2u(frame.width, frame.height));
    let ray = camera_ray(frame.camera, corner + sample.in_pixel - 0.5 * size, sample.shutter, sample.lens);
    var met = Met(NOTHING, FAR, 0u, vec3f(0.0));
    if seen.x != 0u {
        // unroll
        for (var i = 0u; i < OBJECTS; i++) {
            if i == seen.x - 1u {
                poses[i] = object_at(objects[i], sample.shutter);
            }
        }
        met = met_where(seen.x - 1u, seen.y, ray.origin, ray.direction);
    }
    return local_radiance(met, ray.origin, ray.direction, tent(sample.word));
}

// Where the ray meets what is seen; spheres and planes where they truly are.
fn met_where(object: u32, face: u32, origin: vec3f, direction: vec3f) -> Met {
    if object < SPHERES + PLANES {
        var distance = -1.0;
        if object < SPHERES {
            distance = meet_sphere(objects[object], poses[object].centre, origin, direction, false);
        } else {
            distance = meet_plane(objects[object], poses[object], origin, direction);
        }
        return Met(select(NOTHING, object, distance > 0.0), distance, face, vec3f(0.0));
    }
    // The weights of the triangle's corners where the ray meets its plane, seen from the ray's origin.
    let begin = to_object(objects[object], poses[object], origin - poses[object].centre);
    let along = to_object(objects[object], poses[object], direction);
    let corners = mesh_corners(meshes[object - SPHERES - PLANES], face, poses[object].time);
    let a = corners[0] - begin;
    let b = corners[1] - begin;
    let c = corners[2] - begin;
    let weights = vec3f(dot(cross(b, c), along), dot(cross(c, a), along), dot(cross(a, b), along));
    let sum = weights.x + weights.y + weights.z;
    let barycentrics = select(vec3f(1.0, 0.0, 0.0), weights / sum, sum != 0.0);
    return Met(object, 0.0, face, barycentrics);
}
