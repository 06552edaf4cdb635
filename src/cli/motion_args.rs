//! The words of `simplify` that say how a model moves and who looks at it.

use super::UsageError;
use super::render::{load_grid, parse_range, parse_size};
use crate::mesh::Mesh;
use crate::mesh::simplify::detail::Viewing;
use crate::scene::import;
use crate::scene::screen_motion::{Described, Rule, ScreenPaths, Turn, camera, framing};
use crate::scene::world::fitting;
use glam::{DAffine3, DVec3};
use shutterlab_data_schema::definition::nearest;
use shutterlab_stimuli::Selection;
use shutterlab_stimuli::scene::{self, Shape};
use shutterlab_stimuli::stimulus::View;
use std::fmt::Display;
use std::ops::Range;
use std::path::PathBuf;

/// The options in whose place a grid stands.
const DESCRIBED: [&str; 10] = [
    "motion",
    "speed",
    "camera",
    "field_of_view",
    "size",
    "end_mesh",
    "window",
    "speed_rule",
    "pixels_per_degree",
    "shutter_seconds",
];

/// How a model moves and who looks at it.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Motion")]
pub struct MotionArgs {
    /// How it moves: along x, y, z or DX,DY,DZ; rotate:AX,AY,AZ[@CX,CY,CZ], about an axis through a point
    /// (else the middle of the model's bounding box); camera:DX,DY,DZ or pan:DX,DY,DZ, the camera along
    /// or its view aside. Given again, another kind of motion at the same time
    #[arg(long, allow_hyphen_values = true, requires = "speed", value_parser = parse_motion)]
    motion: Vec<Motion>,
    /// Pixels per shutter of each of them: of the model's middle if it moves across the view, of its point
    /// farthest from the axis if it turns. What goes another way goes as many metres
    #[arg(long, value_name = "PX", requires = "motion", allow_negative_numbers = true, value_parser = parse_speed)]
    speed: Option<f64>,
    /// Where the camera is, and the point it looks at (else the model's middle). Without this, it looks
    /// along −z from so far away that a sphere about the model fills the image's height (or its width)
    #[arg(long, value_name = "X,Y,Z[:X,Y,Z]", allow_hyphen_values = true, value_parser = parse_camera)]
    camera: Option<(DVec3, Option<DVec3>)>,
    /// Angle of the image's height, in degrees
    #[arg(long, value_name = "DEG", default_value_t = 33.33, value_parser = parse_field_of_view)]
    field_of_view: f64,
    /// Size of the image in pixels
    #[arg(long, value_name = "WxH", default_value = "800x600", value_parser = parse_size)]
    size: [u32; 2],
    /// The model as the shutter closes, the same faces vertex for vertex, if it deforms
    #[arg(long, value_name = "FILE")]
    pub(super) end_mesh: Option<PathBuf>,
    /// For how many shutter intervals, one after another, the model is to do; the given place and pose are
    /// those of half that time
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=1000))]
    window: u32,
    /// The speed that counts: the least in the window, or that of the paper's Appendix B
    #[arg(long, value_name = "RULE", default_value = "least", value_parser = parse_rule)]
    speed_rule: Rule,
    /// Pixels per degree of visual angle, for a law in degrees
    #[arg(long, value_name = "N", value_parser = parse_positive)]
    pixels_per_degree: Option<f64>,
    /// How long the shutter is open, for a law in degrees per second
    #[arg(long, value_name = "S", value_parser = parse_positive)]
    shutter_seconds: Option<f64>,
    /// Take motion, camera and shutter from a stimulus of this grid, where the model is an object
    #[arg(long, requires = "stimulus", conflicts_with_all = DESCRIBED)]
    grid: Option<String>,
    /// The stimulus, such as M2-S2-T5-A3
    #[arg(long, value_name = "ID", requires = "grid")]
    stimulus: Option<String>,
    /// The object of the grid's scene, if there are several meshes
    #[arg(long, value_name = "NAME", requires = "grid")]
    object: Option<String>,
    /// Frames A to B−1 of the stimulus; without this, all
    #[arg(long, value_name = "A..B", requires = "grid", value_parser = parse_range)]
    frames: Option<Range<u32>>,
}

/// A motion without its speed.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Motion {
    Translate(DVec3),
    Rotate(DVec3, Option<DVec3>),
    Camera(DVec3),
    Pan(DVec3),
}

