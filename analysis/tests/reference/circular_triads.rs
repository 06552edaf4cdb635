//! Circular triads: synthetic tournaments (R 4.2.2, package eba 1.10-1, `circular`, alternative
//! "less", continuity correction on) and the published counts of tournaments (Alway 1962).

use crate::close;
use shutterlab_analysis::circular_triads::{
    TriadsByChance, circular_triads, consistency, max_circular_triads,
};

/// (scores of one judge, circular triads, ζ, p, χ² and df where p is approximate)
type Case = (&'static [u64], u64, f64, f64, Option<(f64, f64)>);

const CASES: &[Case] = &[
    (&[1, 0, 2], 0, 1.0, 0.75, None),
    (&[1, 2, 2, 1], 2, 0.0, 1.0, None),
    (&[0, 1, 2, 3], 0, 1.0, 0.375, None),
    (&[1, 2, 2, 4, 1], 2, 0.6, 0.46875, None),
    (&[2, 1, 2, 4, 4, 2], 5, 0.375, 0.50927734375, None),
    (&[0, 1, 2, 3, 4, 5], 0, 1.0, 0.02197265625, None),
    (&[2, 4, 3, 2, 2, 4, 4], 11, 0.214285714285714, 0.852943420410156, None),
    (&[6, 4, 1, 2, 3, 4, 5, 3], 12, 0.4, 0.298948764801025, None),
    (&[0, 1, 3, 2, 4, 5, 6, 7], 0, 1.0, 0.000150203704833984, None),
    (&[0, 1, 4, 3, 5, 5, 7, 5, 6], 9, 0.7, 0.00695251487195492, None),
    (&[3, 6, 4, 6, 4, 4, 1, 5, 7, 5], 28, 0.3, 0.343587666553503, None),
    (&[1, 0, 2, 3, 5, 5, 6, 7, 8, 8], 4, 0.9, 8.19745764601976e-06, None),
    (
        &[1, 4, 4, 1, 5, 6, 6, 7, 6, 7, 8],
        28,
        0.490909090909091,
        0.0228958307019896,
        Some((34.7755102040816, 20.2040816326531)),
    ),
    (
        &[6, 8, 6, 3, 2, 7, 5, 6, 7, 6, 7, 3],
        52,
        0.257142857142857,
        0.316474958897176,
        Some((23.125, 20.625)),
    ),
    (
        &[0, 3, 2, 2, 3, 5, 7, 6, 8, 9, 10, 11],
        2,
        0.971428571428571,
        8.55109775606056e-08,
        Some((73.125, 20.625)),
    ),
    (
        &[3, 1, 5, 5, 4, 5, 6, 7, 8, 8, 10, 10, 10, 12, 11],
        68,
        0.514285714285714,
        0.000135138400987051,
        Some((55.4710743801653, 22.5619834710744)),
    ),
    (
        &[11, 8, 10, 8, 8, 8, 10, 11, 10, 8, 10, 9, 8, 12, 8, 16, 10, 7, 10, 8],
        293,
        0.112121212121212,
        0.699448873926888,
        Some((22.46875, 26.71875)),
    ),
    (
        &[1, 2, 1, 4, 5, 7, 5, 6, 7, 8, 12, 9, 13, 13, 12, 16, 17, 18, 16, 18],
        22,
        0.933333333333333,
        1.39920092807841e-20,
        Some((157.96875, 26.71875)),
    ),
];

/// Number of labelled tournaments with d = 0, 1, 2, … circular triads, for t = 3, 4, …, 10
/// (Alway 1962, as in R eba 1.10-1).
const TOURNAMENTS: [&[u64]; 8] = [
    &[6, 2],
    &[24, 16, 24],
    &[120, 120, 240, 240, 280, 24],
    &[720, 960, 2240, 2880, 6240, 3648, 8640, 4800, 2640],
    &[
        5040, 8400, 21840, 33600, 75600, 90384, 179760, 188160, 277200, 280560, 384048, 244160,
        233520, 72240, 2640,
    ],
    &[
        40320, 80640, 228480, 403200, 954240, 1304576, 3042816, 3870720, 6926080, 8332800,
        15821568, 14755328, 24487680, 24514560, 34762240, 29288448, 37188480, 24487680, 24312960,
        10402560, 3230080,
    ],
    &[
        362880, 846720, 2580480, 5093760, 12579840, 19958400, 44698752, 70785792, 130032000,
        190834560, 361525248, 443931264, 779950080, 1043763840, 1529101440, 1916619264, 2912257152,
        3078407808, 4506485760, 4946417280, 6068256768, 6160876416, 7730384256, 6292581120,
        6900969600, 5479802496, 4327787520, 2399241600, 1197020160, 163094400, 3230080,
    ],
    &[
        3628800,
        9676800,
        31449600,
        68275200,
        175392000,
        311592960,
        711728640,
        1193794560,
        2393475840,
        3784596480,
        7444104192,
        10526745600,
        19533696000,
        27610168320,
        47107169280,
        64016040960,
        107446832640,
        134470425600,
        218941470720,
        272302894080,
        417512148480,
        494080834560,
        743278970880,
        829743344640,
        1202317401600,
        1334577484800,
        1773862272000,
        1878824586240,
        2496636103680,
        2406981104640,
        3032021672960,
        2841072675840,
        3166378709760,
        2743311191040,
        2877794035200,
        2109852702720,
        1840136336640,
        1109253196800,
        689719564800,
        230683084800,
        48251508480,
    ],
];

#[test]
fn triads_zeta_and_p_are_those_of_eba() {
    for (scores, triads, zeta, p, chi_square) in CASES {
        let t = scores.len();
        let d = circular_triads(scores);
        assert_eq!(d, *triads, "{scores:?}");
        close(consistency(d, 1, t), *zeta, 1e-10, "ζ");
        let test = TriadsByChance::new(t).test(d);
        close(test.p.value(), *p, 1e-10, "p");
        assert_eq!(test.chi_square.is_some(), chi_square.is_some(), "t = {t}");
        if let (Some((chi2, df)), Some((expected, expected_df))) = (test.chi_square, chi_square) {
            close(chi2, *expected, 1e-10, "χ²");
            close(df, *expected_df, 1e-10, "df");
        }
    }
}

#[test]
fn the_exact_distribution_is_the_published_one() {
    for (t, expected) in (3..).zip(TOURNAMENTS) {
        let TriadsByChance::Exact { tournaments } = TriadsByChance::new(t) else {
            panic!("t = {t} is exact")
        };
        assert_eq!(tournaments, expected, "t = {t}");
        assert_eq!(max_circular_triads(t) as usize + 1, expected.len(), "t = {t}");
    }
}

#[test]
fn five_stimuli_cannot_show_one_consistent_observer_but_several() {
    let chance = TriadsByChance::new(5);
    close(chance.test(0).p.value(), 120.0 / 1024.0, 1e-15, "one observer");
    close(chance.test_pooled(&[0, 0]).p.value(), (120.0_f64 / 1024.0).powi(2), 1e-15, "two");
}

#[test]
fn the_pooled_chi_square_adds_the_observers() {
    // Twice the synthetic case with t = 11 above: χ² and df double.
    let pooled = TriadsByChance::new(11).test_pooled(&[28, 28]);
    let (chi2, df) = pooled.chi_square.expect("approximate above 10 stimuli");
    close(chi2, 2.0 * 34.7755102040816, 1e-10, "χ²");
    close(df, 2.0 * 20.2040816326531, 1e-10, "df");
}

#[test]
fn zeta_lies_between_zero_and_one_for_every_tournament_of_five() {
    let pairs: Vec<(usize, usize)> = (0..5).flat_map(|i| (i + 1..5).map(move |j| (i, j))).collect();
    for tournament in 0..1_u32 << pairs.len() {
        let mut scores = [0; 5];
        for (bit, (i, j)) in pairs.iter().enumerate() {
            scores[if tournament & (1 << bit) == 0 { *i } else { *j }] += 1;
        }
        let zeta = consistency(circular_triads(&scores), 1, 5);
        assert!((0.0..=1.0).contains(&zeta), "{scores:?}");
    }
}
