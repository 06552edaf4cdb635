//! The stimuli of a protocol as rendered sequences: found in a folder, checked against what the
//! protocol names, and put into the order of the grid.

use crate::design::{Pool, R};
use shutterlab_data_schema::Protocol;
use shutterlab_data_schema::definition::nearest;
use shutterlab_data_schema::protocol::ObviousPair;
use shutterlab_stimuli::manifest::SequenceError;
use shutterlab_stimuli::{Sequence, Stimulus};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// The sequences that a protocol compares, and those of its practice pairs.
#[derive(Clone, Debug)]
pub struct StimulusSet {
    /// First the compared ones in the order of the grid, then any that only practice uses.
    pub sequences: Vec<Sequence>,
    /// How many of them are compared.
    pub compared: usize,
    /// Practice pairs: indices of better and worse.
    pub practice: Vec<(usize, usize)>,
    /// Catch pairs: indices of better and worse.
    pub catch: Vec<(usize, usize)>,
}

/// The folder does not hold what the protocol needs.
#[derive(Debug, thiserror::Error)]
pub enum SetError {
    /// A sequence cannot be used.
    #[error(transparent)]
    Sequence(#[from] SequenceError),
    /// The protocol names an axis or level that no sequence has.
    #[error("protocol {protocol}: stimuli.{axis}: {value}: {allowed}")]
    Unknown {
        /// Name of the protocol.
        protocol: String,
        /// The axis.
        axis: String,
        /// What no sequence has.
        value: String,
        /// What there is.
        allowed: String,
    },
    /// Sequences that the protocol needs are not there.
    #[error("{}: {} of the stimuli of protocol {protocol} are missing: {}; render them, or leave their levels out of the protocol", folder.display(), missing.len(), missing.join(", "))]
    Missing {
        /// The folder of sequences.
        folder: PathBuf,
        /// Name of the protocol.
        protocol: String,
        /// The missing stimuli.
        missing: Vec<String>,
    },
    /// The protocol shows a frame that the sequences do not have.
    #[error("protocol {protocol}: timeline.still.frame: {frame}: the sequences have 0 to {last}")]
    NoFrame {
        /// Name of the protocol.
        protocol: String,
        /// The frame.
        frame: u32,
        /// The last there is.
        last: u32,
    },
    /// A sequence lacks frames.
    #[error("{}: holds {there} of {needed} frames: render it to its end first", folder.display())]
    Incomplete {
        /// The sequence folder.
        folder: PathBuf,
        /// Frames that are there.
        there: usize,
        /// Frames of the stimulus.
        needed: u32,
    },
    /// One stimulus lies in two folders, or the protocol names one of its levels twice.
    #[error("{}: {id} is also in {}: each stimulus may be compared once", second.display(), first.display())]
    Twice {
        /// The stimulus.
        id: String,
        /// One folder.
        first: PathBuf,
        /// The other.
        second: PathBuf,
    },
    /// Two sequences cannot be compared.
    #[error("{first} and {second}: {field} differs: {values}; compared stimuli must agree in it")]
    Differ {
        /// Id of one.
        first: String,
        /// Id of the other.
        second: String,
        /// What differs.
        field: &'static str,
        /// Both values.
        values: String,
    },
    /// Fewer than two stimuli.
    #[error("protocol {protocol}: stimuli: {found} found in {}: at least two are needed", folder.display())]
    TooFew {
        /// Name of the protocol.
        protocol: String,
        /// How many were found.
        found: usize,
        /// The folder of sequences.
        folder: PathBuf,
    },
}

impl StimulusSet {
    /// Finds the stimuli of `protocol` among the finished sequences in `folder`.
    ///
    /// Frames are not read here: [`StimulusSet::verify`] holds each against its hash.
    ///
    /// # Errors
    /// See [`SetError`]; every message names what is missing or does not fit.
    pub fn open(protocol: &Protocol, folder: &Path) -> Result<Self, SetError> {
        let mut all = Sequence::open_all(folder)?;
        // Other exemplars are for tasks that must not show the same noise twice.
        all.retain(|sequence| sequence.manifest.stimulus.exemplar == 0);
        let axes = axes(protocol, &all)?;
        let mut sequences = Vec::new();
        let mut missing = Vec::new();
        for cell in cells(&axes) {
            let found: Vec<&Sequence> =
                all.iter().filter(|s| has_levels(&s.manifest.stimulus, &axes, &cell)).collect();
            if found.is_empty() {
                missing.push(cell.join("-"));
            }
            let is_new =
                |s: &&Sequence| sequences.iter().all(|known: &Sequence| known.folder != s.folder);
            let new: Vec<Sequence> = found.into_iter().filter(is_new).cloned().collect();
            sequences.extend(new);
        }
        let compared = sequences.len();
        let mut indices = |pairs: &[ObviousPair], what: &str| {
            let mut index = |id: &str| {
                let there = |s: &Sequence| s.manifest.stimulus.id == id;
                if let Some(index) = sequences.iter().position(there) {
                    return index;
                }
                let name = format!("{id} ({what})");
                match all.iter().find(|s| there(s)) {
                    Some(sequence) => sequences.push(sequence.clone()),
                    None if missing.contains(&name) => {}
                    None => missing.push(name),
                }
                sequences.len().saturating_sub(1)
            };
            pairs.iter().map(|pair| (index(&pair.better), index(&pair.worse))).collect::<Vec<_>>()
        };
        let practice = indices(&protocol.practice, "practice");
        let catch = indices(&protocol.catch, "catch");
        if !missing.is_empty() {
            let protocol = protocol.name.clone();
            return Err(SetError::Missing { folder: folder.into(), protocol, missing });
        }
        if compared < 2 {
            let protocol = protocol.name.clone();
            return Err(SetError::TooFew { protocol, found: compared, folder: folder.into() });
        }
        let set = Self { sequences, compared, practice, catch };
        set.check(protocol)?;
        Ok(set)
    }