/// A model's motion as seen, and what the units of a law need.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Seen {
    /// The paths of its points over the image.
    pub(super) paths: ScreenPaths,
    /// What is known of display and shutter.
    pub(super) viewing: Viewing,
}

impl MotionArgs {
    /// Whether anything is said of a motion or a camera.
    pub(super) fn is_given(&self) -> bool {
        let is_described =
            !self.motion.is_empty() || self.end_mesh.is_some() || self.camera.is_some();
        is_described || self.grid.is_some()
    }

    /// How `mesh` is seen to move, if anything is said of it. If it deforms, its second pose is read.
    ///
    /// # Errors
    /// Of words: the motion makes no sense for the mesh. Else a file cannot be used.
    pub(super) fn resolve(&self, mesh: &mut Mesh) -> anyhow::Result<Option<Seen>> {
        if let Some(grid) = &self.grid {
            return self.of_grid(grid, mesh).map(Some);
        }
        if let Some(file) = &self.end_mesh {
            mesh.end_positions = Some(import::second_pose(file, mesh)?);
        }
        if !self.is_given() {
            return Ok(None);
        }
        let viewing = Viewing {
            pixels_per_degree: self.pixels_per_degree,
            shutter_seconds: self.shutter_seconds,
        };
        Ok(Some(Seen { paths: self.described(mesh)?.paths(), viewing }))
    }

    /// How `mesh` is looked at, and the width of the image in pixels. In place of a grid's camera, that without
    /// words.
    ///
    /// # Errors
    /// As [`MotionArgs::resolve`].
    pub(super) fn view(&self, mesh: &Mesh) -> anyhow::Result<(View, u32)> {
        let Described { view, width_px, .. } = self.described(mesh)?;
        Ok((view, width_px))
    }

    fn described(&self, mesh: &Mesh) -> anyhow::Result<Described> {
        let (middle, radius) = mesh.bounding_sphere();
        let middle = middle.as_dvec3();
        let camera = match self.camera {
            Some((position, look_at)) => {
                camera(position, look_at.unwrap_or(middle), self.size, self.field_of_view)
            }
            // A model that is a point gives no size to be framed by.
            None => framing(middle, f64::from(radius).max(1e-6), self.size, self.field_of_view),
        };
        let position = DVec3::from(camera.position_m);
        let depth = (middle - position).dot(DVec3::from(camera.forward()));
        if depth <= 0.0 {
            let allowed = format!("the model's middle {middle} is not in front of it");
            return Err(wrong("--camera", position, &allowed));
        }
        let width_px = self.size[0];
        // Across the view, where the model's middle is.
        let metres = self.speed.unwrap_or(0.0) * depth / camera.focal_length_px(width_px);
        let [mut translation, mut travel, mut pan] = [None; 3];
        let mut turn = None;
        for motion in &self.motion {
            let before = match *motion {
                Motion::Translate(direction) => translation.replace(direction * metres).is_some(),
                Motion::Camera(direction) => travel.replace(direction * metres).is_some(),
                Motion::Pan(direction) => pan.replace(direction * metres).is_some(),
                Motion::Rotate(axis, through) => {
                    let through = through.unwrap_or(middle);
                    let radii = mesh.positions.iter().map(|&point| {
                        (point.as_dvec3() - through).reject_from_normalized(axis).length()
                    });
                    let radius = radii.fold(0.0, f64::max);
                    let angle = if radius > 0.0 { metres / radius } else { 0.0 };
                    turn.replace(Turn { axis, through, angle }).is_some()
                }
            };
            if before {
                let given = match motion {
                    Motion::Translate(_) => "a second translation",
                    Motion::Rotate(..) => "a second rotation",
                    Motion::Camera(_) => "a second motion of the camera",
                    Motion::Pan(_) => "a second pan",
                };
                return Err(wrong("--motion", given, "each kind of motion is given once"));
            }
        }
        let [translation, travel, pan] = [translation, travel, pan].map(Option::unwrap_or_default);
        let travel_m = [travel.into(), (travel + pan).into()];
        Ok(Described {
            view: View { camera, travel_m, shift_px: 0.0, noise: 0 },
            width_px,
            translation,
            turn,
            window: self.window,
            rule: self.speed_rule,
        })
    }

