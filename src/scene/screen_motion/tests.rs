//! Paths over the image against projections by hand, the renderer's rays and finite differences.

use super::described::camera;
use super::*;
use crate::scene::camera::Camera as RayCamera;
use crate::scene::object::Object;
use glam::DQuat;
use shutterlab_stimuli::{Grid, Selection};
use std::f64::consts::{FRAC_PI_2, PI};

/// How far the camera is away, and its focal length: a unit across the view through the origin is 250 px.
const DISTANCE: f64 = 4.0;
const FOCAL_PX: f64 = 1000.0;

/// The camera on the z axis that looks at the origin, and an object at rest.
fn at_rest() -> Described {
    let field_of_view_deg = 2.0 * (300.0 / FOCAL_PX).atan().to_degrees();
    let camera = camera(DVec3::Z * DISTANCE, DVec3::ZERO, [800, 600], field_of_view_deg);
    Described {
        view: View { camera, travel_m: [[0.0; 3]; 2], shift_px: 0.0, noise: 0 },
        width_px: 800,
        translation: DVec3::ZERO,
        turn: None,
        window: 1,
        rule: Rule::Least,
    }
}

fn moving(translation: DVec3) -> Described {
    Described { translation, ..at_rest() }
}

fn turning(axis: DVec3, angle: f64) -> Described {
    let turn = Some(Turn { axis, through: DVec3::ZERO, angle });
    Described { turn, ..at_rest() }
}

fn seen(described: &Described, point: DVec3) -> Seen {
    described.paths().seen([point.as_vec3(); 2])
}

/// By hand, for the camera at rest.
fn image_of(point: DVec3) -> [f64; 2] {
    let scale = FOCAL_PX / (DISTANCE - point.z);
    [scale * point.x, -scale * point.y]
}

/// Length of the path of `place` from `from` to `to`, by many chords.
fn length(place: impl Fn(f64) -> DVec3, from: f64, to: f64) -> f64 {
    let at = |k: u32| image_of(place(from + (to - from) * f64::from(k) / 10_000.0));
    (0..10_000).map(|k| distance(at(k), at(k + 1))).sum()
}

fn distance(a: [f64; 2], b: [f64; 2]) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

#[track_caller]
fn near(found: f32, expected: f64, tolerance: f64) {
    assert!((f64::from(found) - expected).abs() <= tolerance, "{found} {expected}");
}

const POINTS: [DVec3; 4] = [
    DVec3::ZERO,
    DVec3::new(0.4, 0.3, 0.5),
    DVec3::new(-0.7, 0.2, -0.4),
    DVec3::new(0.1, -0.8, 0.6),
];

#[test]
fn what_moves_in_a_straight_line_sweeps_the_distance_between_its_ends() {
    for translation in
        [DVec3::X * 0.12, DVec3::Y * -0.3, DVec3::Z * 0.5, DVec3::new(0.1, 0.2, -0.3)]
    {
        for point in POINTS {
            let found = seen(&moving(translation), point);
            let [from, to] = [-0.5, 0.5].map(|t| image_of(point + translation * t));
            let middle = image_of(point);
            near(found.speed_px, distance(from, to), 1e-3);
            near(found.velocity_px.x, to[0] - from[0], 1e-3);
            near(found.velocity_px.y, to[1] - from[1], 1e-3);
            near(found.position_px.x, middle[0], 1e-3);
            near(found.position_px.y, middle[1], 1e-3);
            let nearest = DISTANCE - point.z - 0.5 * translation.z.abs();
            near(found.magnification, (DISTANCE - point.z) / nearest, 1e-5);
        }
    }
}

/// On the axis of the view nothing seems to move that comes along it.
#[test]
fn along_the_view_the_middle_stays_and_the_rest_streams_outwards() {
    let middle = seen(&moving(DVec3::Z * 0.5), DVec3::ZERO);
    assert_eq!((middle.speed_px, middle.velocity_px), (0.0, Vec2::ZERO));
    let aside = seen(&moving(DVec3::Z * 0.5), DVec3::new(0.3, -0.4, 0.0));
    assert!(aside.velocity_px.normalize().abs_diff_eq(Vec2::new(0.6, 0.8), 1e-5), "{aside:?}");
}