    /// What a design is made of.
    pub fn pool(&self) -> Pool {
        let levels = |index| self.stimulus(index).levels.clone();
        Pool {
            levels: (0..self.compared).map(levels).collect(),
            practice: self.practice.clone(),
            catch: self.catch.clone(),
        }
    }

    /// Frames per second as `protocol` shows them: a still is a film of one frame.
    pub fn fps_shown(&self, protocol: &Protocol) -> f64 {
        protocol.timeline.still.map_or(self.stimulus(0).image.fps, |still| 1.0 / still.seconds)
    }

    /// How long a sequence lasts.
    pub fn sequence_s(&self) -> f64 {
        let image = &self.stimulus(0).image;
        f64::from(image.frames) / image.fps
    }

    /// The description of stimulus number `index`.
    pub fn stimulus(&self, index: usize) -> &Stimulus {
        &self.sequences[index].manifest.stimulus
    }

    /// All frames of stimulus number `index` and holds each against its hash.
    ///
    /// # Errors
    /// A frame is missing, damaged or another one; the file is named.
    #[cfg(test)]
    pub fn load(
        &self,
        index: usize,
    ) -> Result<Vec<shutterlab_stimuli::frames::EncodedImage>, SequenceError> {
        let sequence = &self.sequences[index];
        sequence.manifest.frames.iter().map(|frame| sequence.read_frame(frame)).collect()
    }

    /// Reads every frame once and holds it against its hash, so that nothing damaged comes to light
    /// in the middle of a session.
    ///
    /// # Errors
    /// The first frame that is missing, damaged or another one; the file is named.
    pub fn verify(&self) -> Result<(), SetError> {
        for sequence in &self.sequences {
            for frame in &sequence.manifest.frames {
                sequence.read_frame(frame)?;
            }
        }
        Ok(())
    }

