//! The analysis against outside truth: numbers of other programs and of publications, and studies
//! made up here. One binary; each module says where its numbers come from.

#![allow(clippy::unwrap_used, reason = "helpers of tests are tests too")]

mod agreement;
mod circular_triads;
mod made_up;
mod preference;
mod published;
mod report;
mod responses;
mod score_differences;

/// Asserts that `ours` meets `theirs` within a relative difference.
fn close(ours: f64, theirs: f64, within: f64, what: &str) {
    let difference = (ours - theirs).abs() / theirs.abs().max(f64::MIN_POSITIVE);
    assert!(ours == theirs || difference <= within, "{what}: {ours} is not {theirs}");
}
