//! Fitted parameters and the level-of-detail law they define, in one TOML file: what an analysis found
//! and simplification reads.

use crate::definition::{self, DefinitionError};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// Parameters fitted to people's ratings of simplified models (Zhang et al. 2014): the weight of the
/// simplification, the law of its level of detail, or both.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FittedParameters {
    /// Version of this format: 1.
    pub schema: u32,
    /// Version of the program that fitted them.
    pub program_version: String,
    /// What they were fitted to.
    pub fitted_to: FittedTo,
    /// The weight of edges by their direction.
    pub weight: Option<Weight>,
    /// How fine a model in motion has to be.
    pub law: Option<LevelOfDetailLaw>,
}

/// What parameters were fitted to.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FittedTo {
    /// The study, table or publication.
    pub source: String,
    /// How many observers rated; missing if the source does not say.
    pub observers: Option<u64>,
    /// The models they rated; empty if the source does not say.
    pub models: Vec<String>,
    /// How many rated images r was chosen from or the law fitted to, or how many points, if it is through
    /// points; missing if the source does not say.
    pub points: Option<u64>,
    /// Whether the answers were simulated, a check of the tool and no finding; missing if the source does
    /// not say.
    pub simulated: Option<bool>,
}

/// The weight f(α) = 1 − (1 − cos α)^r + ε of an edge at the angle α to the motion.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Weight {
    /// The exponent r; 0 weighs all directions alike.
    #[schemars(range(min = 0.0, max = 1e6))]
    pub r: f64,
    /// In which part of the resamples of the observers this r was ahead; missing if r was not chosen but
    /// given.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub share_won: Option<f64>,
    /// The constant ε. It is not fitted: the rated models were made with it; missing if that is not known.
    #[schemars(range(min = 0.0, max = 1e6))]
    pub epsilon: Option<f64>,
}

/// The highest spatial frequency to keep at a velocity: ρ(v) = 1 / (σ₁·v + σ₂).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LevelOfDetailLaw {
    /// σ₁, in 1 / (unit of frequency · unit of velocity).
    pub sigma_1: Estimate,
    /// σ₂, in 1 / (unit of frequency).
    pub sigma_2: Estimate,
    /// The unit of v.
    pub velocity_unit: VelocityUnit,
    /// The unit of ρ.
    pub frequency_unit: FrequencyUnit,
    /// Why σ₁ and σ₂ have no standard error and no interval; missing where they have, or where it is not
    /// known.
    pub no_interval_reason: Option<String>,
}

/// A parameter and how well it is known.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Estimate {
    /// Its value, above 0.
    #[schemars(range(min = 1e-12, max = 1e12))]
    pub value: f64,
    /// Its standard error; missing where it is not known.
    #[schemars(range(min = 0.0))]
    pub se: Option<f64>,
    /// Its 95 % interval; missing where it is not known or open.
    pub interval_95: Option<[f64; 2]>,
}

/// A unit of screen velocity.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum VelocityUnit {
    /// Pixels swept while the shutter is open.
    PixelsPerShutter,
    /// Degrees of visual angle swept while the shutter is open.
    DegreesPerShutter,
    /// Degrees of visual angle per second.
    DegreesPerSecond,
}

/// A unit of the spatial frequency that a triangle stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum FrequencyUnit {
    /// 1 / (perimeter of the projected triangle in pixels). For an equilateral triangle the perimeter is
    /// 4.56·√area.
    PerPerimeterPixel,
    /// 1 / (perimeter of the projected triangle in degrees of visual angle).
    PerPerimeterDegree,
}

impl VelocityUnit {
    /// All of them.
    pub const ALL: [Self; 3] =
        [Self::PixelsPerShutter, Self::DegreesPerShutter, Self::DegreesPerSecond];

    /// Its name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::PixelsPerShutter => "pixels-per-shutter",
            Self::DegreesPerShutter => "degrees-per-shutter",
            Self::DegreesPerSecond => "degrees-per-second",
        }
    }

    /// Its symbol.
    pub fn symbol(self) -> &'static str {
        match self {
            Self::PixelsPerShutter => "px/shutter",
            Self::DegreesPerShutter => "deg/shutter",
            Self::DegreesPerSecond => "deg/s",
        }
    }
}

