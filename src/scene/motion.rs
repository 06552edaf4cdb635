//! Where the sphere is at an instant of the shutter interval.

use shutterlab_stimuli::stimulus::SpherePath;

/// The sphere's motion during one frame, as both devices compute it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rolling {
    /// x of the centre at the frame's time, in metres, before any bounce.
    pub x: f32,
    /// Change of x while the shutter is open, in metres.
    pub travel: f32,
    /// Angle rolled about −z at the frame's time, in turns.
    pub turns: f32,
    /// |x| at which the sphere turns back; so large that it never does, where it does not.
    pub bounce: f32,
}

impl Rolling {
    /// The motion along `path`.
    pub fn new(path: &SpherePath) -> Self {
        Self {
            x: path.x_m as f32,
            travel: path.travel_m as f32,
            turns: (path.angle_rad / std::f64::consts::TAU) as f32,
            bounce: path.bounce_m.map_or(1e30, |bounce| bounce as f32),
        }
    }

    /// x of the centre and the turns rolled when the part `shutter` ∈ [−½, ½] of the shutter interval,
    /// counted from its middle, has passed. The sphere of radius `radius` rolls without slipping.
    pub fn at(&self, shutter: f32, radius: f32) -> (f32, f32) {
        let free = self.x + self.travel * shutter;
        let x = if free > self.bounce {
            2.0 * self.bounce - free
        } else if free < -self.bounce {
            -2.0 * self.bounce - free
        } else {
            free
        };
        (x, self.turns + (x - self.x) / (std::f32::consts::TAU * radius))
    }
}
