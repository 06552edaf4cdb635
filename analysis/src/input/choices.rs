//! From responses to choices: who preferred what to what in the task 2afc.
//!
//! A judge is one complete set of pairs: what one subject answered in one repetition of one session.
//! Where there are complete sets, votes, groups, consistency and agreement are of these alone, and the
//! sets that are not complete (a session still under way, an answer "not sure") are named. Scaling
//! takes every choice.

use super::data_quality::DataQuality;
use super::preferences::{
    Choice, Judge, Judgements, Observer, Preferences, WinMatrix, check_items,
};
use super::responses::{Responses, Row};
use crate::error::InputError;
use shutterlab_data_schema::protocol::Task;
use shutterlab_data_schema::response::Side;
use std::collections::{BTreeMap, BTreeSet, HashMap};

/// An answer to a pair, and which set of pairs of its observer it belongs to.
pub(super) struct Asked {
    pub session: u32,
    pub repetition: u32,
    pub choice: Choice,
}

impl Responses {
    /// The choices.
    ///
    /// # Errors
    /// Nothing counts; the task is another; there are too few or too many stimuli; a pair was answered
    /// twice in a repetition; several studies do not compare the same stimuli.
    pub fn preferences(&self) -> Result<Preferences, InputError> {
        self.check_not_empty()?;
        if let Some(row) = self.counted.iter().find(|row| row.response.task != Task::TwoAfc) {
            let task = format!("`{}`", row.response.task.name());
            return Err(row.refuse("task", task, "the task 2afc gives preferences".into()));
        }
        let items = self.items()?;
        // Every id of a counted row is among the sorted items.
        let place = |id: &String| items.partition_point(|item| item < id);
        let observers = self.observers();
        let mut answers = Vec::new();
        let mut seen: HashMap<_, &Row> = HashMap::new();
        for row in &self.counted {
            let response = &row.response;
            let who = (response.study.clone(), response.subject.to_string());
            let observer = observers.partition_point(|(other, _)| *other < who);
            let (a, b) = (place(&response.stimulus_a), place(&response.stimulus_b));
            let (session, repetition) = (response.session, response.repetition);
            let set_and_pair = (observer, session, repetition, a.min(b), a.max(b));
            if let Some(Row { file, line, .. }) = seen.insert(set_and_pair, row) {
                let value = format!("`{}` and `{}`", response.stimulus_a, response.stimulus_b);
                let allowed =
                    format!("once in a repetition, and answered before in {file}, line {line}");
                return Err(row.refuse("pair", value, allowed));
            }
            let selects_a = |selected: &String| *selected == response.stimulus_a;
            let chosen = response.selected.as_ref().map(selects_a);
            let chosen = chosen.map(|a| if a { Side::A } else { Side::B });
            let choice = Choice { observer, a, b, chosen, first: Some(response.first) };
            answers.push(Asked { session, repetition, choice });
        }
        let observers = observers.into_iter().map(|(_, observer)| observer).collect();
        let mut data_quality = DataQuality::of(self);
        let (mut preferences, left_out) = gather(items, observers, answers);
        preferences.notes.splice(0..0, self.notes.iter().cloned().chain(self.shared_codes()));
        data_quality.excluded.incomplete_sets = left_out;
        preferences.simulated = Some(data_quality.simulated);
        preferences.data_quality = Some(data_quality);
        Ok(preferences)
    }

    /// The stimuli of the answers that count, in alphabetical order.
    pub(crate) fn items(&self) -> Result<Vec<String>, InputError> {
        let mut by_study: BTreeMap<&str, BTreeSet<&String>> = BTreeMap::new();
        for row in self.counted() {
            let items = by_study.entry(&row.study).or_default();
            items.extend([&row.stimulus_a, &row.stimulus_b]);
        }
        let mut studies = by_study.into_iter();
        let Some((first, items)) = studies.next() else { return Ok(Vec::new()) };
        if let Some((other, others)) = studies.find(|(_, others)| *others != items) {
            let different = items.symmetric_difference(&others).next().map_or("", |id| id.as_str());
            return Err(InputError::value(
                &self.source,
                "stimuli",
                format!("`{different}` is in one of the studies `{first}` and `{other}` only"),
                "studies that are analysed together compare the same stimuli",
            ));
        }
        check_items(items.len(), &self.source)?;
        Ok(items.into_iter().cloned().collect())
    }