/// About the view's direction speeds are the arcs' lengths, in proportion to the distance from the hub.
#[test]
fn about_the_view_points_sweep_arcs() {
    for angle in [0.05, 0.4, 1.5, 2.0 * PI] {
        let described = turning(DVec3::Z, angle);
        assert!(seen(&described, DVec3::ZERO).speed_px < 1e-3);
        for radius in [0.1, 0.5, 1.0] {
            let found = seen(&described, DVec3::new(0.0, radius, 0.0));
            let arc = radius * angle * FOCAL_PX / DISTANCE;
            assert!(f64::from(found.speed_px) <= arc * (1.0 + 1e-5), "{angle} {radius}");
            // 64 steps are all that there are: those of a whole turn are longer than 4°.
            near(found.speed_px, arc, arc * if angle > 4.0 { 5e-4 } else { 2.1e-4 });
            // Counter-clockwise, so that the top goes to the left.
            near(found.velocity_px.x, -arc, 5e-3 * arc);
            near(found.velocity_px.y, 0.0, 1e-2);
        }
    }
}

/// About any axis, with a translation, on the way from one keyframe to another: the length of the path.
#[test]
fn any_motions_together_sweep_the_length_of_their_path() {
    let axis = DVec3::new(0.3, 1.0, -0.2).normalize();
    let (translation, angle) = (DVec3::new(0.2, -0.1, 0.3), 0.7);
    let through = DVec3::new(0.1, 0.0, 0.1);
    let turn = Some(Turn { axis, through, angle });
    let described = Described { translation, turn, ..at_rest() };
    for point in POINTS {
        let end = point + DVec3::new(0.05, 0.1, -0.02);
        let place = |t: f64| {
            let here = point.lerp(end, t + 0.5) - through;
            DQuat::from_axis_angle(axis, angle * t) * here + through + translation * t
        };
        let found = described.paths().seen([point.as_vec3(), end.as_vec3()]);
        let swept = length(place, -0.5, 0.5);
        near(found.speed_px, swept, 3e-4 * swept + 1e-3);
        let [before, after] = [-1e-4, 1e-4].map(|t| image_of(place(t)));
        let tangent = Vec2::new((after[0] - before[0]) as f32, (after[1] - before[1]) as f32);
        assert!(found.velocity_px.angle_to(tangent).abs() < 5e-3, "{found:?} {tangent}");
    }
}

#[test]
fn a_moving_camera_is_an_object_that_moves_the_other_way() {
    let step = DVec3::new(0.1, -0.05, 0.2);
    let mut tracking = at_rest();
    tracking.view.travel_m = [step.into(); 2];
    for point in POINTS {
        let [found, expected] = [&tracking, &moving(-step)].map(|described| seen(described, point));
        assert!(found.position_px.abs_diff_eq(expected.position_px, 1e-3));
        assert!(found.velocity_px.abs_diff_eq(expected.velocity_px, 1e-3));
        near(found.speed_px, f64::from(expected.speed_px), 1e-3);
        near(found.magnification, f64::from(expected.magnification), 1e-5);
    }
}

/// The renderer's rays through the ends of a path meet the point there, for a camera that pans, tracks and
/// is shifted off its axis.
#[test]
fn the_renderers_rays_meet_what_is_seen() {
    let mut described = moving(DVec3::new(0.2, 0.1, -0.1));
    described.view.travel_m = [[0.1, 0.05, -0.2], [-0.3, 0.2, 0.1]];
    described.view.shift_px = 12.0;
    let rays = RayCamera::new(&described.view, described.width_px);
    let run = &described.paths().runs[0];
    for point in POINTS {
        for (k, instant) in run.iter().enumerate() {
            let time = k as f64 / (run.len() - 1) as f64 - 0.5;
            let at = project(instant.see([point.as_vec3(); 2]));
            let (origin, direction) = rays.ray(at.x, at.y, time as f32, Vec2::ZERO);
            let to_point = (point + described.translation * time).as_vec3() - origin;
            assert!(to_point.cross(direction).length() < 1e-5, "{point} {time}");
            assert!(to_point.dot(direction) > 0.0);
        }
    }
}