impl FrequencyUnit {
    /// All of them.
    pub const ALL: [Self; 2] = [Self::PerPerimeterPixel, Self::PerPerimeterDegree];

    /// Its name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::PerPerimeterPixel => "per-perimeter-pixel",
            Self::PerPerimeterDegree => "per-perimeter-degree",
        }
    }

    /// Its symbol.
    pub fn symbol(self) -> &'static str {
        match self {
            Self::PerPerimeterPixel => "1/px of perimeter",
            Self::PerPerimeterDegree => "1/deg of perimeter",
        }
    }
}

impl Weight {
    /// The weight of Zhang et al. (2014, §4.1): r = 4, ε = 0.5.
    pub const PUBLISHED: Self = Self { r: 4.0, share_won: None, epsilon: Some(0.5) };
}

impl LevelOfDetailLaw {
    /// The law as Zhang et al. (2014, §5.2) print it: σ₁ = 7.3, σ₂ = 0.36, with v in pixels per shutter
    /// and ρ the reciprocal of the projected perimeter in pixels. Their Table 1 does not follow from it in
    /// these units.
    pub const PUBLISHED: Self = Self {
        sigma_1: Estimate { value: 7.3, se: None, interval_95: None },
        sigma_2: Estimate { value: 0.36, se: None, interval_95: None },
        velocity_unit: VelocityUnit::PixelsPerShutter,
        frequency_unit: FrequencyUnit::PerPerimeterPixel,
        no_interval_reason: None,
    };

    /// The highest spatial frequency to keep at the velocity `v` ≥ 0, each in its unit.
    pub fn frequency_limit(&self, v: f64) -> f64 {
        1.0 / (self.sigma_1.value * v + self.sigma_2.value)
    }
}

impl FittedParameters {
    /// Reads and checks the file at `path`.
    ///
    /// # Errors
    /// As [`definition::read`] and [`FittedParameters::check`].
    pub fn read(path: &Path) -> Result<Self, DefinitionError> {
        let fitted: Self = definition::read(path)?;
        fitted.check(&path.display().to_string())?;
        Ok(fitted)
    }

    /// Parses and checks fitted parameters; `file` is what an error calls it.
    ///
    /// # Errors
    /// As [`definition::parse`] and [`FittedParameters::check`].
    pub fn parse(text: &str, file: &str) -> Result<Self, DefinitionError> {
        let fitted: Self = definition::parse(text, file)?;
        fitted.check(file)?;
        Ok(fitted)
    }

    /// The file's text.
    ///
    /// # Errors
    /// None for parameters that pass [`FittedParameters::check`].
    pub fn to_toml(&self) -> Result<String, toml::ser::Error> {
        toml::to_string(self)
    }

