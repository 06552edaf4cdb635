//! Friedman's χ² and Kendall's W: simulated scores (R 4.2.2, `friedman.test`, November 2026).

use crate::close;
use shutterlab_analysis::paired::friedman::friedman;

/// (each judge's scores, χ², p, W = χ²/(m(t − 1)))
type Case = (&'static [&'static [u64]], f64, f64, f64);

const CASES: &[Case] = &[
    (
        &[&[2, 3, 0, 1], &[2, 2, 2, 0], &[2, 3, 1, 0], &[2, 2, 0, 2], &[2, 2, 1, 1]],
        9.9,
        0.0194355807283203,
        0.66,
    ),
    (
        &[
            &[4, 2, 3, 1, 3, 2],
            &[2, 2, 2, 5, 3, 1],
            &[4, 3, 4, 2, 2, 0],
            &[4, 2, 4, 2, 2, 1],
            &[4, 3, 3, 3, 0, 2],
            &[4, 3, 4, 2, 1, 1],
            &[5, 3, 1, 2, 2, 2],
            &[2, 4, 4, 2, 2, 1],
        ],
        18.2142857142857,
        0.00268949424110985,
        0.455357142857143,
    ),
    (
        &[
            &[5, 2, 7, 3, 4, 4, 3, 3, 5],
            &[3, 6, 3, 6, 3, 4, 4, 4, 3],
            &[3, 4, 6, 4, 4, 4, 4, 2, 5],
            &[5, 4, 3, 4, 4, 5, 5, 4, 2],
            &[5, 6, 4, 4, 3, 4, 1, 4, 5],
            &[4, 5, 5, 4, 4, 3, 3, 4, 4],
            &[6, 6, 4, 5, 5, 3, 2, 2, 3],
            &[4, 5, 4, 3, 4, 6, 5, 4, 1],
            &[7, 4, 7, 3, 5, 2, 5, 2, 1],
            &[8, 4, 5, 5, 5, 2, 3, 4, 0],
            &[5, 3, 3, 4, 3, 4, 6, 2, 6],
            &[5, 3, 5, 2, 4, 6, 3, 4, 4],
            &[6, 7, 4, 4, 5, 1, 6, 3, 0],
            &[3, 6, 4, 4, 5, 5, 3, 3, 3],
            &[5, 4, 4, 2, 5, 4, 2, 6, 4],
            &[5, 6, 6, 5, 4, 1, 5, 3, 1],
            &[4, 5, 4, 5, 2, 3, 5, 4, 4],
            &[4, 3, 7, 6, 1, 5, 4, 3, 3],
            &[5, 3, 5, 5, 4, 5, 5, 0, 4],
            &[7, 5, 3, 2, 4, 3, 5, 4, 3],
            &[4, 4, 3, 7, 4, 2, 3, 4, 5],
        ],
        17.8994800693241,
        0.0219928544903796,
        0.106544524222167,
    ),
];

#[test]
fn chi_square_and_concordance_are_those_of_r() {
    for (scores, chi2, p, w) in CASES {
        let scores: Vec<Vec<u64>> = scores.iter().map(|judge| judge.to_vec()).collect();
        let found = friedman(&scores).unwrap();
        close(found.chi2, *chi2, 1e-9, "χ²");
        close(found.p.value(), *p, 1e-9, "p");
        close(found.w, *w, 1e-9, "W");
    }
}

#[test]
fn neither_the_order_of_the_judges_nor_that_of_the_stimuli_matters() {
    let (scores, ..) = CASES[2];
    let straight: Vec<Vec<u64>> = scores.iter().map(|judge| judge.to_vec()).collect();
    let turned: Vec<Vec<u64>> =
        scores.iter().rev().map(|judge| judge.iter().rev().copied().collect()).collect();
    let [straight, turned] = [straight, turned].map(|scores| friedman(&scores).unwrap());
    close(turned.chi2, straight.chi2, 1e-12, "χ²");
}
