//! An analysis as a document: what the page, the terminal and the files show of it.

use super::section::Section;
use crate::input::data_quality::DataQuality;
use crate::outcome::Outcome;

/// What an analysis has to say, in the order in which a reader asks for it.
#[derive(Clone, Debug)]
pub struct Document {
    /// What was done, in one line.
    pub lead: String,
    /// Whether the observers were simulated: then every part says so.
    pub simulated: bool,
    /// The question as it was shown.
    pub questions: Outcome<Vec<String>>,
    /// The design: what, and how much or which.
    pub design: Vec<(String, String)>,
    /// The stimuli for a row of thumbnails: id and label.
    pub stimuli: Vec<(String, String)>,
    /// The results in short, for the terminal.
    pub summary: String,
    /// Data quality first, then the results.
    pub sections: Vec<Section>,
    /// What a reader of the results has to know.
    pub notes: Vec<String>,
}

impl Document {
    /// The `sections` of a fit to tables or answers, without what belongs to a study.
    pub fn of(lead: String, simulated: bool, sections: Vec<Section>) -> Self {
        Self {
            lead,
            simulated,
            questions: Err("it is with the study that the answers come from".into()),
            design: vec![],
            stimuli: vec![],
            summary: String::new(),
            sections,
            notes: vec![],
        }
    }

    /// Rows of the design that the answers tell, whatever the task.
    pub(crate) fn design_of(data: &DataQuality) -> Vec<(String, String)> {
        vec![
            ("Study".into(), data.studies.join(", ")),
            ("Subjects".into(), format!("{} ({})", data.subjects, data.observers.join(", "))),
            ("Display".into(), data.displays.join("; ")),
            ("Sessions run by".into(), format!("version {}", data.program_versions.join(", "))),
        ]
    }
}
