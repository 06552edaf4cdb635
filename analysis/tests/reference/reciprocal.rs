//! The law ρ = 1/(σ₁v + σ₂) fitted to made-up points: R 4.2.2 `nls`, November 2026; its profile
//! intervals by `uniroot` on the sum of squares (MASS's `confint` interpolates them to four digits).

use crate::close;
use shutterlab_analysis::ratings::over_models::over_models;
use shutterlab_analysis::ratings::points::Point;
use shutterlab_analysis::ratings::reciprocal::fit;

struct Case {
    speeds: &'static [f64],
    frequencies: &'static [f64],
    sigma: [f64; 2],
    se: [f64; 2],
    /// Variance of σ₁, covariance, variance of σ₂.
    covariance: [f64; 3],
    /// Sum of squares, residual standard error, R², log-likelihood, AIC.
    fit: [f64; 5],
    wald: [[f64; 2]; 2],
    profile: [[f64; 2]; 2],
    /// Speed, frequency, standard error.
    predicted: [[f64; 3]; 3],
}

const CASES: [Case; 3] = [
    Case {
        speeds: &[1.0, 2.0, 4.0, 8.0, 16.0, 32.0],
        frequencies: &[
            1.03339291062897,
            0.994149485542431,
            0.914266673415734,
            0.746188131512467,
            0.592150950643375,
            0.400602478892033,
        ],
        sigma: [0.0496721415959454, 0.911511090064433],
        se: [0.00165561098641355, 0.00886069852331374],
        covariance: [2.74104773833325e-06, -9.34229392127095e-06, 7.85119783210543e-05],
        fit: [
            0.000610794698837978,
            0.012357130520857,
            0.998019911617385,
            19.0638961995701,
            -32.1277923991401,
        ],
        wald: [[0.0450754285766059, 0.054268854615285], [0.886909847020746, 0.936112333108121]],
        profile: [[0.0452135884551199, 0.054420613933984], [0.887222905537263, 0.936461611085853]],
        predicted: [
            [1.0, 1.04038435863323, 0.00856180408494044],
            [6.0, 0.826757893803796, 0.00551426600483943],
            [32.0, 0.399836927127469, 0.00764610878868576],
        ],
    },
    Case {
        speeds: &[2.0, 4.0, 6.0, 8.0, 10.0],
        frequencies: &[0.71, 0.52, 0.43, 0.36, 0.3],
        sigma: [0.235132735788807, 0.94435501772094],
        se: [0.00682762146265313, 0.025284915534648],
        covariance: [4.66164148372817e-05, -0.000147684839128156, 0.000639326953594282],
        fit: [
            0.000198336008949343,
            0.00813092878969643,
            0.998065392031317,
            18.242771991754,
            -30.4855439835081,
        ],
        wald: [[0.213404197091111, 0.256861274486504], [0.863887131698289, 1.02482290374359]],
        profile: [[0.213798086031208, 0.257477315841166], [0.864581342808229, 1.02632184729197]],
        predicted: [
            [2.0, 0.706903376251714, 0.00766131374656636],
            [6.0, 0.42460114717894, 0.00420997971085785],
            [10.0, 0.303427298516657, 0.00446057635731928],
        ],
    },
    Case {
        speeds: &[5.0, 10.0, 20.0, 40.0, 80.0],
        frequencies: &[0.62, 0.45, 0.27, 0.16, 0.085],
        sigma: [0.133140903157422, 0.938826254959305],
        se: [0.00429831300166641, 0.0327169672093432],
        covariance: [1.84754946602945e-05, -0.000121180070359336, 0.00107039994337724],
        fit: [
            0.000161353413333715,
            0.00733378968277918,
            0.999151575279558,
            18.7586858271827,
            -31.5173716543654,
        ],
        wald: [[0.119461752826316, 0.146820053488528], [0.834706263543843, 1.04294624637477]],
        profile: [[0.120187605182736, 0.147371725378149], [0.834846374231551, 1.04170291253458]],
        predicted: [
            [5.0, 0.623235165215814, 0.00695358618541156],
            [20.0, 0.27765095930555, 0.00463400049544863],
            [80.0, 0.086280543633716, 0.00235321869877007],
        ],
    },
];

fn points(case: &Case) -> Vec<Point> {
    let rows = case.speeds.iter().zip(case.frequencies);
    rows.map(|(speed, frequency)| Point { model: None, speed: *speed, frequency: *frequency })
        .collect()
}

