//! The vote tables of Navarro's thesis (2012), with what the thesis prints about them.
//!
//! The thesis draws its groups in figures; what is kept here is what its text says, and where its
//! text and its votes disagree. Its ζ and u cannot be computed from votes. Its printed ζ are those of
//! whole numbers of circular triads over all observers, which is how [`crate::analyze`] pools ζ.

use crate::error::InputError;
use crate::input::preferences::{Judgements, Preferences};
use shutterlab_data_schema::Votes;
use std::collections::BTreeMap;

/// A published table of votes and what was published about it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PublishedTable {
    /// Its name: that of its file without `.csv`.
    pub name: &'static str,
    /// What was compared.
    pub title: &'static str,
    /// Where it was published.
    pub citation: &'static str,
    /// The table, as CSV with comments.
    pub csv: &'static str,
    /// Number n of observers, as it was counted there.
    pub observers: u64,
    /// Level of significance.
    pub alpha: f64,
    /// The printed W_{t,α}.
    pub w: f64,
    /// The printed critical difference R_c.
    pub r_c: u64,
    /// The printed number of groups.
    pub group_count: usize,
    /// The printed groups, best first, where the text lists them.
    pub groups: Option<&'static [&'static [&'static str]]>,
    /// The printed coefficient of consistency ζ.
    pub zeta: Option<f64>,
    /// The printed coefficient of agreement u.
    pub u: Option<f64>,
    /// Where the published text disagrees with the votes or with the exact value.
    pub conflicts: &'static [&'static str],
    /// How the observers were counted, where they are not independent people.
    pub pooling: Option<&'static str>,
}

const W_5: &str = "prints W ≈ 4.604166667 from Pearson and Hartley's table; exactly W = 4.602821. R_c is the same";
const W_9: &str =
    "prints W ≈ 5.0769231 from Pearson and Hartley's table; exactly W = 5.077506. R_c is the same";
const STEREO_POOLING: &str =
    "Sixteen participants completed two full tests each; n = 32 counts both as independent.";

static TABLES: [PublishedTable; 5] = [
    PublishedTable {
        name: "mono-sampling",
        title: "Monoscopic sampling level",
        citation: "Navarro, PhD thesis, 2012, section 5.6.3",
        csv: include_str!("../../published/mono-sampling.csv"),
        observers: 20,
        alpha: 0.01,
        w: 4.604166667,
        r_c: 24,
        group_count: 3,
        groups: Some(&[&["A5", "A4", "A3"], &["A4", "A3", "A2"], &["A1"]]),
        zeta: None,
        u: None,
        conflicts: &[W_5],
        pooling: Some(
            "Ten participants judged every pair twice; n = 20 counts both as independent.",
        ),
    },
    PublishedTable {
        name: "mono-shutter-sampling",
        title: "Monoscopic shutter time × sampling level",
        citation: "Navarro, PhD thesis, 2012, section 5.7.2",
        csv: include_str!("../../published/mono-shutter-sampling.csv"),
        observers: 21,
        alpha: 0.01,
        w: 5.0769231,
        r_c: 36,
        group_count: 4,
        groups: None,
        zeta: Some(0.6492),
        u: Some(0.2794),
        conflicts: &[
            "says that group 1 holds all images with T3 and \"those computed using T4 and the lowest \
             sampling levels\"; the votes put A5T4 and A4T4, the highest, into group 1",
            W_9,
        ],
        pooling: None,
    },
    PublishedTable {
        name: "stereo-shutter",
        title: "Stereoscopic shutter time",
        citation: "Navarro, PhD thesis, 2012, section 6.5.2, Table 6.2",
        csv: include_str!("../../published/stereo-shutter.csv"),
        observers: 32,
        alpha: 0.01,
        w: 4.604166667,
        r_c: 30,
        group_count: 2,
        groups: Some(&[&["T4", "T3", "T2"], &["T2", "T5", "T1"]]),
        zeta: Some(0.7813),
        u: Some(0.144),
        conflicts: &[W_5],
        pooling: Some(STEREO_POOLING),
    },
    PublishedTable {
        name: "stereo-sampling",
        title: "Stereoscopic sampling level",
        citation: "Navarro, PhD thesis, 2012, section 6.5.2, Table 6.2",
        csv: include_str!("../../published/stereo-sampling.csv"),
        observers: 32,
        alpha: 0.01,
        w: 4.604166667,
        r_c: 30,
        group_count: 1,
        groups: Some(&[&["A3", "A4", "A5", "A2", "A1"]]),
        zeta: Some(0.5062),
        u: Some(0.0177),
        conflicts: &[W_5],
        pooling: Some(STEREO_POOLING),
    },
    PublishedTable {
        name: "stereo-shutter-sampling",
        title: "Stereoscopic shutter time × sampling level",
        citation: "Navarro, PhD thesis, 2012, section 6.6.2",
        csv: include_str!("../../published/stereo-shutter-sampling.csv"),
        observers: 18,
        alpha: 0.01,
        w: 5.0769231,
        r_c: 33,
        group_count: 3,
        groups: None,
        zeta: Some(0.6074),
        u: Some(0.1137),
        conflicts: &[
            "gives \"[−1/35, 1]\" as the range of u; with n = 18 the minimum is −1/17",
            "says that the two less voted groups correspond to the medium and longest shutter times; \
             the votes put A3T3, with the shortest, into group 2",
            W_9,
        ],
        pooling: None,
    },
];