/// Over a window the speed is at most that of each shutter interval in it, and that of the slowest.
#[test]
fn over_a_window_the_least_speed_counts() {
    let described = Described { window: 5, ..turning(DVec3::Y, 0.5) };
    for point in POINTS {
        let found = seen(&described, point);
        let place = |t: f64| DQuat::from_axis_angle(DVec3::Y, 0.5 * t) * point;
        let starts = (0..=400).map(|k| -2.5 + 0.01 * f64::from(k));
        let slowest = starts.map(|t| length(place, t, t + 1.0)).fold(f64::INFINITY, f64::min);
        assert!(f64::from(found.speed_px) <= slowest * 1.05 + 0.1, "{found:?} {slowest}");
        near(found.speed_px, slowest, 0.1 * slowest + 0.1);
        let nearest = (0..=400).map(|k| DISTANCE - place(-2.5 + 0.0125 * f64::from(k)).z);
        let nearest = nearest.fold(f64::INFINITY, f64::min);
        near(found.magnification, (DISTANCE - point.z) / nearest, 1e-3);
    }
}

/// What Appendix B takes for the lowest speed of a turn is not even below the mean. On a circle about an axis across
/// the view a point has its greatest speed where it is nearest, and none where cos φ = r/d.
#[test]
fn where_a_point_is_nearest_it_is_fastest() {
    let (radius, angle) = (0.5, 0.01);
    let speed_at = |phase: f64| {
        let point = DVec3::new(radius * phase.sin(), 0.0, radius * phase.cos());
        f64::from(seen(&turning(DVec3::Y, angle), point).speed_px)
    };
    let nearest = speed_at(0.0);
    near(nearest as f32, FOCAL_PX * radius * angle / (DISTANCE - radius), 1e-3);
    for k in 1..=24 {
        assert!(speed_at(f64::from(k) * PI / 24.0) < nearest, "{k}");
    }
    let still = (radius / DISTANCE).acos();
    assert!(speed_at(still) < 0.01 * nearest);
    // The rule gives every point of the circle this speed.
    let rule = Described { rule: Rule::AppendixB, ..turning(DVec3::Y, angle) };
    for phase in [0.0, 1.0, FRAC_PI_2, 3.0] {
        let point = DVec3::new(radius * f64::sin(phase), 0.2, radius * f64::cos(phase));
        near(seen(&rule, point).speed_px, nearest, 2e-3 * nearest);
    }
}

/// About the view's direction there is no nearest point, and the rule takes the arcs; along the view it sees
/// nothing move.
#[test]
fn appendix_b_takes_arcs_about_the_view_and_no_motion_along_it() {
    let by = |rule, described: Described| Described { rule, ..described };
    for point in POINTS {
        let [arc, least] = [Rule::AppendixB, Rule::Least]
            .map(|rule| seen(&by(rule, turning(DVec3::Z, 0.3)), point).speed_px);
        assert_eq!(arc, least);
        let approaching = by(Rule::AppendixB, moving(DVec3::Z * 0.5));
        assert_eq!(seen(&approaching, point).speed_px, 0.0);
        let aside = by(Rule::AppendixB, moving(DVec3::new(0.1, 0.0, 0.5)));
        assert_eq!(seen(&aside, point), seen(&moving(DVec3::X * 0.1), point));
    }
    // Leaving out the approach is no lower bound: going in towards the middle while coming nearer, a point is slower
    // than by its motion across alone.
    let (point, both) = (DVec3::new(0.8, 0.0, 0.0), moving(DVec3::new(-0.1, 0.0, 0.4)));
    let [truth, rule] = [Rule::Least, Rule::AppendixB].map(|r| seen(&by(r, both.clone()), point));
    assert!(truth.speed_px < 0.25 * rule.speed_px, "{truth:?} {rule:?}");
}

