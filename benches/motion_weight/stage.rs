//! The moving model, its camera and lights, and its image by a plain accumulation of instants.

use glam::{Affine3A, DVec2, DVec3, Mat3, Quat, Vec3, Vec3A};
use shutterlab::mesh::Mesh;
use shutterlab::raster::Raster;
use shutterlab::scene::screen_motion::{Described, Rule, Turn, camera};
use shutterlab_stimuli::LinearImage;
use shutterlab_stimuli::stimulus::View;

/// The paper's image and the angle of its height.
const IMAGE_PX: [u32; 2] = [800, 600];
const FIELD_OF_VIEW_DEG: f64 = 33.33;
/// What the resting model covers.
const AREA_PX: f64 = 1e5;
/// Instants whose mean is the image.
pub const INSTANTS: u32 = 432;
/// Around the path, for the filters of FLIP.
const MARGIN_PX: f32 = 16.0;

/// What the model reflects of the light.
const ALBEDO: f32 = 0.8;
/// What falls on every surface, and the directions and strengths of two distant lamps.
const AMBIENT: f32 = 0.1;
const LAMPS: [(Vec3, f32); 2] =
    [(Vec3::new(-0.48, 0.64, 0.6), 0.75), (Vec3::new(0.8, 0.0, 0.6), 0.25)];

/// A model and a camera at rest that looks at its middle along −z.
pub struct Stage {
    pub mesh: Mesh,
    view: View,
    middle: DVec3,
}

impl Stage {
    /// `mesh`, seen from so far away as it covers the area wanted.
    pub fn new(mesh: Mesh) -> Self {
        let (middle, radius) = mesh.bounding_sphere();
        let middle = middle.as_dvec3();
        let view = |distance: f64| {
            let camera = camera(middle + distance * DVec3::Z, middle, IMAGE_PX, FIELD_OF_VIEW_DEG);
            View { camera, travel_m: [[0.0; 3]; 2], shift_px: 0.0, noise: 0 }
        };
        let mut distance = 3.0 * f64::from(radius);
        let mut stage = Self { mesh, view: view(distance), middle };
        let mut raster = Raster::new(1500, 1500);
        for _ in 0..8 {
            raster.clear();
            let [(_, at_rest), ..] = stage.motions(0.0);
            draw(&mut raster, &at_rest, &stage.mesh, 0.0, [0.0; 2]);
            distance *= (raster.seen().count() as f64 / AREA_PX).sqrt();
            stage.view = view(distance);
        }
        stage
    }

    /// Translations in four directions on the screen and a turn about the view, with `speed` pixels per shutter
    /// at the model's middle or, turning, at half the radius of a disc of the model's area.
    pub fn motions(&self, speed: f64) -> [(&'static str, Described); 5] {
        let metres =
            self.view.camera.look_at_distance_m() / self.view.camera.focal_length_px(IMAGE_PX[0]);
        let described = |translation: DVec3, angle: f64| Described {
            view: self.view.clone(),
            width_px: IMAGE_PX[0],
            translation,
            turn: Some(Turn { axis: DVec3::Z, through: self.middle, angle }),
            window: 1,
            rule: Rule::Least,
        };
        let along = |degrees: f64| {
            described((speed * metres * DVec2::from_angle(degrees.to_radians())).extend(0.0), 0.0)
        };
        let radius = 0.5 * (AREA_PX / std::f64::consts::PI).sqrt();
        [
            ("0", along(0.0)),
            ("45", along(45.0)),
            ("90", along(90.0)),
            ("135", along(135.0)),
            ("turning", described(DVec3::ZERO, speed / radius)),
        ]
    }

    /// The least image around the middle that holds the path.
    fn size(&self, motion: &Described) -> [u32; 2] {
        let mut reach = Vec3A::ZERO;
        for step in -8..=8 {
            let to_image = motion.to_image(f64::from(step) / 16.0).as_affine3a();
            for &position in &self.mesh.positions {
                let image = to_image.transform_point3a(position.into());
                reach = reach.max((image / image.z).abs());
            }
        }
        [reach.x, reach.y].map(|half| 2 * (half + MARGIN_PX).ceil() as u32)
    }

    /// The mean of the instants, shaded with the area-weighted normals of `mesh` and with those of its faces.
    /// Each instant has its own place of the samples in the pixels.
    pub fn blurred(&self, mesh: &Mesh, motion: &Described) -> [LinearImage; 2] {
        let [width, height] = self.size(motion);
        let normals = mesh.area_weighted_normals();
        let face_normals: Vec<Vec3> = (mesh.triangles.iter())
            .map(|&triangle| mesh.corners(triangle, 0.0))
            .map(|[a, b, c]| (b - a).cross(c - a).normalize_or_zero())
            .collect();
        let angle = motion.turn.map_or(0.0, |turn| turn.angle);
        let mut raster = Raster::new(width, height);
        let mut sums = vec![[0.0_f32; 2]; raster.depths.len()];
        for k in 0..INSTANTS {
            let instant = (f64::from(k) + 0.5) / f64::from(INSTANTS) - 0.5;
            // The R2 sequence (Roberts 2018).
            let fraction = |step: f64| (0.5 + step * f64::from(k)).fract() as f32 - 0.5;
            let jitter = [0.754_877_666_246_69, 0.569_840_290_998_05].map(fraction);
            raster.clear();
            draw(&mut raster, motion, mesh, instant, jitter);
            let to_model = Quat::from_rotation_z(-(angle * instant) as f32);
            let lamps = LAMPS.map(|(towards, strength)| (to_model * towards, strength));
            let shade = |normal: Vec3| {
                let light =
                    lamps.map(|(towards, strength)| strength * normal.dot(towards).max(0.0));
                ALBEDO * (AMBIENT + light[0] + light[1])
            };
            for (pixel, _, fragment) in raster.seen() {
                let corners = mesh.triangles[fragment.triangle as usize];
                let [a, b, c] = corners.map(|vertex| normals[vertex as usize]);
                let [u, v, w] = fragment.barycentrics;
                sums[pixel][0] += shade((u * a + v * b + w * c).normalize_or_zero());
                sums[pixel][1] += shade(face_normals[fragment.triangle as usize]);
            }
        }
        [0, 1].map(|shading| LinearImage {
            width,
            height,
            pixels: sums.iter().map(|sum| [sum[shading] / INSTANTS as f32; 3]).collect(),
        })
    }
}

/// Draws `mesh` as it is seen at an instant, its image moved by `jitter` pixels.
fn draw(raster: &mut Raster, motion: &Described, mesh: &Mesh, instant: f64, jitter: [f32; 2]) {
    let shift = Mat3::from_cols(Vec3::X, Vec3::Y, Vec3::new(jitter[0], jitter[1], 1.0));
    let to_image = Affine3A::from_mat3(shift) * motion.to_image(instant).as_affine3a();
    raster.draw(mesh.positions.iter().copied(), &mesh.triangles, &to_image);
}