/// All tables, in the order of the thesis.
pub fn tables() -> &'static [PublishedTable] {
    &TABLES
}

/// The table of that `name`.
pub fn find(name: &str) -> Option<&'static PublishedTable> {
    TABLES.iter().find(|table| table.name == name)
}

/// The published table that `preferences` repeats, in whatever order, if there is one.
pub fn repeated_by(preferences: &Preferences) -> Option<&'static PublishedTable> {
    let Judgements::Votes { votes, observers } = preferences.judgements() else { return None };
    let rows = |items: &[String], votes: &[u64]| -> BTreeMap<String, u64> {
        items.iter().cloned().zip(votes.iter().copied()).collect()
    };
    let here = rows(preferences.items(), votes);
    TABLES.iter().filter(|table| table.observers == *observers).find(|table| {
        Votes::parse(table.csv, table.name).is_ok_and(|votes| {
            here == votes.rows.into_iter().map(|row| (row.item, row.votes)).collect()
        })
    })
}

impl PublishedTable {
    /// What a reader should know of the table: where it is from, how its observers were counted, and
    /// where the published text disagrees with it.
    pub fn remarks(&self) -> Vec<String> {
        let origin = format!("These are published votes: {}; {}.", self.title, self.citation);
        let conflicts =
            self.conflicts.iter().map(|conflict| format!("The published text {conflict}."));
        let pooling = self.pooling.map(str::to_string);
        std::iter::once(origin).chain(pooling).chain(conflicts).collect()
    }

    /// The table as the input of an analysis.
    ///
    /// # Errors
    /// Never for the tables of this crate, whose files are tested.
    pub fn preferences(&self) -> Result<Preferences, InputError> {
        let file = format!("{}.csv", self.name);
        Preferences::from_votes(&Votes::parse(self.csv, &file)?, self.observers, &file)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::paired::circular_triads::consistency;

    #[test]
    fn the_printed_zeta_is_that_of_a_whole_number_of_triads() {
        // (name, stimuli, circular triads over all observers)
        for (name, t, triads) in [
            ("mono-shutter-sampling", 9, 221),
            ("stereo-shutter", 5, 35),
            ("stereo-sampling", 5, 79),
            ("stereo-shutter-sampling", 9, 212),
        ] {
            let table = find(name).unwrap();
            let zeta = consistency(triads, table.observers, t);
            assert!((zeta - table.zeta.unwrap()).abs() <= 0.50001e-4, "{name}: {zeta}");
        }
    }

    #[test]
    fn a_repeated_table_is_known_by_its_votes() {
        for table in tables() {
            assert_eq!(repeated_by(&table.preferences().unwrap()), Some(table));
        }
        let other = Votes::parse("item,votes\nA5,59\nA4,51\nA3,48\nA2,35\nA1,7\n", "v").unwrap();
        assert_eq!(repeated_by(&Preferences::from_votes(&other, 20, "v").unwrap()), None);
    }

    #[test]
    fn an_unknown_name_finds_nothing() {
        assert_eq!(find("mono-sampling").map(|table| table.r_c), Some(24));
        assert_eq!(find("mono"), None);
    }
}