/// An object of a stimulus is where the renderer has it, in every frame that is asked for.
#[test]
fn an_object_of_a_stimulus_is_seen_where_the_renderer_shows_it() {
    let mut grid = Grid::load("rolling-sphere-mono").unwrap();
    grid.trajectory = shutterlab_stimuli::stimulus::Trajectory::Once;
    let select = "material=checker,speed=S2,shutter=T3,samples=A1";
    let stimulus = grid.stimuli(&Selection::parse(&[select], &grid).unwrap()).unwrap().remove(0);
    let sphere = &stimulus.scene.objects[0];
    // The point is given in a space of half the size whose origin is elsewhere.
    let to_object = DAffine3::from_scale(DVec3::splat(2.0)) * DAffine3::from_translation(-DVec3::X);
    let paths_in = |frames| ScreenPaths::of_stimulus(&stimulus, sphere, to_object, frames);
    let paths = paths_in(55..60);
    let point = Vec3::new(0.03, 0.06, -0.04);
    let place = |frame: u32, time: f32| {
        let object = Object::new(&stimulus, sphere, 0.0, frame);
        let pose = object.at(time);
        object.to_world(&pose, point) + pose.centre
    };
    // A place in the image by what the renderer's ray through it passes at the point's distance.
    let distance = |frame: u32, time: f32, at: Vec2| {
        let rays = RayCamera::new(&stimulus.views(frame)[0], stimulus.image.width_px);
        let (origin, direction) = rays.ray(at.x, at.y, time, Vec2::ZERO);
        (place(frame, time) - origin).cross(direction).length()
    };
    let given = [0.5 * point + Vec3::X; 2];
    let found = paths.seen(given);
    assert!(distance(57, 0.0, found.position_px) < 1e-5);
    let mut least = f32::INFINITY;
    for (run, frame) in paths.runs.iter().zip(55..) {
        let ends = [(0, -0.5), (run.len() - 1, 0.5)].map(|(k, time)| {
            let at = project(run[k].see(given));
            assert!(distance(frame, time, at) < 1e-5, "{frame} {time}");
            at
        });
        least = least.min(ends[0].distance(ends[1]));
    }
    // Half of a thirtieth of a second at 10 degrees per second is 7.4 px; what rolls is faster at the top.
    assert!(found.speed_px >= least && found.speed_px < 15.0, "{found:?} {least}");
    // For a narrower window the least is no less.
    let one = paths_in(57..58).seen(given);
    assert_eq!(one.position_px, found.position_px);
    assert!(one.speed_px >= found.speed_px);
}

/// The frame's height holds the sphere that it is framed for, and that of a narrow one its width.
#[test]
fn framing_touches_the_borders() {
    for (size, half_px) in [([800, 600], 300.0), ([300, 900], 150.0)] {
        let middle = DVec3::new(1.0, 2.0, 3.0);
        let camera = framing(middle, 0.7, size, 33.33);
        assert_eq!(DVec3::from(camera.look_at_m), middle);
        let away = DVec3::from(camera.position_m).distance(middle);
        let tangent = 0.7 / (away * away - 0.7 * 0.7).sqrt();
        assert!((camera.focal_length_px(size[0]) * tangent - half_px).abs() < 1e-9);
    }
    let paper = framing(DVec3::ZERO, 1.0, [800, 600], 33.33);
    assert!((paper.focal_length_px(800) - 1002.2).abs() < 0.1);
}

/// Points behind the camera, a camera that looks at itself, endless numbers: finite, and on the safe side.
#[test]
fn whatever_comes_in_what_comes_out_is_finite() {
    let numbers = [0.0, 1.0, -5.0, 1e9, -1e30, 1e300, f64::MIN_POSITIVE];
    let vectors = numbers.map(|n| DVec3::new(n, 0.3 * n, -n));
    let mut cases: Vec<Described> = vectors.map(moving).into();
    for vector in vectors {
        cases.push(turning(vector, vector.x));
        cases.push(Described { rule: Rule::AppendixB, ..turning(vector, vector.x) });
        let mut panning = at_rest();
        panning.view.travel_m = [vector.into(), (-vector).into()];
        cases.push(panning);
        let mut itself = at_rest();
        itself.view.camera.look_at_m = vector.into();
        itself.view.camera.position_m = vector.into();
        cases.push(itself);
    }
    for described in &cases {
        let paths = described.paths();
        for [x, y] in vectors.iter().flat_map(|a| vectors.map(|b| [a.as_vec3(), b.as_vec3()])) {
            let Seen { position_px, velocity_px, speed_px, magnification } = paths.seen([x, y]);
            let finite = position_px.is_finite() && velocity_px.is_finite();
            assert!(finite && speed_px.is_finite() && speed_px >= 0.0, "{described:?} {x} {y}");
            assert!((1.0..=MOST_MAGNIFIED).contains(&magnification), "{described:?} {x} {y}");
        }
    }
    let behind = seen(&moving(DVec3::X), DVec3::Z * 5.0);
    assert_eq!((behind.speed_px, behind.magnification), (0.0, MOST_MAGNIFIED));
    let into = seen(&moving(DVec3::Z * 9.0), DVec3::X);
    assert_eq!((into.speed_px, into.magnification), (0.0, MOST_MAGNIFIED));
}