#[test]
fn fits_are_those_of_nls() {
    for case in &CASES {
        let fit = fit(&points(case)).unwrap();
        let [[a, b], [_, d]] = fit.covariance.unwrap();
        for (ours, theirs) in [a, b, d].into_iter().zip(case.covariance) {
            close(ours, theirs, 1e-5, "covariance");
        }
        let found = [
            fit.rss,
            fit.residual_se.unwrap(),
            fit.r_squared.unwrap(),
            fit.log_likelihood.unwrap(),
            fit.aic.unwrap(),
        ];
        for (ours, theirs) in found.into_iter().zip(case.fit) {
            close(ours, theirs, 1e-5, "fit");
        }
        for (i, parameter) in [&fit.sigma_1, &fit.sigma_2].into_iter().enumerate() {
            close(parameter.estimate, case.sigma[i], 1e-5, "estimate");
            close(parameter.se.unwrap(), case.se[i], 1e-5, "standard error");
            for bound in 0..2 {
                close(parameter.wald_95.unwrap()[bound], case.wald[i][bound], 1e-5, "Wald");
                let profile = parameter.profile_95.unwrap()[bound].unwrap();
                close(profile, case.profile[i][bound], 1e-5, "profile");
            }
        }
        for [speed, frequency, se] in case.predicted {
            let found = fit.predict(speed);
            close(found.frequency, frequency, 1e-5, "prediction");
            close(found.se.unwrap(), se, 1e-5, "standard error of a prediction");
        }
    }
}
/// Points of eight made-up models at the speeds 1, 2, 4, 8, 16 and 32.
const MODELS: [[f64; 6]; 8] = [
    [0.9038, 0.7646, 0.597, 0.3999, 0.2378, 0.1284],
    [0.5691, 0.4898, 0.4029, 0.2882, 0.1986, 0.1186],
    [0.7827, 0.6404, 0.4913, 0.3276, 0.1974, 0.112],
    [0.8984, 0.7737, 0.6032, 0.4074, 0.2424, 0.1477],
    [0.7871, 0.6466, 0.499, 0.3163, 0.1959, 0.089],
    [0.6589, 0.5752, 0.437, 0.2981, 0.1949, 0.1009],
    [0.6723, 0.5587, 0.4322, 0.302, 0.1802, 0.1176],
    [0.7072, 0.5702, 0.4308, 0.2875, 0.1683, 0.0945],
];

/// The second stage in R 4.2.2, metafor 3.8-1: `rma.mv(method = "REML", random = ~ par | model,
/// struct = "UN")` on the models' own laws by `nls`. And the model as
/// a whole by nlme 3.1-162, `nlme(rho ~ 1/(s1*v + s2), random = s1 + s2 ~ 1 | model, method = "REML")`,
/// which linearises about the shrunken laws where the two stages linearise about each model's own, and
/// whose standard errors of eight models are a little smaller.
#[test]
fn the_mean_over_models_is_that_of_metafor_and_near_that_of_nlme() {
    let points: Vec<Point> = MODELS
        .iter()
        .enumerate()
        .flat_map(|(model, frequencies)| {
            let speeds = [1.0, 2.0, 4.0, 8.0, 16.0, 32.0];
            speeds.into_iter().zip(frequencies).map(move |(speed, frequency)| Point {
                model: Some(model.to_string()),
                speed,
                frequency: *frequency,
            })
        })
        .collect();
    let found = over_models(&points).unwrap();
    for (ours, metafor, nlme) in [
        (
            &found.sigma_1,
            [0.2443448366, 0.01278977791, 0.03544968801],
            [0.2443440424, 0.01221823506, 0.03376411786],
        ),
        (
            &found.sigma_2,
            [1.1281449630, 0.07550517065, 0.21280667821],
            [1.1280657865, 0.07201365320, 0.20285896258],
        ),
    ] {
        let ours = [ours.estimate, ours.se, ours.sd_between];
        for (ours, metafor) in ours.into_iter().zip(metafor) {
            close(ours, metafor, 1e-7, "metafor");
        }
        for (ours, nlme) in ours.into_iter().zip(nlme) {
            close(ours, nlme, 0.06, "nlme");
        }
    }
    close(found.correlation.unwrap(), 0.3230806045, 1e-6, "correlation");
    close(found.residual_sd, 0.007995088083, 1e-6, "residual");
}
