//! Power of the exact binomial test: R 4.2.2 (`pbinom`), November 2026, synthetic.

use super::close;
use shutterlab_analysis::planning::power::{Sides, critical_count, power};
use shutterlab_analysis::planning::{AskedPair, Assumptions, Design, plan};
use shutterlab_data_schema::protocol::Task;

type Row = (u64, f64, f64, u64, f64, f64, u64, f64);

/// n, true share, α, one-sided critical count, its power and size, two-sided critical count and its power.
const POWER: [Row; 72] = [
    (10, 0.6, 0.05, 9, 0.0463574016, 0.0107421875, 9, 0.0480351232),
    (18, 0.6, 0.05, 13, 0.208758371671867, 0.048126220703125, 14, 0.0954480335690137),
    (21, 0.6, 0.05, 15, 0.200245992251909, 0.0391769409179688, 16, 0.0965749934415729),
    (30, 0.6, 0.05, 20, 0.291471861223497, 0.0493685733526945, 21, 0.177142876699738),
    (40, 0.6, 0.05, 26, 0.317425160239035, 0.0403452338759964, 27, 0.211562588838417),
    (63, 0.6, 0.05, 39, 0.431949695488925, 0.0384629168048048, 40, 0.333850940885747),
    (10, 0.65, 0.05, 9, 0.0859544382772462, 0.0107421875, 9, 0.0864943254021485),
    (18, 0.65, 0.05, 13, 0.354996600664603, 0.048126220703125, 14, 0.188881663908453),
    (21, 0.65, 0.05, 15, 0.356695032644455, 0.0391769409179688, 16, 0.201017192966279),
    (30, 0.65, 0.05, 20, 0.507758214488354, 0.0493685733526945, 21, 0.357641046050456),
    (40, 0.65, 0.05, 26, 0.572082147835299, 0.0403452338759964, 27, 0.440794895573743),
    (63, 0.65, 0.05, 39, 0.743577550783342, 0.0384629168048048, 40, 0.653174786089502),
    (10, 0.7, 0.05, 9, 0.1493083459, 0.0107421875, 9, 0.1494520318),
    (18, 0.7, 0.05, 13, 0.534380097774601, 0.048126220703125, 14, 0.332694348998429),
    (21, 0.7, 0.05, 15, 0.550518117374891, 0.0391769409179688, 16, 0.362728681460258),
    (30, 0.7, 0.05, 20, 0.730370386302723, 0.0493685733526945, 21, 0.588815963076096),
    (40, 0.7, 0.05, 26, 0.807448245264824, 0.0403452338759964, 27, 0.703250169634514),
    (63, 0.7, 0.05, 39, 0.935637791987232, 0.0384629168048048, 40, 0.895395805714088),
    (10, 0.75, 0.05, 9, 0.244025230407715, 0.0107421875, 9, 0.244054794311524),
    (18, 0.75, 0.05, 13, 0.717450812982861, 0.048126220703125, 14, 0.518673278740607),
    (21, 0.75, 0.05, 15, 0.743629624297682, 0.0391769409179688, 16, 0.56659110957844),
    (30, 0.75, 0.05, 20, 0.89427187730734, 0.0493685733526945, 21, 0.803406918782049),
    (40, 0.75, 0.05, 26, 0.945562751981365, 0.0403452338759964, 27, 0.896768294650568),
    (63, 0.75, 0.05, 39, 0.992760480108315, 0.0384629168048048, 40, 0.985297785847916),
    (10, 0.8, 0.05, 9, 0.375809638400001, 0.0107421875, 9, 0.375813836800001),
    (18, 0.8, 0.05, 13, 0.867083665757176, 0.048126220703125, 14, 0.716354035432816),
    (21, 0.8, 0.05, 15, 0.89148754623799, 0.0391769409179688, 16, 0.769295928246225),
    (30, 0.8, 0.05, 20, 0.974383744664673, 0.0493685733526945, 21, 0.938912856188902),
    (40, 0.8, 0.05, 26, 0.992084146126481, 0.0403452338759964, 27, 0.980592631171619),
    (63, 0.8, 0.05, 39, 0.99973642973037, 0.0384629168048048, 40, 0.999299737399556),
    (10, 0.9, 0.05, 9, 0.7360989291, 0.0107421875, 9, 0.7360989382),
    (18, 0.9, 0.05, 13, 0.993584849903866, 0.048126220703125, 14, 0.971806143507427),
    (21, 0.9, 0.05, 15, 0.99672720611548, 0.0391769409179688, 16, 0.985554729724738),
    (30, 0.9, 0.05, 20, 0.999910922126177, 0.0493685733526945, 21, 0.9995456448851),
    (40, 0.9, 0.05, 26, 0.999996519449733, 0.0403452338759964, 27, 0.999981525262324),
    (63, 0.9, 0.05, 39, 0.999999999468787, 0.0384629168048048, 40, 0.999999996895999),
    (10, 0.6, 0.01, 10, 0.0060466176, 0.0009765625, 10, 0.0061514752),
    (18, 0.6, 0.01, 15, 0.0327812971246387, 0.0037689208984375, 15, 0.0329961313887847),
    (21, 0.6, 0.01, 17, 0.0369556370325032, 0.00359869003295899, 17, 0.0371108564633859),
    (30, 0.6, 0.01, 22, 0.0940112158300952, 0.008062400855124, 23, 0.0435734440221447),
    (40, 0.6, 0.01, 28, 0.128509678070684, 0.00829450168748737, 29, 0.0709811292278967),
    (63, 0.6, 0.01, 42, 0.170897042558922, 0.00557070370765255, 43, 0.112446715352649),
    (10, 0.65, 0.01, 10, 0.0134627433446289, 0.0009765625, 10, 0.0134903288181641),
    (18, 0.65, 0.01, 15, 0.0782674917441106, 0.0037689208984375, 15, 0.0783034512481682),
    (21, 0.65, 0.01, 17, 0.0923592248414178, 0.00359869003295899, 17, 0.0923806588756224),
    (30, 0.65, 0.01, 22, 0.22469565073146, 0.008062400855124, 23, 0.123771609574061),
    (40, 0.65, 0.01, 28, 0.314313740409172, 0.00829450168748737, 29, 0.205282282701748),
    (63, 0.65, 0.01, 42, 0.447481301537619, 0.00557070370765255, 43, 0.345386326489577),
    (10, 0.7, 0.01, 10, 0.0282475249, 0.0009765625, 10, 0.0282534298),
    (18, 0.7, 0.01, 15, 0.164550481934624, 0.0037689208984375, 15, 0.164554837401855),
    (21, 0.7, 0.01, 17, 0.19838148656544, 0.00359869003295899, 17, 0.198383531527687),
    (30, 0.7, 0.01, 22, 0.431517906282943, 0.008062400855124, 23, 0.281376887961805),
    (40, 0.7, 0.01, 28, 0.577180924503437, 0.00829450168748737, 29, 0.44060714097808),
    (63, 0.7, 0.01, 42, 0.765312593966731, 0.00557070370765255, 43, 0.675180632143979),
    (10, 0.75, 0.01, 10, 0.0563135147094727, 0.0009765625, 10, 0.0563144683837891),
    (18, 0.75, 0.01, 15, 0.305689170607366, 0.0037689208984375, 15, 0.305689512053505),
    (21, 0.75, 0.01, 17, 0.367420138813714, 0.00359869003295899, 17, 0.367420257650338),
    (30, 0.75, 0.01, 22, 0.673599150724041, 0.008062400855124, 23, 0.514289967352949),
    (40, 0.75, 0.01, 28, 0.820865757653958, 0.00829450168748737, 29, 0.715144393283176),
    (63, 0.75, 0.01, 42, 0.949258432334869, 0.00557070370765255, 43, 0.913733926855494),
    (10, 0.8, 0.01, 10, 0.1073741824, 0.0009765625, 10, 0.1073742848),
    (18, 0.8, 0.01, 15, 0.501025458544968, 0.0037689208984375, 15, 0.501025472896041),
    (21, 0.8, 0.01, 17, 0.586008383513448, 0.00359869003295899, 17, 0.586008386912355),
    (30, 0.8, 0.01, 22, 0.871349246085956, 0.008062400855124, 23, 0.760790618737547),
    (40, 0.8, 0.01, 28, 0.956758377623676, 0.00829450168748737, 29, 0.912494764079166),
    (63, 0.8, 0.01, 42, 0.995899927838065, 0.00557070370765255, 43, 0.990972455906582),
    (10, 0.9, 0.01, 10, 0.3486784401, 0.0009765625, 10, 0.3486784402),
    (18, 0.9, 0.01, 15, 0.901803158574563, 0.0037689208984375, 15, 0.90180315857517),
    (21, 0.9, 0.01, 17, 0.94784762190055, 0.00359869003295899, 17, 0.94784762190059),
    (30, 0.9, 0.01, 22, 0.997980170994742, 0.008062400855124, 23, 0.992216380762079),
    (40, 0.9, 0.01, 28, 0.999911552387747, 0.00829450168748737, 29, 0.999619165733264),
    (63, 0.9, 0.01, 42, 0.99999991285995, 0.00557070370765255, 43, 0.99999958218584),
];

