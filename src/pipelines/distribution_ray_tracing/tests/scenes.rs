//! Scenes of many kinds: that each part does what physics or geometry says. The twins agree on them.

use super::{
    HEIGHT, Set, WIDTH, checker, constant, devices, film, mean_of, on_all, set_of_view, stimulus,
    z_scores,
};
use crate::film::{Film, measure};
use crate::pipelines::distribution_ray_tracing::reference;
use glam::{DQuat, DVec3, Vec3};
use shutterlab_stimuli::assets::{Asset, Kind};
use shutterlab_stimuli::scene::{
    CameraMotion, Coat, Deformation, Light, Material, Motion, Object, Orientation, Rotation, Shape,
};
use shutterlab_stimuli::stimulus::{Sampler, Trajectory};
use shutterlab_stimuli::{Stimulus, scene};
use std::path::Path;

/// A folder of assets.
struct Assets(tempfile::TempDir);

impl Assets {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    /// Keeps a file, and returns its name and hash.
    fn keep(&self, name: &str, bytes: &[u8]) -> (String, String) {
        let source = self.0.path().join(name);
        std::fs::write(&source, bytes).unwrap();
        let kind = if name.ends_with(".png") { Kind::Picture } else { Kind::Model };
        let asset = Asset::open(&source, kind).unwrap();
        asset.keep(self.0.path()).unwrap();
        (name.into(), asset.sha256)
    }

    fn set(&self, stimulus: &Stimulus, frame: u32) -> Set {
        set_of_view(stimulus, &stimulus.views(frame)[0], frame, self.0.path())
    }

    fn on_cpu(&self, stimulus: &Stimulus, frame: u32) -> Film {
        let Set { frame, world, environment } = self.set(stimulus, frame);
        film(reference::trace(&frame, &world, &environment, &[stimulus.samples]))
    }
}

/// An object at rest.
fn object(shape: Shape, material: Material) -> Object {
    Object {
        name: "object".into(),
        shape,
        position_m: [0.0; 3],
        orientation: None,
        material: Some(material),
        motion: None,
    }
}

const STILL: Motion =
    Motion { speed_m_per_s: None, translation: None, rotation: None, deformation: None };

/// A ball of radius 1 as OBJ: bands × 2·bands quadrilaterals with texture coordinates and, if asked for,
/// normals, moved by `shape`.
fn ball(bands: usize, smooth: bool, shape: impl Fn(Vec3) -> Vec3) -> String {
    let mut text = String::new();
    let around = 2 * bands;
    for j in 0..=bands {
        for i in 0..=around {
            let (u, v) = (i as f32 / around as f32, j as f32 / bands as f32);
            let (sin_phi, cos_phi) = (u * std::f32::consts::TAU).sin_cos();
            let (sin_theta, cos_theta) = (v * std::f32::consts::PI).sin_cos();
            let n = Vec3::new(sin_theta * cos_phi, cos_theta, -sin_theta * sin_phi);
            let p = shape(n);
            text += &format!(
                "v {} {} {}\nvt {u} {}\nvn {} {} {}\n",
                p.x,
                p.y,
                p.z,
                1.0 - v,
                n.x,
                n.y,
                n.z
            );
        }
    }
    let corner = |i: usize, j: usize| {
        let k = j * (around + 1) + i + 1;
        if smooth { format!("{k}/{k}/{k}") } else { format!("{k}/{k}") }
    };
    for j in 0..bands {
        for i in 0..around {
            let corners =
                [(i, j), (i, j + 1), (i + 1, j + 1), (i + 1, j)].map(|(i, j)| corner(i, j));
            text += &format!("f {}\n", corners.join(" "));
        }
    }
    text
}

fn mesh((file, sha256): (String, String), radius_m: Option<f64>) -> Shape {
    Shape::Mesh { file, sha256, radius_m }
}