    /// As the stimulus of the grid called `name` has it.
    fn of_grid(&self, name: &str, mesh: &mut Mesh) -> anyhow::Result<Seen> {
        let (stimuli, assets) = load_grid(name)?.resolve(&Selection::default())?;
        let id = self.stimulus.as_deref().unwrap_or_default();
        let stimulus = pick("--stimulus", id, &stimuli, |stimulus| &stimulus.id)?;
        let meshes = stimulus.scene.objects.iter();
        let meshes = meshes.filter(|object| matches!(object.shape, Shape::Mesh { .. }));
        let meshes: Vec<&scene::Object> = meshes.collect();
        let object = match (&self.object, &meshes[..]) {
            (Some(name), _) => pick("--object", name, &meshes, |object| &object.name)?,
            (None, [object]) => object,
            (None, []) => {
                let allowed = "a scene with a mesh is needed: this one has none";
                return Err(wrong("--grid", name, allowed));
            }
            (None, _) => {
                let given = format!("missing, of {} meshes", meshes.len());
                return Err(wrong("--object", given, "the name of one is needed"));
            }
        };
        let deformation = object.motion.as_ref().and_then(|motion| motion.deformation.as_ref());
        if let Some(second) = deformation
            && let Some(asset) = assets.iter().find(|asset| asset.sha256 == second.sha256)
        {
            mesh.end_positions = Some(import::second_pose(&asset.source, mesh)?);
        }
        let to_object = match object.shape {
            Shape::Mesh { radius_m: Some(radius), .. } => {
                let (middle, scale) = fitting(mesh, radius as f32);
                DAffine3::from_scale(DVec3::splat(scale.into()))
                    * DAffine3::from_translation(-middle.as_dvec3())
            }
            _ => DAffine3::IDENTITY,
        };
        let all = 0..stimulus.image.frames;
        let frames = self.frames.clone().unwrap_or(all.clone());
        if frames.is_empty() || frames.end > all.end {
            let allowed = format!("frames of {all:?} are allowed, one at least");
            return Err(wrong("--frames", format!("{frames:?}"), &allowed));
        }
        let viewing = Viewing {
            pixels_per_degree: Some(stimulus.pixels_per_degree),
            shutter_seconds: Some(stimulus.shutter_open_fraction / stimulus.image.fps),
        };
        Ok(Seen { paths: ScreenPaths::of_stimulus(stimulus, object, to_object, frames), viewing })
    }
}

/// The one of `all` that is called `name`.
fn pick<'a, T>(
    option: &str,
    name: &str,
    all: &'a [T],
    called: impl Fn(&T) -> &str,
) -> anyhow::Result<&'a T> {
    all.iter().find(|one| called(one) == name).ok_or_else(|| {
        let near = nearest(name, all.iter().map(&called));
        let allowed = match near {
            Some(near) => format!("there is none; did you mean {near}?"),
            None => {
                let names: Vec<&str> = all.iter().take(12).map(&called).collect();
                let more = if all.len() > names.len() { ", …" } else { "" };
                format!("there is none; there are {}{more}", names.join(", "))
            }
        };
        wrong(option, name, &allowed)
    })
}

fn wrong(option: &str, value: impl Display, allowed: &str) -> anyhow::Error {
    UsageError::from(format!("simplify: {option}: {value}: {allowed}"))
}

fn parse_motion(text: &str) -> Result<Motion, String> {
    let (kind, rest) = text.split_once(':').unwrap_or(("", text));
    match kind {
        "" => Ok(Motion::Translate(parse_direction(rest)?)),
        "camera" => Ok(Motion::Camera(parse_direction(rest)?)),
        "pan" => Ok(Motion::Pan(parse_direction(rest)?)),
        "rotate" => {
            let (axis, through) = match rest.split_once('@') {
                Some((axis, through)) => (axis, Some(parse_point(through)?)),
                None => (rest, None),
            };
            Ok(Motion::Rotate(parse_direction(axis)?, through))
        }
        _ => Err(format!("{kind}: x, y, z, DX,DY,DZ, rotate:…, camera:… and pan:… are allowed")),
    }
}

/// A unit vector.
fn parse_direction(text: &str) -> Result<DVec3, String> {
    let direction = match text.trim() {
        "x" => DVec3::X,
        "y" => DVec3::Y,
        "z" => DVec3::Z,
        _ => parse_point(text)?,
    };
    direction.try_normalize().ok_or("a direction of a length above 0 is needed".into())
}