    fn check(&self, protocol: &Protocol) -> Result<(), SetError> {
        let frames = self.stimulus(0).image.frames;
        if let Some(still) = protocol.timeline.still.filter(|still| still.frame >= frames) {
            let (protocol, frame) = (protocol.name.clone(), still.frame);
            return Err(SetError::NoFrame { protocol, frame, last: frames.saturating_sub(1) });
        }
        for sequence in &self.sequences {
            let needed = sequence.manifest.stimulus.image.frames;
            let frames = &sequence.manifest.frames;
            if !frames.iter().map(|frame| frame.index).eq(0..needed) {
                let (folder, there) = (sequence.folder.clone(), frames.len());
                return Err(SetError::Incomplete { folder, there, needed });
            }
        }
        for index in 1..self.sequences.len() {
            self.check_like_first(index)?;
            let same = |other: &Sequence| other.manifest.stimulus.id == self.stimulus(index).id;
            if let Some(twin) = self.sequences[..index].iter().find(|other| same(other)) {
                let (first, second) = (twin.folder.clone(), self.sequences[index].folder.clone());
                return Err(SetError::Twice { id: self.stimulus(index).id.clone(), first, second });
            }
        }
        Ok(())
    }

    /// Whatever is shown in a session, practice included, has one size, length, rate and transfer.
    fn check_like_first(&self, index: usize) -> Result<(), SetError> {
        let (one, other) = (self.stimulus(0), self.stimulus(index));
        let (a, b) = (&one.image, &other.image);
        let size = |s: &Stimulus| {
            let [width, height] = s.frame_size_px();
            format!("{width}×{height}")
        };
        let (field, values) = if one.frame_size_px() != other.frame_size_px() {
            ("size in pixels", format!("{}, {}", size(one), size(other)))
        } else if a.fps != b.fps {
            ("frames per second", format!("{}, {}", a.fps, b.fps))
        } else if a.frames != b.frames {
            ("number of frames", format!("{}, {}", a.frames, b.frames))
        } else if a.transfer != b.transfer {
            ("transfer", format!("{:?}, {:?}", a.transfer, b.transfer))
        } else if one.pixels_per_degree != other.pixels_per_degree {
            ("pixels per degree", format!("{}, {}", one.pixels_per_degree, other.pixels_per_degree))
        } else {
            return Ok(());
        };
        let (first, second) = (one.id.clone(), other.id.clone());
        Err(SetError::Differ { first, second, field, values })
    }
}

/// Axis by axis in the order of the grid, the levels to be compared: those that the protocol names,
/// in its order, or all there are.
fn axes(protocol: &Protocol, all: &[Sequence]) -> Result<Vec<(String, Vec<String>)>, SetError> {
    let levels_of = |axis: &str| -> BTreeSet<&str> {
        all.iter()
            .filter_map(|s| s.manifest.stimulus.levels.get(axis).map(String::as_str))
            .collect()
    };
    // The original of a model has an axis less.
    let fullest = all.iter().rev().max_by_key(|sequence| sequence.manifest.stimulus.levels.len());
    let names: Vec<&str> = match fullest {
        Some(sequence) => sequence.manifest.stimulus.levels.keys().map(String::as_str).collect(),
        // No sequence at all: let every combination that the protocol names be missing.
        None => {
            let free = |(axis, levels): (&String, &Vec<String>)| (axis.clone(), levels.clone());
            return Ok(protocol.stimuli.iter().map(free).collect());
        }
    };
    let unknown = |axis: &str, value: &str, what: &str, known: &[&str]| {
        let hint = nearest(value, known.iter().copied())
            .map_or(String::new(), |name| format!("; did you mean {name}?"));
        SetError::Unknown {
            protocol: protocol.name.clone(),
            axis: axis.into(),
            value: value.into(),
            allowed: format!("the sequences have the {what} {}{hint}", known.join(", ")),
        }
    };
    for (axis, levels) in &protocol.stimuli {
        if !names.contains(&axis.as_str()) {
            return Err(unknown(axis, axis, "axes", &names));
        }
        let known: Vec<&str> = levels_of(axis).into_iter().collect();
        if let Some(level) = levels.iter().find(|level| !known.contains(&level.as_str())) {
            return Err(unknown(axis, level, "levels", &known));
        }
    }
    let owned = |axis: &str| match protocol.stimuli.get(axis) {
        Some(levels) => levels.clone(),
        None => levels_of(axis).into_iter().map(String::from).collect(),
    };
    Ok(names.iter().map(|axis| (axis.to_string(), owned(axis))).collect())
}

/// Every combination of levels, the last axis fastest.
fn cells(axes: &[(String, Vec<String>)]) -> Vec<Vec<&str>> {
    axes.iter().fold(vec![vec![]], |cells, (_, levels)| {
        cells
            .iter()
            .flat_map(|cell: &Vec<&str>| {
                levels.iter().map(|level| [cell.as_slice(), &[level.as_str()]].concat())
            })
            .collect()
    })
}

/// Whether `stimulus` is of this cell; the original of a model is of the cells of all r.
fn has_levels(stimulus: &Stimulus, axes: &[(String, Vec<String>)], cell: &[&str]) -> bool {
    axes.iter().zip(cell).all(|((axis, _), level)| match stimulus.levels.get(axis) {
        Some(own) => own == level,
        None => axis == R,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_support::{protocol, rendered, rendered_with};

    fn ids(set: &StimulusSet) -> Vec<&str> {
        (0..set.sequences.len()).map(|i| set.stimulus(i).id.as_str()).collect()
    }

    #[test]
    fn the_stimuli_come_in_the_order_of_the_grid_and_practice_after_them() {
        let folder = rendered();
        let mut protocol = protocol();
        protocol.stimuli["samples"] = vec!["A3".into()];
        let set = StimulusSet::open(&protocol, folder.path()).unwrap();
        assert_eq!(ids(&set), ["M2-S2-T3-A3", "M2-S2-T4-A3", "M2-S2-T5-A3", "M2-S2-T3-A5"]);
        assert_eq!((set.compared, set.practice.as_slice()), (3, &[(3, 2)][..]));
        assert_eq!(set.load(0).unwrap().len(), 3);
    }

    #[test]
    fn unknown_levels_and_missing_combinations_are_named() {
        let folder = rendered();
        let mut wrong = protocol();
        wrong.stimuli["shutter"].push("T9".into());
        let error = StimulusSet::open(&wrong, folder.path()).unwrap_err().to_string();
        assert!(error.contains("stimuli.shutter: T9: the sequences have the levels T3"), "{error}");

        let mut wrong = protocol();
        wrong.stimuli.insert("shuter".into(), vec!["T3".into()]);
        let error = StimulusSet::open(&wrong, folder.path()).unwrap_err().to_string();
        assert!(error.ends_with("did you mean shutter?"), "{error}");

        std::fs::remove_dir_all(folder.path().join("M2-S2-T4-A5")).unwrap();
        let error = StimulusSet::open(&protocol(), folder.path()).unwrap_err().to_string();
        assert!(error.contains("1 of the stimuli"), "{error}");
        assert!(error.contains("are missing: M2-S2-T4-A5;"), "{error}");
    }

    #[test]
    fn an_empty_or_absent_folder_is_refused_by_name() {
        let folder = tempfile::tempdir().unwrap();
        let error = StimulusSet::open(&protocol(), folder.path()).unwrap_err().to_string();
        assert!(error.contains("T3-A3"), "{error}");
        let absent = folder.path().join("none");
        let error = StimulusSet::open(&protocol(), &absent).unwrap_err().to_string();
        assert!(error.contains("none"), "{error}");
    }

    #[test]
    fn half_rendered_sequences_and_damaged_frames_are_refused_by_name() {
        let folder = rendered_with(Some(0..2));
        let error = StimulusSet::open(&protocol(), folder.path()).unwrap_err().to_string();
        assert!(error.contains("M2-S2-T3-A3: holds 2 of 3 frames"), "{error}");

        let folder = rendered();
        let set = StimulusSet::open(&protocol(), folder.path()).unwrap();
        let other = folder.path().join("M2-S2-T5-A5/frame-0001.png");
        std::fs::copy(other, folder.path().join("M2-S2-T3-A3/frame-0001.png")).unwrap();
        let error = set.load(0).unwrap_err().to_string();
        assert!(error.contains("M2-S2-T3-A3/frame-0001.png: its pixels hash to"), "{error}");
    }
}