/// Every row: critical counts exactly, size and power within 1e-12.
#[test]
fn critical_counts_sizes_and_powers_are_those_of_r() {
    for (n, share, alpha, one, power_one, size, two, power_two) in POWER {
        let what = format!("n = {n}, p = {share}, α = {alpha}");
        let [critical_one, critical_two] =
            [Sides::One, Sides::Two].map(|sides| critical_count(n, alpha, sides));
        assert_eq!((critical_one, critical_two), (Some(one), Some(two)), "{what}");
        let within =
            |ours: f64, theirs: f64| assert!((ours - theirs).abs() <= 1e-12, "{what}: {ours}");
        within(power(critical_one, n, share, Sides::One), power_one);
        within(power(critical_one, n, 0.5, Sides::One), size);
        within(power(critical_two, n, share, Sides::Two), power_two);
    }
}

/// A design of `t` stimuli on one axis with these pairs, each asked so often.
fn design(t: usize, pairs: &[(usize, usize)], times: u64) -> Design {
    Design {
        task: Task::TwoAfc,
        stimuli: (0..t).map(|place| vec![("axis".into(), format!("L{place}"))]).collect(),
        pairs: pairs.iter().map(|&(a, b)| AskedPair { a, b, times }).collect(),
        minutes: 5.0,
    }
}

