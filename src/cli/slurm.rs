//! `shutterlab render --slurm`: a job array that renders a grid on a cluster, one part of the work per
//! task. A task that failed or was killed is submitted again by its number, and goes on where it stopped.

use super::render::Args;
use super::say;
use anyhow::Context;
use shutterlab_data_schema::files::{create_folder, write_atomically};
use std::path::Path;

/// Array indices that Slurm allows unless it is told otherwise (`MaxArraySize`).
const MOST_TASKS: usize = 1000;

/// Writes `render.sbatch` into the output folder, for `passes` independent passes of the grid `name`.
pub(super) fn write(args: &Args, name: &str, passes: usize) -> anyhow::Result<()> {
    create_folder(&args.out)?;
    let absolute = |path: &Path| {
        let resolved = std::path::absolute(path);
        resolved.with_context(|| format!("{}: cannot be resolved", path.display()))
    };
    let out = absolute(&args.out)?;
    let program = std::env::current_exe().context("the program's own path is not known")?;
    let grid = match Path::new(&args.grid) {
        file if file.exists() => absolute(file)?.display().to_string(),
        _ => args.grid.clone(),
    };
    let tasks = passes.clamp(1, MOST_TASKS);
    let mut words = vec![
        quoted(&program.display().to_string()),
        "render".into(),
        quoted(&grid),
        "-o".into(),
        quoted(&out.display().to_string()),
        "--shard".into(),
        format!("\"$SLURM_ARRAY_TASK_ID/{tasks}\""),
    ];
    words.extend(args.restrictions().iter().map(|word| quoted(word)));
    let script = format!(
        "#!/bin/sh\n\
         # Renders the grid {name}: {passes} passes in {tasks} tasks, which need no coordination.\n\
         # Submit it with: sbatch FILE; one task again with: sbatch --array=I FILE\n\
         #SBATCH --job-name={name}\n\
         #SBATCH --array=1-{tasks}\n\
         #SBATCH --output={}/slurm-%A-%a.log\n\
         exec {}\n",
        out.display(),
        words.join(" ")
    );
    let file = out.join("render.sbatch");
    write_atomically(&file, script.as_bytes())?;
    say(&file.display().to_string())
}

/// `word` as one word of a shell.
fn quoted(word: &str) -> String {
    format!("'{}'", word.replace('\'', r"'\''"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quotes_survive_the_shell() {
        let word = "a 'b' $c \"d\" \\e";
        let script = format!("printf %s {}", quoted(word));
        let output = std::process::Command::new("sh").args(["-c", &script]).output().unwrap();
        assert_eq!(String::from_utf8(output.stdout).unwrap(), word);
    }
}
