//! Preferences: percentages, χ² plain and with Yates's correction, exact binomial tests and intervals
//! (R 4.2.2, November 2026: `chisq.test`, `binom.test`, `prop.test`).

use crate::close;
use shutterlab_analysis::maths::binomial::{lower_tail, two_sided, upper_tail};
use shutterlab_analysis::maths::goodness_of_fit::equal_chances;
use shutterlab_analysis::maths::proportion::Proportion;

/// `chosen` of `trials` and what R says of it.
struct Case {
    chosen: u64,
    trials: u64,
    percent: f64,
    /// χ² and p, without and with Yates's correction.
    chi2: [(f64, f64); 2],
    /// Exact tests against ½: two-sided, greater.
    half: [f64; 2],
    clopper_pearson: [f64; 2],
    wilson: [f64; 2],
    /// Exact tests against 0.8: greater, less.
    four_fifths: [f64; 2],
}

const CASES: &[Case] = &[
    Case {
        chosen: 14,
        trials: 20,
        percent: 70.0,
        chi2: [(3.2, 0.0736382701203028), (2.45, 0.117524868096639)],
        half: [0.115318298339844, 0.0576591491699219],
        clopper_pearson: [0.457210817723711, 0.881068409594272],
        wilson: [0.481027181646477, 0.854522755132396],
        four_fifths: [0.9133074864326, 0.195792214540451],
    },
    Case {
        chosen: 20,
        trials: 20,
        percent: 100.0,
        chi2: [(20.0, 7.74421643104409e-06), (18.05, 2.15178643781202e-05)],
        half: [1.9073486328125e-06, 9.53674316406249e-07],
        clopper_pearson: [0.831566529016915, 1.0],
        wilson: [0.838874841947181, 1.0],
        four_fifths: [0.0115292150460685, 1.0],
    },
    Case {
        chosen: 6,
        trials: 21,
        percent: 28.5714285714286,
        chi2: [(3.85714285714286, 0.0495346134356268), (3.04761904761905, 0.0808555983700521)],
        half: [0.0783538818359376, 0.986698150634766],
        clopper_pearson: [0.112809403921941, 0.521751118247114],
        wilson: [0.138138629521221, 0.499563807160856],
        four_fifths: [0.999999952901949, 5.13222262128639e-07],
    },
    Case {
        chosen: 13,
        trials: 18,
        percent: 72.2222222222222,
        chi2: [(3.55555555555556, 0.0593464387919201), (2.72222222222222, 0.0989601540194065)],
        half: [0.09625244140625, 0.048126220703125],
        clopper_pearson: [0.465198034416944, 0.903050787474441],
        wilson: [0.491273434397025, 0.87500246620446],
        four_fifths: [0.867083665757176, 0.283646184271381],
    },
    Case {
        chosen: 104,
        trials: 210,
        percent: 49.5238095238095,
        chi2: [(0.019047619047619, 0.890230054943497), (0.00476190476190476, 0.944984401060666)],
        half: [0.945006241922765, 0.581971828077388],
        clopper_pearson: [0.425724039891736, 0.564888467599968],
        wilson: [0.428311604646329, 0.562335672027569],
        four_fifths: [1.0, 8.00037961408288e-23],
    },
    Case {
        chosen: 63,
        trials: 63,
        percent: 100.0,
        chi2: [(63.0, 2.06706581807826e-15), (61.015873015873, 5.66164849051096e-15)],
        half: [2.16840434497101e-19, 1.08420217248551e-19],
        clopper_pearson: [0.943127647667984, 1.0],
        wilson: [0.942528800411148, 1.0],
        four_fifths: [7.84637716923339e-07, 1.0],
    },
];

#[test]
fn shares_are_those_of_r() {
    for case in CASES {
        let (k, n) = (case.chosen, case.trials);
        let what = format!("{k} of {n}");
        let meets = |ours: f64, theirs: f64| close(ours, theirs, 1e-10, &what);
        let share = Proportion::new(k, n);
        meets(share.percent, case.percent);
        meets(share.chi2, case.chi2[0].0);
        meets(share.p_chi2.value(), case.chi2[0].1);
        meets(share.chi2_corrected, case.chi2[1].0);
        meets(share.p_chi2_corrected.value(), case.chi2[1].1);
        meets(share.p_binomial.value(), case.half[0]);
        meets(two_sided(k, n, 0.5), case.half[0]);
        meets(upper_tail(k, n, 0.5), case.half[1]);
        meets(upper_tail(k, n, 0.8), case.four_fifths[0]);
        meets(lower_tail(k, n, 0.8), case.four_fifths[1]);
        for side in [0, 1] {
            meets(share.clopper_pearson_95[side], case.clopper_pearson[side]);
            meets(share.wilson_95[side], case.wilson[side]);
        }
    }
}

#[test]
fn equal_chances_of_several_alternatives_are_those_of_r() {
    let cases: &[(&[u64], f64, u64, f64)] = &[
        (&[30, 45, 25, 20, 60], 29.7222222222222, 4, 5.57487401036451e-06),
        (&[12, 18, 20, 30], 8.4, 3, 0.0384293188578885),
        (&[5, 5, 5, 5], 0.0, 3, 1.0),
    ];
    for (counts, chi2, df, p) in cases {
        let (found, found_df, found_p) = equal_chances(counts);
        close(found, *chi2, 1e-10, "χ²");
        close(found_p.value(), *p, 1e-10, "p");
        assert_eq!(found_df, *df);
    }
}