/// One of all there is, moving in every way: the twins see the same.
#[test]
fn the_twins_agree_on_a_scene_of_all_kinds() {
    let assets = Assets::new();
    let mut picture = vec![];
    image::RgbImage::from_fn(8, 4, |x, y| image::Rgb([30 * x as u8, 60 * y as u8, 200]))
        .write_to(&mut std::io::Cursor::new(&mut picture), image::ImageFormat::Png)
        .unwrap();
    let (file, sha256) = assets.keep("picture.png", &picture);
    let bumpy = |n: Vec3| n * (0.8 + 0.2 * (5.0 * n.x).sin() * (4.0 * n.y).cos());
    let first = assets.keep("first.obj", ball(12, true, bumpy).as_bytes());
    let (second_file, second_sha256) =
        assets.keep("second.obj", ball(12, true, |n| n * Vec3::new(0.6, 1.0, 0.8)).as_bytes());
    let smooth = assets.keep("smooth.obj", ball(16, true, |n| n).as_bytes());
    std::fs::write(assets.0.path().join("picture.png"), &picture).unwrap();
    std::fs::write(
        assets.0.path().join("own.mtl"),
        "newmtl plain\nKd 0.7 0.2 0.1\nnewmtl shown\nmap_Kd picture.png\n",
    )
    .unwrap();
    let coloured = ball(10, true, |n| n).replacen("f ", "usemtl shown\nf ", 150);
    let coloured = format!("mtllib own.mtl\nusemtl plain\n{coloured}usemtl plain\n");
    let own = assets.keep("own.obj", coloured.as_bytes());
    let image = |coat| Material::Image { file: file.clone(), sha256: sha256.clone(), coat };
    let metal = Some(Coat::Metal { roughness: 0.3 });
    let varnish = Some(Coat::Dielectric { roughness: 0.25, ior: 1.5 });
    let turning = Motion {
        rotation: Some(Rotation { axis: [0.3, 1.0, 0.2], radius_m: 0.2 }),
        translation: Some([1.0, 0.5, 0.0]),
        speed_m_per_s: Some(0.8),
        ..STILL
    };

    let mut all = checker();
    all.sampler = Sampler::Sobol;
    all.samples = 64;
    all.trajectory = Trajectory::Once;
    all.scene.camera.motion = Some(CameraMotion {
        speed_m_per_s: Some(0.5),
        position: [0.2, 0.1, 0.0],
        look_at: [1.0, 0.0, 0.0],
    });
    all.scene.lights = vec![
        Light::Point { position_m: [0.4, 0.6, 0.5], intensity: [0.5, 0.4, 0.2] },
        Light::Directional { direction: [1.0, -1.0, -0.5], irradiance: [0.2, 0.3, 0.5] },
    ];
    all.scene.objects.extend([
        Object {
            position_m: [-0.5, 0.25, 0.2],
            motion: Some(turning.clone()),
            ..object(Shape::Sphere { radius_m: 0.2 }, image(metal))
        },
        Object {
            position_m: [0.0, 0.3, -0.6],
            orientation: Some(Orientation { axis: [1.0, 0.2, 0.0], angle_deg: 70.0 }),
            motion: Some(turning.clone()),
            ..object(Shape::Plane { side_m: 0.8 }, image(varnish))
        },
        Object {
            position_m: [0.5, 0.3, 0.1],
            motion: Some(Motion {
                deformation: Some(Deformation {
                    file: second_file,
                    sha256: second_sha256,
                    distance_m: 0.1,
                }),
                ..turning.clone()
            }),
            ..object(mesh(first, Some(0.25)), constant(0.6))
        },
        Object {
            position_m: [0.1, 0.5, 0.3],
            orientation: Some(Orientation { axis: [0.0, 0.0, 1.0], angle_deg: 30.0 }),
            ..object(mesh(smooth, Some(0.15)), image(varnish))
        },
        Object {
            position_m: [-0.3, 0.2, 0.5],
            motion: Some(turning),
            ..object(mesh(own, Some(0.15)), Material::Model { coat: metal })
        },
    ]);
    let objects = [1, 2, 4, 6].map(|k| all.scene.objects[k].clone()).to_vec();
    let few = Stimulus { scene: scene::Scene { objects, ..all.scene.clone() }, ..all.clone() };
    // Loops over many objects, and the same written out for few.
    for stimulus in [all, few] {
        let set = assets.set(&stimulus, 63);
        let mut images =
            devices().into_iter().map(|(_, mut trace)| film(trace(&set, &[64])).image());
        let truth = images.next().unwrap();
        for image in images {
            let error = measure::relative_mse(&image, &truth, 0.004).sqrt();
            let others = measure::differing(&image, &truth, 1.0 / 255.0);
            // A path that rounding sends past an edge is another path: 64 samples weigh it heavily.
            assert!(error <= 1e-2 && others <= 2e-3, "{error} {others}");
        }
    }
}

/// A mesh of a ball, finely divided, that rolls, is the rolling sphere, shadow and all; and flat faces make
/// it a little smaller, not another thing. z² is that of two random images of the same, up to the silhouette.
#[test]
fn a_mesh_of_a_ball_is_a_sphere() {
    let assets = Assets::new();
    let plain = Stimulus { material: constant(0.6), samples: 64, ..checker() };
    let mut meshed = Stimulus { seed: 5, ..plain.clone() };
    meshed.scene.objects[0].shape =
        mesh(assets.keep("ball.obj", ball(128, true, |n| n).as_bytes()), Some(0.1));
    let truth = assets.on_cpu(&plain, 61);
    let (mean_square, largest) = z_scores(&assets.on_cpu(&meshed, 61), &truth);
    assert!((mean_square - 1.0).abs() < 0.1 && largest < 5.3, "{mean_square} {largest}");
}