fn parse_point(text: &str) -> Result<DVec3, String> {
    let numbers: Option<Vec<f64>> = text.split(',').map(|n| n.trim().parse().ok()).collect();
    match numbers.as_deref() {
        Some(&[x, y, z]) if [x, y, z].iter().all(|n| n.abs() <= 1e9) => Ok(DVec3::new(x, y, z)),
        _ => Err(format!("{text}: three numbers from -1e9 to 1e9 are needed, such as 0,0.5,3")),
    }
}

fn parse_camera(text: &str) -> Result<(DVec3, Option<DVec3>), String> {
    let (position, look_at) = match text.split_once(':') {
        Some((position, look_at)) => (position, Some(parse_point(look_at)?)),
        None => (text, None),
    };
    Ok((parse_point(position)?, look_at))
}

fn parse_number(text: &str, range: std::ops::RangeInclusive<f64>) -> Result<f64, String> {
    let allowed = || format!("a number from {} to {} is needed", range.start(), range.end());
    text.trim().parse().ok().filter(|number| range.contains(number)).ok_or_else(allowed)
}

fn parse_speed(text: &str) -> Result<f64, String> {
    parse_number(text, 0.0..=1e6)
}

fn parse_field_of_view(text: &str) -> Result<f64, String> {
    parse_number(text, 0.01..=179.0)
}

fn parse_positive(text: &str) -> Result<f64, String> {
    parse_number(text, 1e-9..=1e6)
}

