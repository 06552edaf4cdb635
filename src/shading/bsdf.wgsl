// How surfaces scatter light: twin of bsdf.rs.

struct Bsdf {
    kind: u32,
    alpha: f32,
    eta: f32,
    internal: f32,
}

// Where a path goes on. Below the surface it ends: weight and density are 0.
struct Scattered {
    direction: vec3f,
    density: f32,
    weight: vec3f,
}

const LAMBERTIAN: u32 = 0u;
const METAL: u32 = 1u;

// BSDF × cos θ for light from to_light, per steradian; then the density per steradian with which
// bsdf_sample draws that direction.
fn bsdf_evaluate(bsdf: Bsdf, albedo: vec3f, normal: vec3f, to_viewer: vec3f, to_light: vec3f) -> vec4f {
    let viewer_cosine = dot(normal, to_viewer);
    let light_cosine = dot(normal, to_light);
    let cosine_density = max(light_cosine, 0.0) / PI;
    if bsdf.kind == LAMBERTIAN {
        return vec4f(albedo * cosine_density, cosine_density);
    }
    if viewer_cosine <= 0.0 || light_cosine <= 0.0 {
        return vec4f(0.0);
    }

    // 2(o·h)h. Opposite directions along the surface may leave nothing of it.
    let sum = to_viewer + to_light;
    let length_squared = max(dot(sum, sum), 1e-30);
    let half_cosine = min(0.5 * sqrt(length_squared), 1.0);
    // Not 1 − cos²: near the peak that is all rounding.
    let across = cross(normal, sum);
    let sin_squared = dot(across, across) / length_squared;

    let alpha_squared = bsdf.alpha * bsdf.alpha;
    let viewer_smith = sqrt(alpha_squared + (1.0 - alpha_squared) * viewer_cosine * viewer_cosine);
    let light_smith = sqrt(alpha_squared + (1.0 - alpha_squared) * light_cosine * light_cosine);
    let slope = alpha_squared + (1.0 - alpha_squared) * sin_squared;
    let normals = alpha_squared / (PI * slope * slope);
    // Visible normals, per steradian of i: G₁·D / (4 n·o) [Heitz2018].
    let mirror_density = 0.5 * normals / (viewer_cosine + viewer_smith);
    let both = light_cosine * viewer_smith + viewer_cosine * light_smith;
    let mirror = 0.5 * normals * light_cosine / max(both, 1e-30);

    if bsdf.kind == METAL {
        let rest = 1.0 - half_cosine;
        let rest_squared = rest * rest;
        let fresnel = albedo + (1.0 - albedo) * (rest_squared * rest_squared * rest);
        return vec4f(fresnel * mirror, mirror_density);
    }
    let enters = (1.0 - fresnel(viewer_cosine, bsdf.eta)) * (1.0 - fresnel(light_cosine, bsdf.eta))
        / (bsdf.eta * bsdf.eta);
    let base = albedo / (1.0 - albedo * bsdf.internal) * (enters * cosine_density);
    let share = mirror_share(bsdf, albedo, viewer_cosine);
    return vec4f(
        base + fresnel(half_cosine, bsdf.eta) * mirror,
        share * mirror_density + (1.0 - share) * cosine_density,
    );
}

// Draws a direction to go on in, by two random words.
fn bsdf_sample(bsdf: Bsdf, albedo: vec3f, normal: vec3f, to_viewer: vec3f, words: vec2u) -> Scattered {
    let a = unit(words.x);
    let b = unit(words.y);
    if bsdf.kind == LAMBERTIAN {
        let direction = cosine_hemisphere(normal, vec2f(a, b));
        return Scattered(direction, max(dot(normal, direction), 0.0) / PI, albedo);
    }
    var share = 1.0;
    if bsdf.kind != METAL {
        share = mirror_share(bsdf, albedo, dot(normal, to_viewer));
    }
    // The first number chooses between coat and base, and what is left of it is uniform again.
    var direction: vec3f;
    if a < share {
        let facet = visible_normal(normal, to_viewer, bsdf.alpha, vec2f(a / share, b));
        direction = 2.0 * dot(to_viewer, facet) * facet - to_viewer;
    } else {
        direction = cosine_hemisphere(normal, vec2f((a - share) / (1.0 - share), b));
    }
    let there = bsdf_evaluate(bsdf, albedo, normal, to_viewer, direction);
    if there.w > 0.0 {
        return Scattered(direction, there.w, there.xyz / there.w);
    }
    return Scattered(direction, 0.0, vec3f(0.0));
}

// The part of the samples that the coat gets: its part in what both would reflect if it were smooth.
fn mirror_share(bsdf: Bsdf, albedo: vec3f, viewer_cosine: f32) -> f32 {
    let mirrored = fresnel(max(viewer_cosine, 0.0), bsdf.eta);
    let base = dot(albedo / (1.0 - albedo * bsdf.internal), LUMINANCE) * (1.0 - bsdf.internal);
    return mirrored / (mirrored + (1.0 - mirrored) * base);
}

// Reflectance of a dielectric of index η seen from outside at an angle of this cosine, unpolarised.
fn fresnel(cosine: f32, eta: f32) -> f32 {
    // Eq. 22 [Walter2007].
    let g = sqrt(eta * eta - 1.0 + cosine * cosine);
    let across = (g - cosine) / (g + cosine);
    let along = (cosine * (g + cosine) - 1.0) / (cosine * (g - cosine) + 1.0);
    return 0.5 * across * across * (1.0 + along * along);
}

// The normal of a microfacet, as often as the viewer sees its area [DupuyBenyoub2023].
fn visible_normal(normal: vec3f, to_viewer: vec3f, alpha: f32, u: vec2f) -> vec3f {
    let frame = tangents(normal);
    let stretched = vec3f(
        alpha * dot(to_viewer, frame[0]), alpha * dot(to_viewer, frame[1]), dot(normal, to_viewer),
    );
    let viewer = stretched * (1.0 / sqrt(dot(stretched, stretched)));
    // How far the point of the cap is below the pole: without cancellation in the sine.
    let depth = u.y * (1.0 + viewer.z);
    let r = sqrt(max(depth * (2.0 - depth), 0.0));
    let turn = sin_cos_turns(u.x);
    let facet = vec3f(
        alpha * (viewer.x + r * turn.y),
        alpha * (viewer.y + r * turn.x),
        // Positive, since u < 1, so that the sum has a length.
        (1.0 - u.y) * (1.0 + viewer.z),
    );
    let inverse_length = 1.0 / sqrt(dot(facet, facet));
    return (frame[0] * facet.x + frame[1] * facet.y + normal * facet.z) * inverse_length;
}

// Two unit vectors that complete the unit vector n to a frame [Duff2017].
fn tangents(n: vec3f) -> mat2x3f {
    let sign = select(1.0, -1.0, n.z < 0.0);
    let a = -1.0 / (sign + n.z);
    let b = n.x * n.y * a;
    return mat2x3f(
        vec3f(1.0 + sign * n.x * n.x * a, sign * b, -sign * n.x),
        vec3f(b, sign + n.y * n.y * a, -n.y),
    );
}
