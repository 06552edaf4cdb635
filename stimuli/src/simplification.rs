//! How a stimulus's model is simplified.

use serde::{Deserialize, Serialize};
use shutterlab_data_schema::definition::DefinitionError;

/// How the model of a stimulus is simplified for its motion (Zhang et al. 2014).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Simplification {
    /// Part of the model's faces that is left, above 0 and below 1.
    pub level_of_detail: f64,
    /// Exponent r of the weight of edges by their direction (Eq. 4); with 0 all directions weigh alike.
    pub r: f64,
    /// Constant ε of the weight.
    pub epsilon: f64,
}

impl Simplification {
    /// The paper's ε (§4.1).
    pub(crate) const EPSILON: f64 = 0.5;

    /// Refuses what nothing can be simplified to; `file` is the manifest that it stands in.
    pub(crate) fn check(&self, file: &str) -> Result<(), DefinitionError> {
        let refuse = |field: &str, value: f64, allowed: &str| {
            let field = format!("simplification.{field}");
            Err(DefinitionError::value(file, field, value, allowed))
        };
        if !(self.level_of_detail > 0.0 && self.level_of_detail < 1.0) {
            let allowed = "a part above 0 and below 1 is needed";
            return refuse("level_of_detail", self.level_of_detail, allowed);
        }
        if !(0.0..=MOST_R).contains(&self.r) {
            return refuse("r", self.r, &format!("0 to {MOST_R} is allowed"));
        }
        // With r = 0 it is the weight of every edge.
        if !(self.epsilon > 0.0 && self.epsilon <= 1e6) {
            return refuse("epsilon", self.epsilon, "a number above 0 and up to 1000000 is needed");
        }
        Ok(())
    }
}

/// Largest r, with which all edges that are not quite across the motion weigh alike.
pub(crate) const MOST_R: f64 = 1000.0;