/// Checkers of sphere and mesh lie in the same places, turned alike.
#[test]
fn patterns_turn_with_meshes_as_with_spheres() {
    let assets = Assets::new();
    let turned = |stimulus: &mut Stimulus| {
        stimulus.scene.objects[0].orientation =
            Some(Orientation { axis: [0.2, 1.0, 0.4], angle_deg: 50.0 });
    };
    let mut plain = Stimulus { samples: 64, ..checker() };
    turned(&mut plain);
    let mut meshed = Stimulus { seed: 5, ..plain.clone() };
    // Without texture coordinates: as PLY of the same ball.
    let model =
        crate::scene::import::obj::parse("a", ball(128, true, |n| n).as_bytes(), Path::new(""));
    let ball = model.unwrap().mesh;
    let mut ply = format!(
        "ply\nformat ascii 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\n\
         property float nx\nproperty float ny\nproperty float nz\n\
         element face {}\nproperty list uchar int vertex_indices\nend_header\n",
        ball.positions.len(),
        ball.triangles.len()
    );
    for p in &ball.positions {
        ply += &format!("{} {} {} {} {} {}\n", p.x, p.y, p.z, p.x, p.y, p.z);
    }
    for [a, b, c] in &ball.triangles {
        ply += &format!("3 {a} {b} {c}\n");
    }
    meshed.scene.objects[0].shape = mesh(assets.keep("ball.ply", ply.as_bytes()), Some(0.1));
    let (mean_square, _) = z_scores(&assets.on_cpu(&meshed, 61), &assets.on_cpu(&plain, 61));
    assert!((mean_square - 1.0).abs() < 0.1, "{mean_square}");
}

/// White meshes in white light are invisible; and the inside of a closed one is dark.
#[test]
fn a_white_furnace_of_meshes() {
    let assets = Assets::new();
    let mut furnace = Stimulus { samples: 16, material: constant(1.0), ..checker() };
    furnace.scene.environment = scene::Environment::Uniform([1.0; 3]);
    super::paint_floor(&mut furnace, 1.0);
    let shape = mesh(assets.keep("ball.obj", ball(24, false, |n| n).as_bytes()), Some(0.1));
    furnace.scene.objects[0].shape = shape;
    let mean = |film: &Film| {
        let statistics = film.luminance_statistics();
        statistics.iter().map(|(mean, _)| mean).sum::<f64>() / statistics.len() as f64
    };
    let outside = mean(&assets.on_cpu(&furnace, 60));
    assert!((0.999..1.0005).contains(&outside), "{outside}");
    furnace.scene.camera.position_m = [0.0, 0.1, 0.02];
    let inside = assets.on_cpu(&furnace, 60);
    assert!(inside.sums.iter().all(|sum| sum.is_finite()));
    // No path finds a way out.
    assert_eq!(mean(&inside), 0.0);
}

/// The floor below a point light is ρ/π · I cos θ/d², and in a directional one ρ/π · E cos θ.
#[test]
fn lights_have_their_irradiance() {
    let mut lit = Stimulus { samples: 4, ..checker() };
    lit.scene.environment = scene::Environment::Uniform([0.0; 3]);
    lit.scene.objects.remove(0);
    lit.scene.camera.position_m = [0.0, 2.0, 0.001];
    lit.scene.camera.look_at_m = [0.0; 3];
    let at_centre = |stimulus: &Stimulus| {
        on_all(stimulus, 60).into_iter().map(|(device, film)| {
            let (x, y) = (WIDTH / 2, HEIGHT / 2);
            (device, mean_of(&film.image(), x - 1..x + 1, y - 1..y + 1)[0])
        })
    };
    let per_irradiance = 0.5 / std::f64::consts::PI;
    lit.scene.lights = vec![Light::Point { position_m: [0.3, 0.4, 0.0], intensity: [3.0; 3] }];
    let known = per_irradiance * 3.0 * 0.8 / 0.25;
    for (device, found) in at_centre(&lit) {
        assert!((found / known - 1.0).abs() < 1e-2, "{device}: {found} {known}");
    }
    lit.scene.lights =
        vec![Light::Directional { direction: [0.0, -0.6, -0.8], irradiance: [2.0; 3] }];
    let known = per_irradiance * 2.0 * 0.6;
    for (device, found) in at_centre(&lit) {
        assert!((found / known - 1.0).abs() < 1e-3, "{device}: {found} {known}");
    }
}

