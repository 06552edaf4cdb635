// Puts moving triangles into the tiles that they can be seen in, with the time when: twin of bounds.rs, whose edge
// functions it leaves out. Behind the tiles of a band come their layers of depth, the nearest first.

@group(0) @binding(0) var<uniform> band: Band;
@group(0) @binding(1) var<storage, read> geometry: array<vec4u>;
@group(0) @binding(2) var<storage, read> segments: array<Segment>;
// Of each layer of each tile, counted from 1, how many entries it has, or where its next one goes.
@group(0) @binding(3) var<storage, read_write> places: array<atomic<u32>>;
// The segment, the face, when it begins and ends to be seen in parts of the segment, and bits of a depth that it is behind.
@group(0) @binding(4) var<storage, read_write> entries: array<vec4u>;

// What rounding can change a sum of products, as part of the sum of their sizes; a time; and a place.
const SLACK: f32 = 2e-6;
const TIME_SLACK: f32 = 1e-5;
const PLACE_SLACK: f32 = 1e-3;

@compute @workgroup_size(64)
fn bin(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) k: u32,
) {
    let number = group.y * groups.x + group.x;
    // The last segment that begins up to here.
    var low = 0u;
    var high = arrayLength(&segments);
    while low + 1u < high {
        let middle = (low + high) / 2u;
        if segments[middle].first_group <= number {
            low = middle;
        } else {
            high = middle;
        }
    }
    let segment = segments[low];
    let face = (number - segment.first_group) * 64u + k;
    if face < segment.triangles {
        each_tile(moving_triangle(segment, face), low, face);
    }
}

fn each_tile(moving: MovingTriangle, segment: u32, face: u32) {
    let depth = min(min_depth(moving.start), min_depth(moving.end));
    var first = vec2u(0u, band.first_row);
    var end = vec2u(band.columns, band.end_row);
    // In front of the camera what goes straight in homogeneous coordinates goes straight in the image.
    if depth >= 1e-3 {
        var least = vec2f(FAR);
        var most = vec2f(-FAR);
        for (var k = 0u; k < 6u; k++) {
            var q = moving.start[k % 3u];
            if k >= 3u {
                q = moving.end[k % 3u];
            }
            let at = q.xy / q.z;
            let slack = PLACE_SLACK + SLACK * abs(at) + blur(q.z) / q.z;
            least = min(least, at - slack);
            most = max(most, at + slack);
        }
        let tiles = vec4f(floor(least / f32(TILE)), floor(most / f32(TILE)) + 1.0);
        let bounds = vec4f(vec4u(first, end));
        end = vec2u(clamp(tiles.zw, bounds.xy, bounds.zw));
        first = vec2u(clamp(tiles.xy, bounds.xy, bounds.zw));
    }
    let layer = u32(clamp((depth - band.nearest) * band.layers_per_m, 0.0, f32(LAYERS - 1u)));
    for (var y = first.y; y < end.y; y++) {
        for (var x = first.x; x < end.x; x++) {
            let interval = by_planes(moving, vec2f(vec2u(x, y) * TILE));
            if interval.x <= interval.y {
                let tile = (y - band.first_row) * band.columns + x;
                let at = atomicAdd(&places[tile * LAYERS + layer + 1u], 1u);
                if band.fills != 0u {
                    entries[at] = vec4u(segment, face, packed(interval), bitcast<u32>(depth));
                }
            }
        }
    }
}

fn min_depth(corners: mat3x3f) -> f32 {
    return min(min(corners[0].z, corners[1].z), corners[2].z);
}

// When the triangle can be seen in the tile at `corner` by the planes through the camera and the tile's sides, and when it
// is in front of the camera; empty if it ends before it begins.
fn by_planes(moving: MovingTriangle, corner: vec2f) -> vec2f {
    var interval = vec2f(0.0, 1.0);
    let far_corner = corner + f32(TILE);
    for (var plane = 0u; plane < 5u; plane++) {
        // The hull of when each corner is on the inner side.
        var hull = vec2f(2.0, -1.0);
        for (var k = 0u; k < 3u; k++) {
            let distances = vec2f(
                distance(moving.start[k], plane, corner, far_corner),
                distance(moving.end[k], plane, corner, far_corner),
            );
            let inside = distances >= vec2f(0.0);
            let crossing = distances.x / (distances.x - distances.y);
            hull.x = min(hull.x, select(select(2.0, max(crossing - TIME_SLACK, 0.0), inside.y), 0.0, inside.x));
            hull.y = max(hull.y, select(select(-1.0, min(crossing + TIME_SLACK, 1.0), inside.x), 1.0, inside.y));
        }
        interval = vec2f(max(interval.x, hull.x), min(interval.y, hull.y));
    }
    return interval;
}

// How far inside of a plane a corner is, and what rounding can change that.
fn distance(q: vec3f, plane: u32, corner: vec2f, far_corner: vec2f) -> f32 {
    if plane == 4u {
        return q.z - NEAR + SLACK * abs(q.z);
    }
    let axis = plane & 1u;
    let is_far = plane >= 2u;
    let side = select(corner[axis], far_corner[axis], is_far) * q.z;
    let inner = select(q[axis] - side, side - q[axis], is_far);
    return inner + blur(q.z) + SLACK * (abs(q[axis]) + abs(side) + band.blur_px);
}

// How far a point at a depth is moved at most by where on the lens it is seen from. Along the way from one depth to
// another it is no more than in even steps from one end to the other.
fn blur(z: f32) -> f32 {
    return abs(band.blur_px * (1.0 - z * band.inverse_focus));
}

// Rounded outwards.
fn packed(interval: vec2f) -> u32 {
    let parts = interval * 65535.0;
    return u32(floor(parts.x)) | (u32(ceil(parts.y)) << 16u);
}
