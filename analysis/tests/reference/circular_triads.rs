//! Circular triads: synthetic tournaments (R 4.2.2, package eba 1.10-1, `circular`, November 2026, all
//! alternatives, continuity correction on and off) and the published counts of tournaments (Alway 1962).

use crate::close;
use shutterlab_analysis::paired::circular_triads::{
    Alternative, TriadsByChance, circular_triads, consistency, max_circular_triads,
};

/// p as `circular` gives it (exact up to t = 10); χ² and p with correction, χ² and p without.
type Test = (f64, Option<[f64; 4]>);

/// One judge's scores and the tests of the circular triads.
struct Case {
    scores: &'static [u64],
    d: u64,
    zeta: f64,
    df: Option<f64>,
    less: Test,
    greater: Test,
    two_sided: Test,
}

const CASES: &[Case] = &[
    Case {
        scores: &[1, 0, 2],
        d: 0,
        zeta: 1.0,
        df: None,
        less: (0.75, None),
        greater: (1.0, None),
        two_sided: (1.0, None),
    },
    Case {
        scores: &[1, 2, 2, 1],
        d: 2,
        zeta: 0.0,
        df: None,
        less: (1.0, None),
        greater: (0.375, None),
        two_sided: (0.75, None),
    },
    Case {
        scores: &[0, 1, 2, 3],
        d: 0,
        zeta: 1.0,
        df: None,
        less: (0.375, None),
        greater: (1.0, None),
        two_sided: (0.75, None),
    },
    Case {
        scores: &[1, 2, 2, 4, 1],
        d: 2,
        zeta: 0.6,
        df: Some(60.0),
        less: (0.46875, Some([60.0, 0.47571698610632, 64.0, 0.338005864719518])),
        greater: (0.765625, Some([68.0, 0.776495126964237, 64.0, 0.661994135280482])),
        two_sided: (0.765625, Some([60.0, 0.95143397221264, 64.0, 0.676011729439036])),
    },
    Case {
        scores: &[2, 1, 2, 4, 4, 2],
        d: 5,
        zeta: 0.375,
        df: Some(30.0),
        less: (0.50927734375, Some([28.0, 0.570436712827372, 30.0, 0.46565370894401])),
        greater: (0.60205078125, Some([32.0, 0.632472640234435, 30.0, 0.53434629105599])),
        two_sided: (1.0, Some([28.0, 0.859126574345256, 30.0, 0.931307417888019])),
    },
    Case {
        scores: &[0, 1, 2, 3, 4, 5],
        d: 0,
        zeta: 1.0,
        df: Some(30.0),
        less: (0.02197265625, Some([48.0, 0.0198253328234637, 50.0, 0.0124020607189006])),
        greater: (1.0, Some([52.0, 0.992383426821852, 50.0, 0.987597939281099])),
        two_sided: (0.02197265625, Some([48.0, 0.0396506656469273, 50.0, 0.0248041214378012])),
    },
    Case {
        scores: &[2, 4, 3, 2, 2, 4, 4],
        d: 11,
        zeta: 0.214285714285714,
        df: Some(23.3333333333333),
        less: (
            0.852943420410156,
            Some([16.0, 0.866913521858256, 17.3333333333333, 0.807128893365287]),
        ),
        greater: (
            0.263481140136719,
            Some([18.6666666666667, 0.262598174147396, 17.3333333333333, 0.192871106634713]),
        ),
        two_sided: (
            0.461189270019531,
            Some([18.6666666666667, 0.525196348294791, 17.3333333333333, 0.385742213269426]),
        ),
    },
    Case {
        scores: &[6, 4, 1, 2, 3, 4, 5, 3],
        d: 12,
        zeta: 0.4,
        df: Some(21.0),
        less: (0.298948764801025, Some([24.0, 0.293058531258575, 25.0, 0.24716407892266])),
        greater: (0.792274951934814, Some([26.0, 0.793550954467686, 25.0, 0.75283592107734])),
        two_sided: (0.531530857086182, Some([24.0, 0.58611706251715, 25.0, 0.49432815784532])),
    },
    Case {
        scores: &[0, 1, 3, 2, 4, 5, 6, 7],
        d: 0,
        zeta: 1.0,
        df: Some(21.0),
        less: (
            0.000150203704833984,
            Some([48.0, 0.000687648026634738, 49.0, 0.000501716594228326]),
        ),
        greater: (1.0, Some([50.0, 0.999635199702777, 49.0, 0.999498283405772])),
        two_sided: (
            0.000150203704833984,
            Some([48.0, 0.00137529605326948, 49.0, 0.00100343318845665]),
        ),
    },
    Case {
        scores: &[0, 1, 4, 3, 5, 5, 7, 5, 6],
        d: 9,
        zeta: 0.7,
        df: Some(20.16),
        less: (0.00695251487195492, Some([38.56, 0.00804813269506844, 39.36, 0.00641099950506459])),
        greater: (0.995824493467808, Some([40.16, 0.994908931558851, 39.36, 0.993589000494935])),
        two_sided: (
            0.00937285460531712,
            Some([38.56, 0.0160962653901369, 39.36, 0.0128219990101292]),
        ),
    },
    Case {
        scores: &[3, 6, 4, 6, 4, 4, 1, 5, 7, 5],
        d: 28,
        zeta: 0.3,
        df: Some(20.0),
        less: (
            0.343587666553503,
            Some([22.0, 0.340510642465661, 22.6666666666667, 0.305456729582113]),
        ),
        greater: (
            0.727370999338746,
            Some([23.3333333333333, 0.72727491876665, 22.6666666666667, 0.694543270417887]),
        ),
        two_sided: (
            0.674672205765091,
            Some([22.0, 0.681021284931322, 22.6666666666667, 0.610913459164227]),
        ),
    },
    Case {
        scores: &[1, 0, 2, 3, 5, 5, 6, 7, 8, 8],
        d: 4,
        zeta: 0.9,
        df: Some(20.0),
        less: (
            8.19745764601976e-06,
            Some([54.0, 5.78476581472498e-05, 54.6666666666667, 4.6044896509304e-05]),
        ),
        greater: (
            0.999996787482814,
            Some([55.3333333333333, 0.999963393479622, 54.6666666666667, 0.999953955103491]),
        ),
        two_sided: (
            8.19745764601976e-06,
            Some([54.0, 0.0001156953162945, 54.6666666666667, 9.2089793018608e-05]),
        ),
    },
    Case {
        scores: &[1, 4, 4, 1, 5, 6, 6, 7, 6, 7, 8],
        d: 28,
        zeta: 0.490909090909091,
        df: Some(20.2040816326531),
        less: (
            0.0228958307019896,
            Some([34.7755102040816, 0.0228958307019896, 35.3469387755102, 0.0197036671041439]),
        ),
        greater: (
            0.983075537218316,
            Some([35.9183673469388, 0.983075537218316, 35.3469387755102, 0.980296332895856]),
        ),
        two_sided: (
            0.0457916614039791,
            Some([34.7755102040816, 0.0457916614039791, 35.3469387755102, 0.0394073342082878]),
        ),
    },
    Case {
        scores: &[6, 8, 6, 3, 2, 7, 5, 6, 7, 6, 7, 3],
        d: 52,
        zeta: 0.257142857142857,
        df: Some(20.625),
        less: (0.316474958897176, Some([23.125, 0.316474958897176, 23.625, 0.291489913475805])),
        greater: (0.73220831998132, Some([24.125, 0.73220831998132, 23.625, 0.708510086524195])),
        two_sided: (
            0.632949917794352,
            Some([23.125, 0.632949917794352, 23.625, 0.582979826951609]),
        ),
    },
    Case {
        scores: &[0, 3, 2, 2, 3, 5, 7, 6, 8, 9, 10, 11],
        d: 2,
        zeta: 0.971428571428571,
        df: Some(20.625),
        less: (
            8.55109775606056e-08,
            Some([73.125, 8.55109775606056e-08, 73.625, 7.08086011413146e-08]),
        ),
        greater: (0.999999941389241, Some([74.125, 0.999999941389241, 73.625, 0.999999929191399])),
        two_sided: (
            1.71021955121211e-07,
            Some([73.125, 1.71021955121211e-07, 73.625, 1.41617202282629e-07]),
        ),
    },
    Case {
        scores: &[3, 1, 5, 5, 4, 5, 6, 7, 8, 8, 10, 10, 10, 12, 11],
        d: 68,
        zeta: 0.514285714285714,
        df: Some(22.5619834710744),
        less: (
            0.000135138400987051,
            Some([55.4710743801653, 0.000135138400987051, 55.8347107438017, 0.000120104173724984]),
        ),
        greater: (
            0.999893298754419,
            Some([56.198347107438, 0.999893298754419, 55.8347107438017, 0.999879895826275]),
        ),
        two_sided: (
            0.000270276801974102,
            Some([55.4710743801653, 0.000270276801974102, 55.8347107438017, 0.000240208347449968]),
        ),
    },
    Case {
        scores: &[11, 8, 10, 8, 8, 8, 10, 11, 10, 8, 10, 9, 8, 12, 8, 16, 10, 7, 10, 8],
        d: 293,
        zeta: 0.112121212121212,
        df: Some(26.71875),
        less: (0.699448873926888, Some([22.46875, 0.699448873926888, 22.71875, 0.686026799387309])),
        greater: (
            0.327543807609943,
            Some([22.96875, 0.327543807609943, 22.71875, 0.313973200612691]),
        ),
        two_sided: (
            0.655087615219885,
            Some([22.96875, 0.655087615219885, 22.71875, 0.627946401225382]),
        ),
    },
    Case {
        scores: &[1, 2, 1, 4, 5, 7, 5, 6, 7, 8, 12, 9, 13, 13, 12, 16, 17, 18, 16, 18],
        d: 22,
        zeta: 0.933333333333333,
        df: Some(26.71875),
        less: (
            1.39920092807841e-20,
            Some([157.96875, 1.39920092807841e-20, 158.21875, 1.25880450505849e-20]),
        ),
        greater: (1.0, Some([158.46875, 1.0, 158.21875, 1.0])),
        two_sided: (
            2.79840185615682e-20,
            Some([157.96875, 2.79840185615682e-20, 158.21875, 2.51760901011698e-20]),
        ),
    },
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
fn triads_zeta_and_tests_are_those_of_eba() {
    for case in CASES {
        let t = case.scores.len();
        let d = circular_triads(case.scores);
        assert_eq!(d, case.d, "{:?}", case.scores);
        close(consistency(d, 1, t), case.zeta, 1e-10, "ζ");
        for (alternative, (p, chi_square)) in [
            (Alternative::Less, case.less),
            (Alternative::Greater, case.greater),
            (Alternative::TwoSided, case.two_sided),
        ] {
            let what = format!("t = {t}, d = {d}, {alternative:?}");
            let test = TriadsByChance::new(t).test(&[d], alternative);
            let corrected = test.chi_square_corrected;
            let default = test.p_exact.or(corrected.map(|test| test.p)).unwrap();
            close(default.value(), p, 1e-10, &what);
            assert_eq!(test.p_exact.is_some(), t <= 10);
            assert_eq!(corrected.is_some(), case.df.is_some());
            let Some([chi2_corrected, p_corrected, chi2, p]) = chi_square else { continue };
            let (plain, corrected) = (test.chi_square.unwrap(), corrected.unwrap());
            close(corrected.df, case.df.unwrap(), 1e-10, &what);
            close(corrected.chi2, chi2_corrected, 1e-10, &what);
            close(corrected.p.value(), p_corrected, 1e-10, &what);
            close(plain.chi2, chi2, 1e-10, &what);
            close(plain.p.value(), p, 1e-10, &what);
        }
    }
}

#[test]
fn the_exact_distribution_is_the_published_one() {
    for (t, expected) in (3..).zip(TOURNAMENTS) {
        let chance = TriadsByChance::new(t);
        assert_eq!(chance.tournaments(), Some(expected), "t = {t}");
        assert_eq!(max_circular_triads(t) as usize + 1, expected.len(), "t = {t}");
    }
    assert_eq!(TriadsByChance::new(11).tournaments(), None);
}

#[test]
fn five_stimuli_cannot_show_one_consistent_observer_but_several() {
    let p = |triads: &[u64]| {
        let test = TriadsByChance::new(5).test(triads, Alternative::Less);
        test.p_exact.unwrap().value()
    };
    close(p(&[0]), 120.0 / 1024.0, 1e-15, "one observer");
    close(p(&[0, 0]), (120.0_f64 / 1024.0).powi(2), 1e-15, "two");
}

#[test]
fn the_pooled_chi_square_is_near_the_exact_distribution() {
    let chance = TriadsByChance::new(10);
    let judges = 12;
    // Chance makes 30 triads each.
    for each in 25..=30 {
        let test = chance.test(&vec![each; judges], Alternative::Less);
        let exact = test.p_exact.unwrap().value();
        let approximate = test.chi_square_corrected.unwrap().p.value();
        assert!(approximate / exact > 0.8 && approximate / exact < 1.25, "{exact} {approximate}");
    }
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
