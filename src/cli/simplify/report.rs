//! What `simplify` tells of its work.

use super::Args;
use super::plan::Plan;
use crate::cli::counted;
use crate::mesh::distance::distance;
use crate::mesh::simplify::Simplified;
use crate::mesh::{Mesh, topology::Topology};
use serde_json::{Map, Value, json};
use std::time::Instant;

/// How many points of each surface the distance between them is measured at.
const SAMPLES: usize = 500_000;

/// How long each stage of the work took.
pub(super) struct Clock {
    stage_began: Instant,
    seconds: Map<String, Value>,
}

impl Default for Clock {
    fn default() -> Self {
        Self { stage_began: Instant::now(), seconds: Map::new() }
    }
}

impl Clock {
    /// Ends the stage called `name`.
    pub(super) fn stage(&mut self, name: &str) {
        self.seconds.insert(name.into(), self.stage_began.elapsed().as_secs_f64().into());
        self.stage_began = Instant::now();
    }
}

pub(super) fn text(args: &Args, before: &Mesh, found: &Simplified, clock: &Clock) -> String {
    let counts = |mesh: &Mesh| {
        let vertices = if mesh.positions.len() == 1 { "vertex" } else { "vertices" };
        format!("{}, {} {vertices}", counted(mesh.triangles.len(), "face"), mesh.positions.len())
    };
    let seconds: f64 = clock.seconds.values().filter_map(Value::as_f64).sum();
    let part = 100.0 * f64::from(found.error) / f64::from(before.diagonal());
    format!(
        "{}: {}\n{}: {}\nlargest error of a contraction: {:.3e} ({part:.3} % of the diagonal)\n\
         {seconds:.2} s",
        args.mesh.display(),
        counts(before),
        args.out.display(),
        counts(&found.mesh),
        found.error,
    )
}

pub(super) fn json(
    args: &Args,
    plan: &Plan,
    before: &Mesh,
    found: &Simplified,
    left_out: &[String],
    mut clock: Clock,
) -> Value {
    let after = &found.mesh;
    let measured = distance(before, after, SAMPLES).symmetric();
    let diagonal = f64::from(before.diagonal());
    let relative = measured.over(diagonal);
    let topology = [before, after].map(Topology::of);
    clock.stage("measure");
    json!({
        "mesh": args.mesh,
        "out": args.out,
        "left_out": left_out,
        "asked": plan.told(),
        "goal_reached": plan.is_reached(after),
        "before": topology[0],
        "after": topology[1],
        "diagonal": diagonal,
        "largest_contraction_error": found.error,
        "distance": { "rms": measured.rms, "mean": measured.mean, "hausdorff": measured.max },
        "distance_of_diagonal": {
            "rms": relative.rms, "mean": relative.mean, "hausdorff": relative.max,
        },
        "seconds": clock.seconds,
        "program_version": env!("CARGO_PKG_VERSION"),
        "command": std::env::args_os().map(|word| word.to_string_lossy().into_owned()).collect::<Vec<_>>(),
    })
}