fn all_pairs(t: usize) -> Vec<(usize, usize)> {
    (0..t).flat_map(|i| (i + 1..t).map(move |j| (i, j))).collect()
}

fn assumptions(observers: &[u64]) -> Assumptions {
    Assumptions { observers: observers.to_vec(), studies: 50, ..Assumptions::default() }
}

/// The information of all pairs of equal stimuli has the closed form var = 8/(n·t).
#[test]
fn the_scale_of_all_pairs_has_its_closed_form() {
    let plan = plan(&design(9, &all_pairs(9), 2), &assumptions(&[24])).unwrap();
    let scale = &plan.scale.unwrap()[0];
    for se in scale.se_equal {
        close(se, (8.0_f64 / (24.0 * 2.0 * 9.0)).sqrt(), 1e-12, "SE");
    }
    assert!(scale.se_assumed[1] > scale.se_equal[1]);
}

#[test]
fn turning_pairs_and_renaming_stimuli_changes_nothing() {
    let pairs = all_pairs(5);
    let turned: Vec<(usize, usize)> = pairs.iter().rev().map(|&(a, b)| (b, a)).collect();
    let [one, other] =
        [&pairs, &turned].map(|pairs| plan(&design(5, pairs, 1), &assumptions(&[10, 20])).unwrap());
    assert_eq!((&one.pair, &one.scores), (&other.pair, &other.scores));
    assert_eq!(one.simulated, other.simulated);
    assert_eq!(one.advice, other.advice);
}

