// Where the sphere is at an instant of the shutter interval: twin of motion.rs.

// x of the centre and rolled angle when the part `shutter` ∈ [−½, ½] has passed.
fn rolling_at(x: f32, travel: f32, angle: f32, bounce: f32, shutter: f32, radius: f32) -> vec2f {
    let free = x + travel * shutter;
    var at = free;
    if free > bounce {
        at = 2.0 * bounce - free;
    } else if free < -bounce {
        at = -2.0 * bounce - free;
    }
    return vec2f(at, angle + (at - x) / radius);
}
