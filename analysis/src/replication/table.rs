//! What a published table of votes gives, line by line.

use super::implied::{circular_triads, least_sigma, least_u, least_zeta, sigmas};
use super::published::PublishedTable;
use super::{Line, Value};
use crate::error::InputError;
use crate::maths::distributions::normal_tail;
use crate::maths::p_value::PValue;
use crate::outcome::Outcome;
use crate::paired::agreement::exact_tail;
use crate::paired::circular_triads::{TriadsByChance, consistency, max_circular_triads};
use crate::paired::score_groups::{critical_difference, runs};
use crate::paired::{PairedComparison, analyze};
use crate::planning::critical::p_of_triads;

/// A published table, analysed.
pub struct VoteTable {
    pub published: &'static PublishedTable,
    pub analysis: PairedComparison,
    section: &'static str,
}

impl VoteTable {
    /// The table `name`, which `section` prints.
    pub fn new(name: &str, section: &'static str) -> Result<Self, InputError> {
        let published = super::published::find(name).ok_or_else(|| {
            InputError::value("replicate", "table", name, "a published table is needed")
        })?;
        let analysis = analyze(&published.preferences()?, published.alpha)?;
        Ok(Self { published, analysis, section })
    }

    /// The votes of `item`; 0 if there is no such item.
    pub fn votes(&self, item: &str) -> u64 {
        let place = self.analysis.items.iter().position(|other| other == item);
        place.map_or(0, |place| self.analysis.votes[place])
    }

    /// The groups, best first.
    pub fn groups(&self) -> &[Vec<String>] {
        self.analysis.grouping.as_ref().map_or(&[], |grouping| &grouping.groups)
    }

    pub fn r_c(&self) -> u64 {
        self.analysis.grouping.as_ref().map_or(0, |grouping| grouping.r_c)
    }

    /// The stimuli with their votes, best first.
    pub fn ranking(&self) -> String {
        let of = |(item, votes): (&String, &u64)| format!("{item} {votes}");
        let pairs = self.analysis.items.iter().zip(&self.analysis.votes);
        pairs.map(of).collect::<Vec<_>>().join(", ")
    }

    /// Number of judges and of stimuli.
    fn size(&self) -> (u64, usize) {
        (self.published.observers, self.analysis.items.len())
    }

    /// What every table gives: its sum, R_c and groups, and what its ζ and u imply.
    pub fn lines(&self) -> Vec<Line> {
        let (m, t) = self.size();
        let (section, table) = (self.section, self.published);
        let sum: u64 = self.analysis.votes.iter().sum();
        let w = self.analysis.grouping.as_ref().map_or(0.0, |grouping| grouping.w);
        let mut lines = vec![
            Line::compared(
                section,
                &format!("sum of the votes, n = {m}, t = {t}"),
                format!("{} = {sum}", self.plus()),
                format!("n·t(t−1)/2 = {}", m * (t * (t - 1) / 2) as u64),
                sum == m * (t * (t - 1) / 2) as u64,
            ),
            Line::number(section, &format!("W, α = {}", table.alpha), table.w, 9, w).noting(
                "Printed from Pearson and Hartley's table, between whose entries it was interpolated; \
                 R_c is the same with either.",
            ),
            Line::count(section, &format!("R_c, α = {}", table.alpha), table.r_c, self.r_c()),
            Line::count(
                section,
                "number of groups",
                table.group_count as u64,
                self.groups().len() as u64,
            ),
        ];
        lines.push(match table.groups {
            Some(printed) => {
                let printed: Vec<Vec<String>> = printed
                    .iter()
                    .map(|g| g.iter().map(|item| item.to_string()).collect())
                    .collect();
                let agrees = sorted(&printed) == sorted(self.groups());
                let ours = Value::Groups(self.groups().to_vec());
                Line::compared(section, "groups, best first", Value::Groups(printed), ours, agrees)
            }
            None => {
                Line::ours(section, "groups, best first", Value::Groups(self.groups().to_vec()))
                    .noting("They are drawn in a figure, and described in words: see below.")
            }
        });
        if let Ok(test) = &self.analysis.score_equality {
            let what = format!("equality of scores: D = {:.2}, df = {}", test.d, test.df);
            lines.push(
                Line::ours(section, &what, test.p).noting(format!(
                    "n = {m}, t = {t}; upper tail, χ² approximation, no correction."
                )),
            );
        }
        if table.pooling.is_some() {
            lines.push(self.groups_by_person());
        }
        lines.extend(self.zeta_lines());
        lines.extend(self.u_lines());
        lines
    }

