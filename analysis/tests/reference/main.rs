//! The analysis against outside truth: numbers of other programs and of publications, and studies
//! made up here. One binary; each module says where its numbers come from.

#![allow(clippy::unwrap_used, reason = "helpers of tests are tests too")]

mod agreement;
mod categories;
mod category_studies;
mod circular_triads;
mod clustered;
mod export;
mod friedman;
mod made_up;
mod outside_export;
mod outside_paired;
mod outside_psychometric;
mod outside_scaling;
mod planning;
mod preference;
mod psychometric;
mod published;
mod ratings;
mod reciprocal;
mod replication;
mod report;
mod responses;
mod scaling;
mod score_differences;

/// Asserts that `ours` meets `theirs` within a relative difference.
fn close(ours: f64, theirs: f64, within: f64, what: &str) {
    let difference = (ours - theirs).abs() / theirs.abs().max(f64::MIN_POSITIVE);
    assert!(ours == theirs || difference <= within, "{what}: {ours} is not {theirs}");
}
