//! `shutterlab render --slurm`: a job array that renders a grid on a cluster, one part of the work per
//! task. A task that failed or was killed is submitted again by its number, and goes on where it stopped.
//! `script/slurm` tries it under a real Slurm.

use super::render::Args;
use super::say;
use anyhow::{Context, anyhow};
use shutterlab_data_schema::files::{create_folder, write_atomically};
use shutterlab_stimuli::Grid;
use std::path::Path;

/// Array indices that Slurm allows unless it is told otherwise (`MaxArraySize`).
const MOST_TASKS: usize = 1000;

/// Writes `render.sbatch` into the output folder, for `passes` independent passes of the grid `name`.
pub(super) fn write(args: &Args, name: &str, passes: usize) -> anyhow::Result<()> {
    let out = absolute(&args.out)?;
    // Slurm replaces no % in a log file's path that holds a backslash: all tasks would share one log.
    if cfg!(unix) && out.contains('\\') {
        return Err(anyhow!(
            "render: --slurm: {out}: Slurm allows no backslash in a log file's path"
        ));
    }
    let program = std::env::current_exe().context("the program's own path is not known")?;
    let program = absolute(&program)?;
    // A shipped grid comes before a file of the same name, here as there.
    let is_shipped = Grid::is_shipped(&args.grid);
    let grid = if is_shipped { args.grid.clone() } else { absolute(Path::new(&args.grid))? };
    let tasks = passes.clamp(1, MOST_TASKS);
    let mut words = vec![quoted(&program), "render".into(), quoted(&grid)];
    words.extend(["-o".into(), quoted(&out), "--shard".into()]);
    words.push(format!("\"$SLURM_ARRAY_TASK_ID/{tasks}\""));
    words.extend(args.restrictions().iter().map(|word| quoted(word)));
    if let Some(models) = &args.models {
        words.extend(["--models".into(), quoted(&absolute(models)?)]);
    }
    let script = format!(
        "#!/bin/sh\n\
         # Renders the grid {name}: {passes} passes in {tasks} tasks, which need no coordination.\n\
         # Submit it with: sbatch FILE; one task again with: sbatch --array=I FILE\n\
         #SBATCH --job-name={}\n\
         #SBATCH --array=1-{tasks}\n\
         #SBATCH --output={}\n\
         exec {}\n",
        quoted_for_sbatch(name),
        quoted_for_sbatch(&format!("{}/slurm-%A-%a.log", out.replace('%', "%%"))),
        words.join(" ")
    );
    create_folder(&args.out)?;
    let file = args.out.join("render.sbatch");
    write_atomically(&file, script.as_bytes())?;
    say(&Path::new(&out).join("render.sbatch").display().to_string())
}

/// `path` from the root, as it can stand in a line of the script.
fn absolute(path: &Path) -> anyhow::Result<String> {
    let shown = path.display();
    let path = std::path::absolute(path).with_context(|| format!("{shown}: cannot be resolved"))?;
    let text = path.to_str().filter(|text| !text.contains(char::is_control));
    let refuse = || anyhow!("render: --slurm: {shown:?}: a path of printable UTF-8 is needed");
    text.map(String::from).ok_or_else(refuse)
}

/// `word` as one word of a shell.
fn quoted(word: &str) -> String {
    format!("'{}'", word.replace('\'', r"'\''"))
}

/// `word` as one word of an `#SBATCH` line. sbatch is no shell: there, a backslash keeps no space.
fn quoted_for_sbatch(word: &str) -> String {
    format!("\"{}\"", word.replace('\\', r"\\").replace('"', r#"\""#))
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

    /// As sbatch 22.05 reads them: `scontrol show job` gave the word back.
    #[test]
    fn quotes_survive_sbatch() {
        assert_eq!(quoted_for_sbatch("a b \"c\" #d 'e'"), r#""a b \"c\" #d 'e'""#);
    }
}
