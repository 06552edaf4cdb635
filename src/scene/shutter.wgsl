// The shutter's profile: twin of shutter.rs. The module that uses it declares the constant `SHUTTER_KIND`.

const TRAPEZOID: u32 = 1u;
const GAUSSIAN: u32 = 2u;

// The instant in [−½, ½] of the interval that u ∈ [0, 1) draws.
fn shutter_instant(width: f32, reach: f32, u: f32) -> f32 {
    if SHUTTER_KIND == TRAPEZOID {
        let from_end = min(u, 1.0 - u);
        let in_ramp = sqrt(2.0 * width * (1.0 - width) * from_end);
        let between = from_end * (1.0 - width) + 0.5 * width;
        let t = select(between, in_ramp, in_ramp < width);
        return select(0.5 - t, t - 0.5, u < 0.5);
    }
    if SHUTTER_KIND == GAUSSIAN {
        return clamp(width * erf_inv(reach * (2.0 * u - 1.0)), -0.5, 0.5);
    }
    return u - 0.5;
}

fn erf_inv(x: f32) -> f32 {
    let w = -log(max((1.0 - x) * (1.0 + x), 1e-30));
    if w < 5.0 {
        let v = w - 2.5;
        var p = 2.8102264e-8 * v + 3.4327394e-7;
        p = (p * v - 3.5233877e-6) * v - 4.3915065e-6;
        p = (p * v + 2.1858087e-4) * v - 1.25372503e-3;
        p = (p * v - 4.1776816e-3) * v + 0.24664073;
        return (p * v + 1.5014094) * x;
    }
    let v = sqrt(w) - 3.0;
    var p = -2.0021426e-4 * v + 1.0095056e-4;
    p = (p * v + 1.3493432e-3) * v - 3.6734284e-3;
    p = (p * v + 5.7395077e-3) * v - 7.6224613e-3;
    p = (p * v + 9.4388705e-3) * v + 1.0016741;
    return (p * v + 2.8329768) * x;
}