fn parse_rule(text: &str) -> Result<Rule, String> {
    match text {
        "least" => Ok(Rule::Least),
        "appendix-b" => Ok(Rule::AppendixB),
        _ => Err("least and appendix-b are allowed".into()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::simplify::direction::{self, ScreenMotion};
    use clap::Parser;
    use glam::Vec3;

    #[derive(Debug, Parser)]
    struct Words {
        #[command(flatten)]
        motion: MotionArgs,
    }

    /// An octahedron of radius 2 about (1, 0, 0).
    fn mesh() -> Mesh {
        let corners = [Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y, Vec3::Z, Vec3::NEG_Z];
        Mesh {
            positions: corners.map(|corner| Vec3::X + 2.0 * corner).into(),
            triangles: vec![[0, 2, 4]],
            ..Mesh::default()
        }
    }

    fn resolve(words: &str) -> Result<Option<Seen>, String> {
        let words = std::iter::once("simplify").chain(words.split_whitespace());
        let words = Words::try_parse_from(words).map_err(|error| error.to_string())?;
        words.motion.resolve(&mut mesh()).map_err(|error| error.to_string())
    }

    fn seen(words: &str, point: Vec3) -> direction::Seen {
        resolve(words).unwrap().unwrap().paths.seen([point; 2])
    }

    fn near(found: f32, expected: f32, tolerance: f32) {
        assert!((found - expected).abs() <= tolerance, "{found} {expected}");
    }

    #[test]
    fn without_a_word_nothing_moves() {
        assert_eq!(resolve(""), Ok(None));
        let still = seen("--camera 1,0,10", Vec3::X);
        assert_eq!((still.speed_px, still.position_px), (0.0, glam::Vec2::ZERO));
    }

    /// `--speed` is that of the middle of what goes across the view, and of the rim of what turns.
    #[test]
    fn the_speed_is_the_middles_or_the_rims() {
        for motion in ["x", "-1,0,0", "3,4,0", "camera:0,1,0", "pan:x"] {
            near(seen(&format!("--motion {motion} --speed 30"), Vec3::X).speed_px, 30.0, 0.1);
        }
        let turning = |point| seen("--motion rotate:z --speed 90", point).speed_px;
        near(turning(Vec3::X), 0.0, 1e-2);
        near(turning(Vec3::X + 2.0 * Vec3::Y), 90.0, 0.1);
        near(turning(Vec3::X + Vec3::Y), 45.0, 0.1);
        let about = |point| seen("--motion rotate:0,0,-2@0,0,0 --speed 90", point).speed_px;
        near(about(Vec3::ZERO), 0.0, 1e-2);
        near(about(3.0 * Vec3::X), 90.0, 0.1);
        // Along the view the middle stays; a translation and a turn go together.
        near(seen("--motion z --speed 30", Vec3::X).speed_px, 0.0, 1e-2);
        let both = seen("--motion x --motion rotate:z --speed 30", Vec3::X + 2.0 * Vec3::Y);
        near(both.velocity_px.x, 0.0, 0.2);
    }

    /// By default the sphere about the model touches the upper and lower border.
    #[test]
    fn by_default_the_image_holds_the_model() {
        let top = seen("--motion x --speed 1", Vec3::X + 2.0 * Vec3::Y);
        assert!((250.0..300.0).contains(&-top.position_px.y), "{top:?}");
        let half = seen("--motion x --speed 1 --size 400x300", Vec3::X + 2.0 * Vec3::Y);
        near(half.position_px.y, 0.5 * top.position_px.y, 1e-2);
    }

    #[test]
    fn wrong_words_are_told() {
        for (words, expected) in [
            ("--motion 0,0,0 --speed 1", "a direction of a length above 0 is needed"),
            ("--motion 1,2 --speed 1", "1,2: three numbers from -1e9 to 1e9 are needed"),
            ("--motion 1,nan,0 --speed 1", "three numbers"),
            ("--motion spin:z --speed 1", "spin: x, y, z, DX,DY,DZ, rotate:…"),
            ("--motion x --speed -1", "a number from 0 to 1000000 is needed"),
            ("--motion x --speed inf", "a number from 0 to 1000000 is needed"),
            ("--motion x", "--speed <PX>"),
            ("--motion x --motion y --speed 1", "each kind of motion is given once"),
            ("--camera 1,0,0:1,0,0", "--camera: [1, 0, 0]: the model's middle [1, 0, 0] is not"),
            ("--camera 0,0,5:0,0,9", "the model's middle [1, 0, 0] is not in front of it"),
            ("--camera 0,0,5 --field-of-view 180", "a number from 0.01 to 179 is needed"),
            ("--grid demo", "--stimulus <ID>"),
            ("--grid demo --stimulus M1 --motion x --speed 1", "cannot be used with"),
            ("--grid demo --stimulus M2-S2-T5-A9", "--stimulus: M2-S2-T5-A9: there is none"),
            ("--end-mesh none.ply", "none.ply: cannot be read"),
        ] {
            let found = resolve(words).unwrap_err();
            assert!(found.contains(expected), "{words}: {found}");
        }
    }

    /// A grid tells motion, camera and units; the model is where the scene has its object.
    #[test]
    fn a_grid_tells_motion_and_units() {
        let folder = tempfile::tempdir().unwrap();
        let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text);
        let obj = "v 3 0 0\nv -1 0 0\nv 1 2 0\nv 1 -2 0\nv 1 0 2\nv 1 0 -2\nf 1 3 5\n";
        write("model.obj", obj).unwrap();
        let scene = "schema = 1\nname = \"s\"\n[camera]\nposition_m = [0, 0, 3]\nlook_at_m = \
                     [0, 0, 0]\nfocal_length_mm = 50\nsensor_width_mm = 36\n[environment]\nbuilt-in = \
                     \"clear-sky\"\n[[objects]]\nname = \"model\"\nshape = { kind = \"mesh\", file = \
                     \"model.obj\", radius_m = 0.5 }\nmotion = { translation = [1, 0, 0] }\n";
        write("scene.toml", scene).unwrap();
        let mut grid = shutterlab_stimuli::Grid::load("rolling-sphere-mono").unwrap();
        grid.scene = "scene.toml".into();
        grid.trajectory = shutterlab_stimuli::stimulus::Trajectory::Once;
        write("grid.toml", &toml::to_string(&grid).unwrap()).unwrap();

        let words = format!("--grid {}/grid.toml --stimulus M2-S2-T5-A1", folder.path().display());
        let Seen { paths, viewing } =
            resolve(&format!("{words} --frames 60..61")).unwrap().unwrap();
        let middle = paths.seen([Vec3::X; 2]);
        near(middle.position_px.length(), 0.0, 1e-3);
        // 10 degrees per second at 44.44 px per degree for a thirtieth of a second.
        near(middle.speed_px, 444.4 / 30.0, 0.01);
        near(viewing.shutter_seconds.unwrap() as f32, 1.0 / 30.0, 1e-6);
        near(viewing.pixels_per_degree.unwrap() as f32, 44.44, 0.01);
        let top = paths.seen([Vec3::X + 2.0 * Vec3::Y; 2]);
        near(top.position_px.y, -0.5 * 640.0 * 50.0 / 36.0 / 3.0, 1e-2);
        let error = resolve(&format!("{words} --frames 60..60")).unwrap_err();
        assert!(error.contains("--frames: 60..60: frames of 0..120"), "{error}");
        let error = resolve(&format!("{words} --object modle")).unwrap_err();
        assert!(error.contains("--object: modle: there is none; did you mean model?"), "{error}");
    }
}
