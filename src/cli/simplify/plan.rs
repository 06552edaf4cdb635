//! From the words of `simplify` to the options of the simplifier.

use super::Args;
use crate::cli::UsageError;
use crate::cli::fit::named;
use crate::cli::motion_args::Seen;
use crate::mesh::Mesh;
use crate::mesh::simplify::detail::PerimeterLimit;
use crate::mesh::simplify::direction::{ScreenMotion, Weight};
use crate::mesh::simplify::{Attributes, Options};
use serde_json::{Value, json};
use shutterlab_data_schema::FittedParameters;
use shutterlab_data_schema::fitted::{self, LevelOfDetailLaw};

/// How an edge's direction weighs, without parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum WeightKind {
    Isotropic,
    Printed,
    Mirrored,
}

/// An error that is allowed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Tolerance {
    /// In the mesh's unit.
    Length(f64),
    /// In parts of the diagonal of its bounding box.
    OfDiagonal(f64),
}

/// What the words ask for, whatever the mesh.
pub(super) struct Goal<'a> {
    args: &'a Args,
    weight: Weight,
    /// The law that limits the triangles, if it does.
    law: Option<LevelOfDetailLaw>,
}

/// What is asked for of a mesh.
pub(super) struct Plan<'a> {
    faces: Option<usize>,
    error: Option<f32>,
    weight: Weight,
    motion: Option<&'a Seen>,
    limit: Option<PerimeterLimit>,
    attributes: Attributes,
}

impl<'a> Goal<'a> {
    /// # Errors
    /// The words make no sense together, or the parameters cannot be read.
    pub(super) fn new(args: &'a Args) -> anyhow::Result<Self> {
        let has_motion = args.motion.is_given();
        let has_goal = args.faces.is_some() || args.ratio.is_some() || args.error.is_some();
        let wrong = |what: &str| Err(UsageError::from(format!("simplify: {what}")));
        if !has_motion && !has_goal {
            return wrong("one of --faces, --ratio, --error and --motion is needed");
        }
        let has_kind = args.weight.is_some_and(|kind| kind != WeightKind::Isotropic);
        if !has_motion && (has_kind || args.parameters.is_some()) {
            return wrong("--weight and --parameters are about a motion: --motion is needed");
        }
        let fitted = args.parameters.as_deref().map(FittedParameters::read).transpose()?;
        if let (Some(true), Some(file)) =
            (fitted.as_ref().and_then(|fitted| fitted.fitted_to.simulated), &args.parameters)
        {
            eprintln!("{}: fitted to simulated answers: a check, no finding", file.display());
        }
        let (weight, law) = fitted.map_or((None, None), |fitted| (fitted.weight, fitted.law));
        let has_parameters = args.r.is_some() || args.epsilon.is_some();
        // An r is that of Eq. 4 as printed. Without one there is no weight, because neither makes blurred images
        // better on the whole (docs/benchmarks.md).
        let kind = args.weight.unwrap_or(match weight.is_some() || has_parameters {
            true if has_motion => WeightKind::Printed,
            _ => WeightKind::Isotropic,
        });
        if kind == WeightKind::Isotropic && has_parameters {
            return wrong("--r and --epsilon are of --weight printed and mirrored, with --motion");
        }
        let weight = weight.unwrap_or(fitted::Weight::PUBLISHED);
        let r = args.r.unwrap_or(weight.r) as f32;
        let epsilon = args.epsilon.or(weight.epsilon).or(fitted::Weight::PUBLISHED.epsilon);
        let epsilon = epsilon.unwrap_or_default() as f32;
        let weight = match kind {
            WeightKind::Isotropic => Weight::Isotropic,
            WeightKind::Printed => Weight::Printed { r, epsilon },
            WeightKind::Mirrored => Weight::Mirrored { r, epsilon },
        };
        weight.check().map_err(|error| UsageError::from(format!("simplify: --{error}")))?;
        if !has_goal && law.is_none() {
            eprintln!(
                "the law is the published one, σ₁ = 7.3 px per px/shutter, σ₂ = 0.36 px, which does not give its own \
                 table; --parameters takes another"
            );
        }
        let law = (!has_goal).then(|| law.unwrap_or(LevelOfDetailLaw::PUBLISHED));
        Ok(Self { args, weight, law })
    }

