// Where the sphere is at an instant of the shutter interval: twin of motion.rs.

// x of the centre and the turns rolled when the part `shutter` ∈ [−½, ½] has passed.
fn rolling_at(x: f32, travel: f32, turns: f32, bounce: f32, shutter: f32, radius: f32) -> vec2f {
    let free = x + travel * shutter;
    var at = free;
    if free > bounce {
        at = 2.0 * bounce - free;
    } else if free < -bounce {
        at = -2.0 * bounce - free;
    }
    return vec2f(at, turns + (at - x) / (2.0 * PI * radius));
}
