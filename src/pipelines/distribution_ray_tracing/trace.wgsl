// Distribution ray tracing: twin of reference.rs, line by line.

const MAX_HITS: u32 = 5u;

@compute @workgroup_size(8, 8)
fn trace(@builtin(global_invocation_id) id: vec3u) {
    read_frame();
    if id.x >= frame.width || id.y >= frame.height {
        return;
    }
    let pixel = id.y * frame.width + id.x;
    var sum = sums[pixel];
    for (var i = 0u; i < frame.sample_count; i++) {
        sum = with_sample(sum, path_radiance(id.x, id.y, pixel, frame.first_sample + i));
    }
    sums[pixel] = sum;
}

// Radiance along one path through pixel (x, y).
fn path_radiance(x: u32, y: u32, pixel: u32, sample: u32) -> vec3f {
    let first = first_blocks(frame.key, frame.strata, pixel, sample);
    let start = first.start;
    let shutter = shutter_instant(frame.shutter_width, frame.shutter_reach, unit(start.z));
    // unroll
    for (var i = 0u; i < OBJECTS; i++) {
        if !PLANES_MOVE && i >= SPHERES && i < SPHERES + PLANES {
            poses[i] = Pose(objects[i].position, 0.0, 0.0);
        } else {
            poses[i] = object_at(objects[i], shutter);
        }
    }
    let in_pixel = vec2f(unit(start.x), unit(start.y));
    let size = vec2f(vec2u(frame.width, frame.height));
    let lens = lens_of(pixel, sample);
    let ray = camera_ray(frame.camera, vec2f(vec2u(x, y)) + in_pixel - 0.5 * size, shutter, lens);
    var origin = ray.origin;
    var direction = ray.direction;

    var radiance = vec3f(0.0);
    var throughput = vec3f(1.0);
    // The camera's own ray has no light sample to share with.
    var density = -1.0;
    var met = nearest(origin, direction, NOTHING);
    let tent = tent(start.w);
    if IS_LOCAL {
        return local_radiance(met, origin, direction, tent);
    }
    var hit = 0u;
    var words = first.hit;
    // The loop ends at its bottom: where the software adapter would meet the end of the last lane at the
    // top, it would go through the body once more for nobody.
    if met.object != NOTHING {
        loop {
            let surface = surface_where(met, origin, direction);
            let to_viewer = -direction;
            origin = surface.point;

            radiance += throughput * from_lights(surface, to_viewer);
            let light = environment_sample(words.xy);
            let value = reflected(surface, to_viewer, light.direction);
            if any(value.xyz != vec3f(0.0)) && is_lit(surface, light.direction, FAR) {
                radiance += throughput * light.radiance * value.xyz * (1.0 / (light.density + value.w));
            }

            let onward = scattered(surface, to_viewer, words.zw);
            direction = onward.direction;
            throughput *= onward.weight;
            density = onward.density;
            // Where the path ends on the surface, nothing is left that what it meets could add to.
            if MAY_END && dot(surface.face_normal, direction) <= 0.0 {
                throughput = vec3f(0.0);
            }
            met = nearest(origin, direction, surface.start);
            hit++;
            words = random_words(frame.key, pixel, sample, 1u + hit);
            if hit == MAX_HITS || met.object == NOTHING || (MAY_END && all(throughput == vec3f(0.0))) {
                break;
            }
        }
    }
    if met.object == NOTHING {
        let is_camera_ray = density < 0.0;
        let light = environment_evaluate(direction, select(vec2f(0.0), tent, is_camera_ray));
        // A direction along the surface may meet black: nothing over nothing.
        let shared_weight = density / max(density + light.w, 1e-30);
        radiance += throughput * light.xyz * select(shared_weight, 1.0, is_camera_ray);
    }
    return radiance;
}

// As bsdf_sample.
fn scattered(surface: Surface, to_viewer: vec3f, words: vec2u) -> Scattered {
    if COATS {
        return bsdf_sample(surface.bsdf, surface.albedo, surface.normal, to_viewer, words);
    }
    let direction = cosine_hemisphere(surface.normal, vec2f(unit(words.x), unit(words.y)));
    return Scattered(direction, max(dot(surface.normal, direction), 0.0) / PI, surface.albedo);
}