    /// Refuses values that no parameters can have.
    ///
    /// # Errors
    /// The first field that does not fit, by name.
    pub fn check(&self, file: &str) -> Result<(), DefinitionError> {
        definition::check_schema(self.schema, file)?;
        let refuse = |field: &str, value: &dyn ToString, allowed: &str| {
            Err(DefinitionError::value(file, field, value.to_string(), allowed))
        };
        if self.weight.is_none() && self.law.is_none() {
            return refuse("weight", &"missing, and law too", "at least one of them is needed");
        }
        if let Some(Weight { r, share_won, epsilon }) = &self.weight {
            let numbers = [
                ("weight.r", Some(*r), 1e6),
                ("weight.share_won", *share_won, 1.0),
                ("weight.epsilon", *epsilon, 1e6),
            ];
            for (field, value, most) in numbers {
                if let Some(value) = value.filter(|value| !(0.0..=most).contains(value)) {
                    return refuse(field, &value, &format!("0 to {most} is allowed"));
                }
            }
            if (*r, *epsilon) == (0.0, Some(0.0)) {
                return refuse(
                    "weight.epsilon",
                    &0,
                    "with r = 0 it is the weight of every edge: above 0",
                );
            }
        }
        let law =
            self.law.iter().flat_map(|law| [("sigma_1", &law.sigma_1), ("sigma_2", &law.sigma_2)]);
        for (name, estimate) in law {
            let field = |part: &str| format!("law.{name}.{part}");
            if !(1e-12..=1e12).contains(&estimate.value) {
                return refuse(&field("value"), &estimate.value, "1e-12 to 1e12 is allowed");
            }
            if let Some(se) = estimate.se.filter(|se| !(0.0..f64::INFINITY).contains(se)) {
                return refuse(&field("se"), &se, "a number from 0 is needed");
            }
            if let Some([low, high]) = estimate.interval_95
                && !(low.is_finite() && high.is_finite() && low <= high)
            {
                let value = format!("{low} to {high}");
                return refuse(&field("interval_95"), &value, "the lower bound comes first");
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fitted() -> FittedParameters {
        FittedParameters {
            schema: 1,
            program_version: "0.1.0".into(),
            fitted_to: FittedTo {
                source: "ratings.csv".into(),
                observers: None,
                models: vec!["bunny".into()],
                points: Some(8),
                simulated: Some(true),
            },
            weight: Some(Weight::PUBLISHED),
            law: Some(LevelOfDetailLaw::PUBLISHED),
        }
    }

    #[test]
    fn what_is_written_is_read_again() {
        let mut found = fitted();
        let law = found.law.as_mut().unwrap();
        law.sigma_1 =
            Estimate { value: 0.1 + 0.2, se: Some(1.0 / 3.0), interval_95: Some([-0.1, 0.7]) };
        let text = found.to_toml().unwrap();
        assert_eq!(FittedParameters::parse(&text, "f.toml").unwrap(), found, "{text}");
    }

    #[test]
    fn the_law_falls_with_the_velocity() {
        let law = LevelOfDetailLaw::PUBLISHED;
        assert!((1.0 / law.frequency_limit(10.0) - 73.36).abs() < 1e-12);
        assert!(law.frequency_limit(0.0) > law.frequency_limit(1e-3));
    }

    #[test]
    fn units_are_called_what_files_call_them() {
        for unit in VelocityUnit::ALL {
            assert_eq!(serde_json::to_value(unit).unwrap(), unit.name());
        }
        for unit in FrequencyUnit::ALL {
            assert_eq!(serde_json::to_value(unit).unwrap(), unit.name());
        }
    }

    #[test]
    fn values_out_of_range_are_refused_by_name() {
        let error = |change: &dyn Fn(&mut FittedParameters)| {
            let mut found = fitted();
            change(&mut found);
            found.check("f.toml").unwrap_err().to_string()
        };
        let law = |found: &mut FittedParameters, change: &dyn Fn(&mut Estimate)| {
            change(&mut found.law.as_mut().unwrap().sigma_2);
        };
        for (found, expected) in [
            (error(&|f| f.schema = 2), "f.toml: schema: 2"),
            (error(&|f| (f.weight, f.law) = (None, None)), "f.toml: weight: missing, and law too"),
            (error(&|f| f.weight.as_mut().unwrap().r = -1.0), "f.toml: weight.r: -1: 0 to 1000000"),
            (error(&|f| law(f, &|s| s.value = 0.0)), "f.toml: law.sigma_2.value: 0: 1e-12"),
            (error(&|f| law(f, &|s| s.value = f64::NAN)), "f.toml: law.sigma_2.value: NaN"),
            (error(&|f| law(f, &|s| s.se = Some(-1.0))), "f.toml: law.sigma_2.se: -1"),
            (
                error(&|f| law(f, &|s| s.interval_95 = Some([2.0, 1.0]))),
                "f.toml: law.sigma_2.interval_95: 2 to 1: the lower",
            ),
            (
                error(&|f| f.weight = Some(Weight { r: 0.0, share_won: None, epsilon: Some(0.0) })),
                "f.toml: weight.epsilon: 0: with r = 0",
            ),
        ] {
            assert!(found.starts_with(expected), "{found}");
        }
    }
}
