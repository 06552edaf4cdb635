// Rays against one mesh: the host's side is mesh_probe.rs.

struct ProbeRay {
    origin: vec3f,
    time: f32,
    direction: vec3f,
    first: f32,
    last: f32,
}

struct ProbeHit {
    barycentrics: vec3f,
    distance: f32,
    face: u32,
}

@group(0) @binding(0) var<uniform> mesh_range: MeshRange;
@group(0) @binding(1) var<storage, read> geometry: array<vec4u>;
@group(0) @binding(2) var<storage, read> rays: array<ProbeRay>;
@group(0) @binding(3) var<storage, read_write> hits: array<ProbeHit>;

@compute @workgroup_size(64)
fn probe(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let at = id.x + id.y * groups.x * 64u;
    if at >= arrayLength(&rays) {
        return;
    }
    let mesh = mesh_range;
    let ray = rays[at];
    let between = vec2f(ray.first, ray.last);
    var hit = MeshHit(MESH_NONE, 0.0, vec3f(0.0));
    if FIND_ANY {
        if mesh_any(mesh, ray.origin, ray.direction, ray.time, between) {
            hit.face = 0u;
        }
    } else {
        hit = mesh_nearest(mesh, ray.origin, ray.direction, ray.time, between);
    }
    hits[at] = ProbeHit(hit.barycentrics, hit.distance, hit.face);
}