/// A wall between a light and the floor keeps all of it away; one behind the light keeps nothing.
#[test]
fn what_is_in_the_way_of_a_light_casts_a_shadow() {
    let assets = Assets::new();
    let mut lit = Stimulus { samples: 2, ..checker() };
    lit.scene.environment = scene::Environment::Uniform([0.0; 3]);
    lit.scene.camera.position_m = [0.0, 0.3, 0.5];
    lit.scene.camera.look_at_m = [0.0; 3];
    lit.scene.lights = vec![Light::Point { position_m: [0.0, 1.0, 0.0], intensity: [3.0; 3] }];
    let cap = mesh(assets.keep("ball.obj", ball(6, false, |n| n).as_bytes()), Some(0.3));
    let middle = |height: f64, shape: Shape| {
        let mut stimulus = lit.clone();
        stimulus.scene.objects[0] =
            Object { position_m: [0.0, height, 0.0], ..object(shape, constant(0.0)) };
        let set = assets.set(&stimulus, 60);
        let (x, y) = (WIDTH / 2, HEIGHT / 2);
        devices().into_iter().map(move |(_, mut trace)| {
            mean_of(&film(trace(&set, &[2])).image(), x - 1..x + 1, y - 1..y + 1)[0]
        })
    };
    for shape in [Shape::Sphere { radius_m: 0.3 }, Shape::Plane { side_m: 0.5 }, cap] {
        assert!(middle(0.65, shape.clone()).all(|light| light == 0.0), "{shape:?}");
        assert!(middle(1.4, shape.clone()).all(|light| light > 0.1), "{shape:?}");
    }
}

/// Motion is relative: a camera that moves past things at rest sees what one at rest sees of things that
/// move the other way.
#[test]
fn a_moving_camera_sees_the_world_move_the_other_way() {
    let mut world_moves = Stimulus { samples: 64, trajectory: Trajectory::Once, ..checker() };
    world_moves.scene.environment = scene::Environment::Uniform([1.0, 0.8, 0.5]);
    let gone = |direction: f64| Motion { translation: Some([direction, 0.0, 0.0]), ..STILL };
    world_moves.scene.objects[0].motion = Some(gone(-1.0));
    // The floor, large as it is, has no pattern, and may rest.
    let mut camera_moves = world_moves.clone();
    camera_moves.scene.objects[0].motion = None;
    let direction = [1.0, 0.0, 0.0];
    camera_moves.scene.camera.motion =
        Some(CameraMotion { speed_m_per_s: None, position: direction, look_at: direction });
    for ((device, a), (_, b)) in on_all(&world_moves, 63).into_iter().zip(on_all(&camera_moves, 63))
    {
        let error = measure::relative_mse(&a.image(), &b.image(), 0.004).sqrt();
        assert!(error < 1e-2, "{device}: {error}");
    }
}

fn oriented(rotation: DQuat) -> Orientation {
    let (axis, angle) = rotation.to_axis_angle();
    Orientation { axis: axis.to_array(), angle_deg: angle.to_degrees() }
}

/// What lay at one angle and has turned about another axis lies as both rotations one after the other have it.
#[test]
fn rotation_ends_where_orientation_begins() {
    let assets = Assets::new();
    let egg = assets.keep("egg.obj", ball(12, false, |n| n * Vec3::new(1.0, 0.5, 0.3)).as_bytes());
    let shapes =
        [mesh(egg, Some(0.2)), Shape::Plane { side_m: 0.3 }, Shape::Sphere { radius_m: 0.2 }];
    for shape in shapes {
        let mut turned = stimulus("material=checker,speed=S2,shutter=T1,samples=A1");
        turned.scene.objects[0] =
            Object { position_m: [0.0, 0.4, 0.0], ..object(shape, constant(0.5)) };
        turned.scene.objects[0].material = None;
        let mut turning = turned.clone();
        let axis = [0.3, 0.2, -1.0];
        // It lies otherwise to begin with; then one radian per 0.1 m, and the frames after the middle one are 0.05 m apart.
        turning.scene.objects[0].motion = Some(Motion {
            speed_m_per_s: Some(0.05 * turned.image.fps),
            rotation: Some(Rotation { axis, radius_m: 0.1 }),
            ..STILL
        });
        let before = DQuat::from_axis_angle(DVec3::X, 0.7);
        turning.scene.objects[0].orientation = Some(oriented(before));
        let after = DQuat::from_axis_angle(DVec3::from(axis).normalize(), 1.5) * before;
        turned.scene.objects[0].orientation = Some(oriented(after));
        let noise = Stimulus { samples: 16, ..turning.clone() };
        let turning = assets.on_cpu(&noise, 63).image();
        // The same noise: that of frame 63.
        let mut set = assets.set(&Stimulus { samples: 16, ..turned }, 60);
        set.frame.params.key = assets.set(&noise, 63).frame.params.key;
        let turned =
            film(reference::trace(&set.frame, &set.world, &set.environment, &[16])).image();
        let error = measure::relative_mse(&turning, &turned, 0.004).sqrt();
        assert!(error < 0.02, "{error}");
    }
}