    fn plus(&self) -> String {
        self.analysis.votes.iter().map(u64::to_string).collect::<Vec<_>>().join(" + ")
    }

    /// The groups if the two sets of each person count as one.
    fn groups_by_person(&self) -> Line {
        let (m, t) = self.size();
        // The same answer given twice doubles every difference, and so the critical one.
        let r_c = 2 * critical_difference(m / 2, t, self.published.alpha);
        let groups = runs(&self.analysis.votes, r_c);
        let groups = groups.into_iter().map(|run| self.analysis.items[run].to_vec()).collect();
        let what = format!("groups if a person's two answers to a pair are one, R_c = {r_c}");
        Line::ours(self.section, &what, Value::Groups(groups)).noting(format!(
            "Repetitions by one person are not independent: {} Were both answers always alike, n would \
             be {}; the truth lies between the two.",
            self.published.pooling.unwrap_or_default(),
            m / 2
        ))
    }

    fn zeta_lines(&self) -> Vec<Line> {
        let (m, t) = self.size();
        let section = self.section;
        let reason = self.analysis.consistency.as_ref().err().cloned().unwrap_or_default();
        let least = least_zeta(&self.analysis.votes, m);
        let bound = format!("The votes allow no ζ below {least:.4}.");
        let Some(printed) = self.published.zeta else {
            return vec![Line::unknown(section, "ζ", None, reason).noting(bound)];
        };
        let triads = circular_triads(printed, 4, m, t);
        let most = m * max_circular_triads(t);
        let known = Line::unknown(section, "ζ", Some(Value::Number(printed, 4)), reason);
        let mut lines = vec![
            known.noting(bound),
            whole(section, "ζ", "circular triads", (printed, 4), &triads, most, |d| {
                consistency(d, m, t)
            }),
        ];
        let chance = TriadsByChance::new(t);
        let tested = triads.last().and_then(|&d| Some((d, p_of_triads(&chance, d, m)?)));
        if let Some((d, p)) = tested {
            let by_chance = 0.25 * (m * (t * (t - 1) * (t - 2) / 6) as u64) as f64;
            lines.push(Line::ours(section, "test of so few circular triads", p).noting(format!(
                "{d} triads; {by_chance:.0} are expected by chance, ζ = {:.2}. n = {m}, t = {t}; \
                         lower tail of the number of triads, exact.",
                1.0 - by_chance / most as f64
            )));
        }
        lines
    }

    fn u_lines(&self) -> Vec<Line> {
        let (m, t) = self.size();
        let section = self.section;
        let reason = self.analysis.agreement.as_ref().err().cloned().unwrap_or_default();
        let least = least_u(&self.analysis.votes, m);
        let bound = format!("The votes allow no u below {least:.4}.");
        let Some(printed) = self.published.u else {
            return vec![Line::unknown(section, "u", None, reason).noting(bound)];
        };
        let decimals = decimals_of(printed);
        let sigmas = sigmas(printed, decimals, m, t);
        let allowed = match printed < least {
            true => format!("{bound} The printed value is."),
            false => bound,
        };
        let all = (m * (m - 1) / 2) * (t * (t - 1) / 2) as u64;
        let mut lines = vec![
            Line::unknown(section, "u", Some(Value::Number(printed, decimals)), reason)
                .noting(allowed),
            whole(section, "u", "agreeing pairs Σ", (printed, decimals), &sigmas, all, |sigma| {
                2.0 * sigma as f64 / all as f64 - 1.0
            }),
        ];
        if let Some(&sigma) = sigmas.first() {
            let ours: Outcome<Value> = p_of_sigma(sigma, m, t).map(Value::P);
            let what = "test of such agreement";
            let line = match ours {
                Ok(p) => Line::ours(section, what, p),
                Err(reason) => Line::unknown(section, what, None, reason),
            };
            lines.push(line.noting(format!("Σ = {sigma}; n = {m}, t = {t}; upper tail, exact.")));
        }
        lines
    }