    /// What to know where several studies have participants of the same codes.
    fn shared_codes(&self) -> Option<String> {
        let mut studies: BTreeMap<String, BTreeSet<&str>> = BTreeMap::new();
        for row in self.counted() {
            studies.entry(row.subject.to_string()).or_default().insert(&row.study);
        }
        studies.retain(|_, studies| studies.len() > 1);
        let codes: Vec<String> = studies.into_keys().collect();
        (!codes.is_empty()).then(|| {
            format!(
                "The studies share the codes {}, which count as different people. If they are the same \
                 people, their answers are not independent: n is too large, and tests between the \
                 studies are not valid.",
                codes.join(", ")
            )
        })
    }

    /// Who answered, by (study, subject).
    pub(crate) fn observers(&self) -> Vec<((String, String), Observer)> {
        let studies: BTreeSet<&str> = self.counted().map(|row| row.study.as_str()).collect();
        let mut found: BTreeMap<(String, String), Observer> = BTreeMap::new();
        for row in self.counted() {
            let who = (row.study.clone(), row.subject.to_string());
            let mode = |observer: &mut Observer| {
                // Who saw both kinds belongs to neither group.
                if observer.traits.get("stereo_mode") != Some(&row.stereo_mode) {
                    observer.traits.remove("stereo_mode");
                }
            };
            found.entry(who).and_modify(mode).or_insert_with_key(|who| {
                let mut traits = self.traits.get(who).cloned().unwrap_or_default();
                traits.insert("stereo_mode".into(), row.stereo_mode.clone());
                traits.insert("study".into(), row.study.clone());
                // Equal codes of two studies are two people, as far as anybody can know.
                let code = match studies.len() {
                    1 => who.1.clone(),
                    _ => format!("{}:{}", who.0, who.1),
                };
                Observer { code, traits }
            });
        }
        // What everybody has in common parts nobody.
        for name in ["stereo_mode", "study"] {
            let values: BTreeSet<_> = found.values().map(|who| who.traits.get(name)).collect();
            if values.len() == 1 {
                found.values_mut().for_each(|who| _ = who.traits.remove(name));
            }
        }
        found.into_iter().collect()
    }
}

/// The choices of `answers`, in which no set has a pair twice, and how many of them are left out of what
/// needs complete sets.
pub(super) fn gather(
    items: Vec<String>,
    observers: Vec<Observer>,
    answers: Vec<Asked>,
) -> (Preferences, u64) {
    let mut pairs = BTreeSet::new();
    let mut sets: BTreeMap<(usize, u32, u32), Vec<Choice>> = BTreeMap::new();
    for Asked { session, repetition, choice } in &answers {
        pairs.insert((choice.a.min(choice.b), choice.a.max(choice.b)));
        sets.entry((choice.observer, *session, *repetition)).or_default().push(*choice);
    }
    let mut notes = Vec::new();
    let mut judges = Vec::new();
    let mut incomplete = Vec::new();
    let mut left_out = 0;
    for ((observer, session, repetition), set) in sets {
        let mut wins = WinMatrix::new(items.len());
        for choice in &set {
            match choice.chosen {
                Some(Side::A) => wins.add(choice.a, choice.b, 1),
                Some(Side::B) => wins.add(choice.b, choice.a, 1),
                None => (),
            }
        }
        let decided = set.iter().filter(|choice| choice.chosen.is_some()).count();
        let subject = observers[observer].code.clone();
        if decided == pairs.len() {
            judges.push(Judge { subject, session, repetition, wins });
        } else {
            left_out += set.len() as u64;
            incomplete.push(format!(
                "Left out of votes, groups, consistency and agreement: subject {subject}, session \
                 {session}, repetition {repetition}, who chose in {decided} of {} pairs.",
                pairs.len()
            ));
        }
    }
    let choices: Vec<Choice> = answers.into_iter().map(|answer| answer.choice).collect();
    let not_sure = choices.iter().filter(|choice| choice.chosen.is_none()).count();
    if not_sure > 0 {
        notes.push(format!(
            "{not_sure} of {} answers are \"not sure\": they select nothing, count ½ each in scaling, \
             and leave their set of pairs incomplete.",
            choices.len()
        ));
    }
    let all = items.len() * (items.len() - 1) / 2;
    if pairs.len() < all {
        let (compared, t) = (pairs.len(), items.len());
        notes.push(format!("{compared} of the {all} pairs of {t} stimuli were compared."));
    }
    if judges.is_empty() {
        left_out = 0;
        notes.push(format!(
            "No observer chose in all {} pairs, so votes and tests are of every choice together.",
            pairs.len()
        ));
    } else {
        notes.append(&mut incomplete);
    }
    let judgements = Judgements::Judges(judges);
    let (simulated, data_quality) = (None, None);
    (
        Preferences { items, judgements, choices, observers, simulated, data_quality, notes },
        left_out,
    )
}