#[test]
fn a_missing_pair_takes_scores_away_and_leaves_the_scale() {
    let mut pairs = all_pairs(4);
    pairs.pop();
    let plan = plan(&design(4, &pairs, 1), &assumptions(&[20])).unwrap();
    assert!(plan.scores.unwrap_err().contains("5 of 6 are asked"));
    assert!(plan.simulated.unwrap_err().contains("every pair"));
    assert!(plan.scale.is_ok() && plan.pair.is_ok());
    assert!(plan.levels.unwrap_err().contains("more than one pair"));
}

#[test]
fn unequal_repetitions_and_loose_ends_say_so() {
    let mut uneven = design(3, &all_pairs(3), 1);
    uneven.pairs[0].times = 2;
    let plan_of = |design: &Design| plan(design, &assumptions(&[20])).unwrap();
    let uneven = plan_of(&uneven);
    assert!(uneven.pair.unwrap_err().contains("more often than others"));
    assert!(uneven.scores.is_err() && uneven.scale.is_ok());
    let loose = plan_of(&design(4, &[(0, 1), (2, 3)], 1));
    assert!(loose.scale.unwrap_err().contains("do not connect"));
    assert!(loose.advice.contains("single pair"), "{}", loose.advice);
}

#[test]
fn one_observer_two_stimuli_and_no_stimuli_have_words() {
    let tiny = plan(&design(2, &[(0, 1)], 1), &assumptions(&[1])).unwrap();
    let pair = tiny.pair.unwrap();
    assert_eq!((pair.rows[0].critical, pair.rows[0].size), (None, 0.0));
    assert_eq!(tiny.scores.unwrap()[0].smallest_preference, None);
    assert!(tiny.advice.starts_with("1 observer (") && tiny.advice.contains("would with 0.8"));
    assert!(plan(&design(0, &[], 1), &assumptions(&[10])).is_err());
    assert!(plan(&design(2, &[(0, 5)], 1), &assumptions(&[10])).is_err());
    assert!(plan(&design(2, &[(0, 1)], 1), &assumptions(&[])).is_err());
    let nan = Assumptions { effect: f64::NAN, ..assumptions(&[10]) };
    assert!(plan(&design(2, &[(0, 1)], 1), &nan).is_err());
}

/// Answers are those of a factor: eight pairs for each of four axes with two levels.
#[test]
fn levels_are_compared_over_the_pairs_that_differ_in_nothing_else() {
    let levels = |place: usize| (0..4).map(|axis| (place >> axis) & 1).collect::<Vec<_>>();
    let stimuli: Vec<Vec<(String, String)>> = (0..16)
        .map(|place| {
            let named = levels(place).into_iter().enumerate();
            named.map(|(axis, level)| (format!("axis{axis}"), format!("L{level}"))).collect()
        })
        .collect();
    let pairs = all_pairs(16).into_iter().filter(|(a, b)| (a ^ b).is_power_of_two());
    let pairs: Vec<AskedPair> = pairs.map(|(a, b)| AskedPair { a, b, times: 1 }).collect();
    assert_eq!(pairs.len(), 32);
    let design = Design { task: Task::TwoAfc, stimuli, pairs, minutes: 7.0 };
    let plan = plan(&design, &assumptions(&[21])).unwrap();
    let levels = plan.levels.unwrap();
    assert_eq!(levels.len(), 1);
    assert_eq!((levels[0].0.len(), levels[0].1.answers_per_observer), (4, 8));
    assert_eq!(levels[0].1.rows[0].trials, 21 * 8);
    assert!(plan.scores.is_err() && plan.scale.is_ok());
}