/// Half way between its poses a mesh is the mean of them.
#[test]
fn a_deforming_mesh_is_between_its_poses() {
    let assets = Assets::new();
    let pose = |x: f32| ball(8, false, move |n| n * Vec3::new(x, 1.0, 1.0));
    let first = assets.keep("first.obj", pose(0.5).as_bytes());
    let (file, sha256) = assets.keep("second.obj", pose(1.5).as_bytes());
    let mean = assets.keep("mean.obj", pose(1.0).as_bytes());
    let mut between = stimulus("material=flat,speed=S2,shutter=T1,samples=A1");
    between.scene.objects[0].shape = mesh(first, None);
    between.scene.objects[0].motion =
        Some(Motion { deformation: Some(Deformation { file, sha256, distance_m: 3.0 }), ..STILL });
    let mut there = between.clone();
    there.scene.objects[0] =
        Object { motion: None, shape: mesh(mean, None), ..between.scene.objects[0].clone() };
    let error = measure::relative_mse(
        &assets.on_cpu(&between, 60).image(),
        &assets.on_cpu(&there, 60).image(),
        0.004,
    );
    assert!(error.sqrt() < 1e-3, "{error}");
}

/// No ray that leaves a closed mesh's surface meets what it leaves, even far from the origin and at a
/// grazing angle: seen from outside, a convex ball in a uniform light is ρ everywhere.
#[test]
fn surfaces_of_meshes_do_not_shadow_themselves() {
    let assets = Assets::new();
    let shape = mesh(assets.keep("ball.obj", ball(64, false, |n| n).as_bytes()), Some(0.1));
    let mut lone = Stimulus { samples: 64, ..checker() };
    lone.scene.environment = scene::Environment::Uniform([1.0; 3]);
    lone.scene.objects =
        vec![Object { position_m: [30.0, 20.0, -40.0], ..object(shape, constant(0.5)) }];
    lone.scene.camera.look_at_m = [30.0, 20.0, -40.0];
    lone.scene.camera.position_m = [30.0, 20.15, -39.75];
    let set = assets.set(&lone, 60);
    for (device, mut trace) in devices() {
        let film = film(trace(&set, &[64]));
        // All of it is ball but the corners.
        let (x, y) = (WIDTH / 2, HEIGHT / 2);
        let mean = mean_of(&film.image(), x - 20..x + 20, y - 20..y + 20)[0];
        assert!((mean - 0.5).abs() < 5e-4, "{device}: {mean}");
        // Nothing is darker, but by chance.
        let darkest = film
            .luminance_statistics()
            .into_iter()
            .map(|(mean, variance)| (mean - 0.5) / variance.sqrt().max(1e-4))
            .fold(0.0, f64::min);
        assert!(darkest > -5.3, "{device}: {darkest}");
    }
}

/// The views of stereo take what moves into account, too.
#[test]
fn both_eyes_move_with_the_camera() {
    let mut stereo = checker();
    stereo.stereo = shutterlab_stimuli::Grid::load("rolling-sphere-stereo").unwrap().stereo;
    stereo.trajectory = Trajectory::Once;
    stereo.scene.camera.motion = Some(CameraMotion {
        speed_m_per_s: Some(3.0),
        position: [1.0, 0.0, 0.0],
        look_at: [1.0, 0.0, 0.0],
    });
    let [left, right]: [_; 2] = stereo.views(63).try_into().unwrap();
    let apart = right.camera.position_m[0] - left.camera.position_m[0];
    assert!((apart - 0.065).abs() < 1e-12);
    assert!((0.5 * (left.camera.position_m[0] + right.camera.position_m[0]) - 0.3).abs() < 1e-12);
    let eyes = [left, right]
        .map(|view| set_of_view(&stereo, &view, 63, Path::new("")).frame.params.camera);
    assert!(eyes.iter().all(|camera| camera.moves == 1 && (camera.travel.x - 0.1).abs() < 1e-6));
}
