// What each sample of the pixels of a tile sees: twin of reference.rs. A slice of time is that of the next few samples of
// each pixel, `SLICE` of them; their order in time is kept by sorting keys.

@group(0) @binding(11) var<uniform> band: Band;
@group(0) @binding(12) var<storage, read> segments: array<Segment>;
// Where the entries of each layer of each tile begin, and where the last of them end.
@group(0) @binding(13) var<storage, read> places: array<u32>;
@group(0) @binding(14) var<storage, read> entries: array<vec4u>;
// One more than the object and its face that each sample sees.
@group(0) @binding(15) var visibility: texture_storage_2d_array<rg32uint, write>;

const NONE: u32 = 0xffffffffu;

// An entry that may be seen in the slice.
struct Candidate {
    moving: MovingTriangle,
    segment: u32,
    face: u32,
    before: f32,
    count: f32,
}

var<workgroup> own_places: vec2u;
var<workgroup> candidates: array<Candidate, 64>;
var<workgroup> candidate_count: atomic<u32>;
// Bits of when the slice begins and ends, and of the farthest depth that is seen in it.
var<workgroup> begins: atomic<u32>;
var<workgroup> ends: atomic<u32>;
var<workgroup> farthest: atomic<u32>;

// The upper 24 bits of each sample's word of time, and its number.
var<private> keys: array<u32, BATCH>;

@compute @workgroup_size(64)
fn rasterize(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) k: u32) {
    frame = frame_params;
    let tile = vec2u(band.first_column, band.first_row) + group.xy;
    let place = TILE * tile + vec2u(k % TILE, k / TILE);
    if k == 0u {
        let first = LAYERS * (group.y * band.columns + tile.x);
        own_places = vec2u(places[first], places[first + LAYERS]);
    }
    let own = workgroupUniformLoad(&own_places);
    if own.x == own.y {
        for (var number = 0u; number < frame.sample_count; number++) {
            textureStore(visibility, place, number, vec4u(0u));
        }
        return;
    }
    let pixel = place.y * frame.width + place.x;
    let is_in_image = place.x < frame.width && place.y < frame.height;
    for (var number = 0u; number < BATCH; number++) {
        keys[number] = NONE;
        if is_in_image && number < frame.sample_count {
            let words = first_blocks(frame.key, frame.strata, pixel, frame.first_sample + number).start;
            keys[number] = (words.z & 0xffffff00u) | number;
        }
    }
    var key = 0u;
    for (var rank = 0u; rank < frame.sample_count; rank += SLICE) {
        key = draw_slice(own, key, k, place, pixel);
    }
}

// Draws the next samples, those whose keys are not below `least`, and returns from where to go on.
fn draw_slice(own: vec2u, least: u32, k: u32, place: vec2u, pixel: u32) -> u32 {
    if k == 0u {
        atomicStore(&begins, NONE);
        atomicStore(&ends, 0u);
        atomicStore(&farthest, bitcast<u32>(FAR));
    }
    workgroupBarrier();
    var next = least;
    var numbers: array<u32, SLICE>;
    // The point in the image, and the time; and by how much its point of the lens moves all places.
    var samples: array<vec3f, SLICE>;
    var nears: array<vec2f, SLICE>;
    var depths: array<f32, SLICE>;
    var seen: array<vec2u, SLICE>;
    for (var j = 0u; j < SLICE; j++) {
        let key = key_from(next);
        numbers[j] = key & 0xffu;
        samples[j] = vec3f(0.0, 0.0, -1.0);
        depths[j] = 0.0;
        seen[j] = vec2u(NONE);
        if key != NONE {
            next = key + 1u;
            let words = first_blocks(frame.key, frame.strata, pixel, frame.first_sample + numbers[j]).start;
            let time = shutter_instant(frame.shutter_width, frame.shutter_reach, unit(words.z)) + 0.5;
            let moved = parallax(frame.camera, lens_of(pixel, frame.first_sample + numbers[j]));
            let point = vec2f(place) + vec2f(unit(words.x), unit(words.y));
            // What is moved with the depth is as if the point were moved the other way.
            samples[j] = vec3f(point - moved[1], time);
            nears[j] = moved[0];
            depths[j] = FAR;
            atomicMin(&begins, bitcast<u32>(time));
            atomicMax(&ends, bitcast<u32>(time));
        }
    }
    workgroupBarrier();
    for (var first = own.x; first < own.y; first += 64u) {
        if k == 0u {
            atomicStore(&candidate_count, 0u);
        }
        workgroupBarrier();
        if first + k < own.y {
            consider(entries[first + k]);
        }
        workgroupBarrier();
        let count = atomicLoad(&candidate_count);
        for (var c = 0u; c < count; c++) {
            let candidate = candidates[c];
            for (var j = 0u; j < SLICE; j++) {
                // The ends belong to both segments: a triangle that is seen twice is seen once.
                let time = samples[j].z * candidate.count - candidate.before;
                let depth = hit(candidate.moving, samples[j].xy, nears[j], time);
                let number = vec2u(candidate.segment, candidate.face);
                let is_before = number.x < seen[j].x || (number.x == seen[j].x && number.y < seen[j].y);
                let is_nearer = depth < depths[j] || (depth == depths[j] && is_before);
                if time >= 0.0 && time <= 1.0 && depth > 0.0 && is_nearer {
                    depths[j] = depth;
                    seen[j] = number;
                }
            }
        }
        workgroupBarrier();
        if k == 0u {
            atomicStore(&farthest, 0u);
        }
        workgroupBarrier();
        for (var j = 0u; j < SLICE; j++) {
            atomicMax(&farthest, bitcast<u32>(depths[j]));
        }
    }
    for (var j = 0u; j < SLICE; j++) {
        if samples[j].z >= 0.0 {
            var what = vec2u(0u);
            if seen[j].x != NONE {
                what = vec2u(segments[seen[j].x].object + 1u, seen[j].y);
            }
            textureStore(visibility, place, numbers[j], vec4u(what, 0u, 0u));
        }
    }
    return next;
}

// The first key that is not below `least`.
fn key_from(least: u32) -> u32 {
    var first = NONE;
    for (var number = 0u; number < BATCH; number++) {
        first = select(first, min(first, keys[number]), keys[number] >= least);
    }
    return first;
}

// Makes an entry a candidate if it is seen while the slice lasts and not behind all that is seen in it.
fn consider(entry: vec4u) {
    let before = segments[entry.x].before;
    let count = segments[entry.x].count;
    // In parts of the shutter interval, with what rounding can move.
    let interval = (before + vec2f(vec2u(entry.z & 0xffffu, entry.z >> 16u)) / 65535.0) / count;
    let is_meanwhile = interval.x <= bitcast<f32>(atomicLoad(&ends)) + 1e-5
        && interval.y >= bitcast<f32>(atomicLoad(&begins)) - 1e-5;
    if is_meanwhile && bitcast<f32>(entry.w) <= bitcast<f32>(atomicLoad(&farthest)) {
        let place = atomicAdd(&candidate_count, 1u);
        let moving = moving_triangle(segments[entry.x], entry.y);
        candidates[place] = Candidate(moving, entry.x, entry.y, before, count);
    }
}