    /// The plan for `mesh`, which is `seen` to move.
    ///
    /// # Errors
    /// The law needs to know more than the words say.
    pub(super) fn of(self, mesh: &Mesh, seen: Option<&'a Seen>) -> anyhow::Result<Plan<'a>> {
        let Self { args, weight, law } = self;
        let part = |ratio: f64| ((ratio * mesh.triangles.len() as f64) as usize).max(1);
        let diagonal = f64::from(mesh.diagonal());
        let limit = law.as_ref().zip(seen).map(|(law, seen)| {
            PerimeterLimit::from_law(law, seen.viewing)
                .map_err(|error| UsageError::from(format!("simplify: {error}")))
        });
        Ok(Plan {
            faces: args.faces.or(args.ratio.map(part)),
            error: args.error.map(|error| match error {
                Tolerance::Length(length) => length as f32,
                Tolerance::OfDiagonal(part) => (part * diagonal) as f32,
            }),
            weight,
            motion: seen,
            limit: limit.transpose()?,
            attributes: args.attributes,
        })
    }
}

impl Plan<'_> {
    pub(super) fn options(&self) -> Options<'_> {
        Options {
            faces: self.faces(),
            error: self.error,
            weight: self.weight,
            motion: self.motion.map(|seen| &seen.paths as &dyn ScreenMotion),
            limit: self.limit,
            attributes: self.attributes,
        }
    }

    /// How many faces to stop at.
    pub(super) fn faces(&self) -> usize {
        self.faces.unwrap_or(1)
    }

    /// Whether `mesh` has as few faces as were asked for, if a number was.
    pub(super) fn is_reached(&self, mesh: &Mesh) -> bool {
        self.faces.is_none_or(|faces| mesh.triangles.len() <= faces)
    }

    /// What was asked for, in the mesh's unit and pixels.
    pub(super) fn told(&self) -> Value {
        let weight = match self.weight {
            Weight::Isotropic => json!({ "kind": "isotropic" }),
            Weight::Printed { r, epsilon } => {
                json!({ "kind": "printed", "r": r, "epsilon": epsilon })
            }
            Weight::Mirrored { r, epsilon } => {
                json!({ "kind": "mirrored", "r": r, "epsilon": epsilon })
            }
        };
        let limit = self.limit.map(|PerimeterLimit { slope, intercept_px }| {
            json!({ "px_per_px_per_shutter": slope, "px_at_rest": intercept_px })
        });
        let attributes = match self.attributes {
            Attributes::Averaged => "averaged",
            Attributes::Quadrics => "quadrics",
        };
        json!({
            "faces": self.faces,
            "error": self.error,
            "weight": weight,
            "largest_perimeter": limit,
            "attributes": attributes,
        })
    }
}

pub(super) fn parse_faces(text: &str) -> Result<usize, String> {
    let number = text.parse().ok().filter(|&number| number >= 1);
    number.ok_or("a whole number from 1 is needed".into())
}

pub(super) fn parse_ratio(text: &str) -> Result<f64, String> {
    let number = text.parse().ok().filter(|&number| number > 0.0 && number <= 1.0);
    number.ok_or("a number above 0 and up to 1 is needed".into())
}

pub(super) fn parse_tolerance(text: &str) -> Result<Tolerance, String> {
    let (number, is_part) = match text.strip_suffix('%') {
        Some(number) => (number, true),
        None => (text, false),
    };
    let number = number.trim().parse().ok().filter(|number| (0.0..=1e9).contains(number));
    let number: f64 =
        number.ok_or("a number from 0 to 1e9 is needed, or a percentage such as 0.1%")?;
    Ok(if is_part { Tolerance::OfDiagonal(number / 100.0) } else { Tolerance::Length(number) })
}

pub(super) fn parse_weight(text: &str) -> Result<WeightKind, String> {
    use WeightKind::{Isotropic, Mirrored, Printed};
    named(text, &[("isotropic", Isotropic), ("printed", Printed), ("mirrored", Mirrored)])
}

pub(super) fn parse_attributes(text: &str) -> Result<Attributes, String> {
    named(text, &[("quadrics", Attributes::Quadrics), ("averaged", Attributes::Averaged)])
}
