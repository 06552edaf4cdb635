//! Preferences: percentages, χ², exact binomial tests and intervals (R 4.2.2: `chisq.test`,
//! `binom.test`, `prop.test`).

use crate::close;
use shutterlab_analysis::preference::Proportion;

/// (chosen, trials, percent, χ², p of χ², p two-sided exact, Clopper–Pearson, Wilson)
type Case = (u64, u64, f64, f64, f64, f64, [f64; 2], [f64; 2]);

const CASES: [Case; 6] = [
    (
        14,
        20,
        70.0,
        3.2,
        0.0736382701203028,
        0.115318298339844,
        [0.457210817723711, 0.881068409594272],
        [0.481027181646477, 0.854522755132396],
    ),
    (
        20,
        20,
        100.0,
        20.0,
        7.74421643104409e-06,
        1.9073486328125e-06,
        [0.831566529016915, 1.0],
        [0.838874841947181, 1.0],
    ),
    (
        6,
        21,
        28.5714285714286,
        3.85714285714286,
        0.0495346134356268,
        0.0783538818359376,
        [0.112809403921941, 0.521751118247114],
        [0.138138629521221, 0.499563807160856],
    ),
    (
        13,
        18,
        72.2222222222222,
        3.55555555555556,
        0.0593464387919201,
        0.09625244140625,
        [0.465198034416944, 0.903050787474441],
        [0.491273434397025, 0.87500246620446],
    ),
    (
        104,
        210,
        49.5238095238095,
        0.019047619047619,
        0.890230054943497,
        0.945006241922765,
        [0.425724039891736, 0.564888467599968],
        [0.428311604646329, 0.562335672027569],
    ),
    (
        63,
        63,
        100.0,
        63.0,
        2.06706581807826e-15,
        2.16840434497101e-19,
        [0.943127647667984, 1.0],
        [0.942528800411148, 1.0],
    ),
];

#[test]
fn shares_are_those_of_r() {
    for (chosen, trials, percent, chi2, p_chi2, p_binomial, clopper_pearson, wilson) in CASES {
        let what = format!("{chosen} of {trials}");
        let share = Proportion::new(chosen, trials);
        close(share.percent, percent, 1e-10, &what);
        close(share.chi2, chi2, 1e-10, &what);
        close(share.p_chi2.value(), p_chi2, 1e-10, &what);
        close(share.p_binomial.value(), p_binomial, 1e-10, &what);
        for side in [0, 1] {
            close(share.clopper_pearson_95[side], clopper_pearson[side], 1e-10, &what);
            close(share.wilson_95[side], wilson[side], 1e-10, &what);
        }
    }
}