    /// The least u as it was printed, and as it is.
    pub fn range_of_u(&self, printed: u64) -> Line {
        let (m, _) = self.size();
        let least = if m.is_multiple_of(2) { m - 1 } else { m };
        Line::compared(
            self.section,
            "range of u",
            format!("[−1/{printed}, 1]"),
            format!("[−1/{least}, 1]"),
            printed == least,
        )
    }

    /// Two stimuli that were said to be equivalent, or to differ.
    pub fn pair(
        &self,
        section: &'static str,
        [a, b]: [&str; 2],
        printed: &str,
        same: bool,
    ) -> Line {
        let (of_a, of_b) = (self.votes(a), self.votes(b));
        let (m, t) = self.size();
        let apart = of_a.abs_diff(of_b);
        let differ = apart >= self.r_c();
        let z = apart as f64 / libm::sqrt(0.5 * m as f64 * t as f64);
        let p = PValue::new(2.0 * normal_tail(z));
        let sign = if differ { "≥" } else { "<" };
        Line::compared(
            section,
            &format!("{a} and {b}"),
            printed,
            format!("{of_a} and {of_b} votes: {apart} {sign} R_c = {}", self.r_c()),
            differ != same,
        )
        .noting(format!(
            "R_c holds α for all pairs together; as the only pair, planned before: z = {z:.2}, {} (n = {m}, \
             t = {t}; two-sided, normal approximation).",
            p.equation()
        ))
    }

    /// The statement that the members of a group are equivalent, which the test cannot bear.
    pub fn equivalence(&self, printed: &str) -> Line {
        let (m, t) = self.size();
        let Some((best, worst)) =
            self.groups().first().and_then(|group| group.first().zip(group.last()))
        else {
            return Line::unknown(
                self.section,
                "members of one group",
                None,
                "there are no groups",
            );
        };
        let apart = self.votes(best).abs_diff(self.votes(worst));
        Line::unknown(
            self.section,
            "members of one group",
            Some(printed.into()),
            format!(
                "a difference below R_c is not shown; that is not equality. {best} and {worst}, of one \
                 group, are {apart} votes apart, and up to {} of {} are possible (difference + R_c)",
                apart + self.r_c(),
                m * (t as u64 - 1)
            ),
        )
    }
}

/// A printed ζ or u beside that of the nearest whole number of what it counts; if there is none, that is a
/// conflict.
fn whole(
    section: &'static str,
    what: &str,
    counted: &str,
    (printed, decimals): (f64, usize),
    found: &[u64],
    most: u64,
    value: impl Fn(u64) -> f64,
) -> Line {
    let numbers: Vec<String> = found.iter().map(u64::to_string).collect();
    let what = format!("{what} of {} of {most} {counted}", numbers.join(" or "));
    match found.get(found.len() / 2) {
        Some(middle) => Line::number(section, &what, printed, decimals, value(*middle)),
        None => {
            let printed = Value::Number(printed, decimals);
            Line::compared(section, counted, printed, "no whole number gives it", false)
        }
    }
}

/// P(Σ ≥ `sigma`) by chance.
fn p_of_sigma(sigma: u64, judges: u64, t: usize) -> Outcome<PValue> {
    let excess = sigma.saturating_sub(least_sigma(judges, t));
    exact_tail(&vec![judges; t * (t - 1) / 2], excess)
}

fn decimals_of(printed: f64) -> usize {
    printed.to_string().split('.').nth(1).map_or(0, str::len)
}

/// Groups with their members in one order: equal votes may stand in either.
fn sorted(groups: &[Vec<String>]) -> Vec<Vec<String>> {
    let mut groups = groups.to_vec();
    groups.iter_mut().for_each(|group| group.sort());
    groups
}
