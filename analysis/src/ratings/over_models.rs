//! The law with σ₁ and σ₂ that vary between models: each model's own law, and the mean law of the models
//! they are a sample of (global two-stage estimation; Steimer et al. 1984, Davidian and Giltinan 1995,
//! §5.3).

use super::least_squares::{Solution, solve, speeds};
use super::points::Point;
use crate::maths::student::t_975;
use crate::outcome::Outcome;
use nalgebra::{Matrix2, Vector2};
use serde::Serialize;

/// The mean law of the models, and how they differ.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct OverModels {
    /// Mean σ₁ of the models.
    pub sigma_1: Mean,
    /// Mean σ₂ of the models.
    pub sigma_2: Mean,
    /// Covariance of the two means.
    pub covariance: [[f64; 2]; 2],
    /// Correlation of σ₁ and σ₂ between models; none where one of them does not vary.
    pub correlation: Option<f64>,
    /// Standard deviation of the frequencies about each model's own law.
    pub residual_sd: f64,
    /// Its degrees of freedom.
    pub residual_df: usize,
    /// Each model.
    pub models: Vec<ModelLaw>,
    /// Models that have no law of their own, with σ₁ and σ₂ above 0, and are left out.
    pub left_out: Vec<String>,
}

/// The mean of σ₁ or σ₂ over models.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Mean {
    /// Its estimate.
    pub estimate: f64,
    /// Standard error, of models drawn from all there might be.
    pub se: f64,
    /// 95 % interval by Student's t with one degree of freedom less than there are models.
    pub interval_95: [f64; 2],
    /// Standard deviation between models.
    pub sd_between: f64,
}

/// The law of one model.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ModelLaw {
    /// Its name.
    pub model: String,
    /// σ₁ and σ₂ by its own points.
    pub own: [f64; 2],
    /// σ₁ and σ₂ drawn towards the mean by how little the own points tell.
    pub shrunk: [f64; 2],
}

const MOST_STEPS: usize = 20_000;

const TOO_UNCERTAIN: &str = "the models' own laws are too uncertain to be averaged";

/// A model's own σ and how uncertain they are.
struct Own {
    model: String,
    sigma: Vector2<f64>,
    covariance: Matrix2<f64>,
}

/// Fits the law to each model and finds their mean by restricted maximum likelihood.
///
/// # Formula
/// ```text
/// own:  σᵢ by least squares, Cᵢ = s²·(JᵢᵀJᵢ)⁻¹,  s² = Σ rssᵢ/Σ(nᵢ − 2)
/// then: σᵢ ~ N(σ, D + Cᵢ),  Vᵢ = D + Cᵢ,  cov(σ) = (Σ Vᵢ⁻¹)⁻¹
/// EM:   D ← 1/m Σ {dᵢdᵢᵀ + D − D·[Vᵢ⁻¹ − Vᵢ⁻¹cov(σ)Vᵢ⁻¹]·D},  dᵢ = D·Vᵢ⁻¹(σᵢ − σ)
/// ```
///
/// # Errors
/// Says in words why there is no such mean: models not named, or too few with a law of their own; a search
/// without end.
pub fn over_models(points: &[Point]) -> Outcome<OverModels> {
    let mut names: Vec<&String> = points.iter().filter_map(|point| point.model.as_ref()).collect();
    names.sort();
    names.dedup();
    if names.is_empty() {
        return Err("the points do not say of which models they are".into());
    }
    let (mut own, mut left_out, mut rss, mut df) = (Vec::new(), Vec::new(), 0.0, 0);
    for name in names {
        let points: Vec<Point> =
            points.iter().filter(|point| point.model.as_ref() == Some(name)).cloned().collect();
        let solution = (speeds(&points).len() > 1).then(|| solve(&points)).flatten();
        let inverse = solution.and_then(|solution| solution.information.try_inverse());
        let lawful = solution.filter(|solution| solution.sigma.iter().all(|sigma| *sigma > 0.0));
        let (Some(Solution { sigma, rss: squares, .. }), Some(inverse)) = (lawful, inverse) else {
            left_out.push(name.clone());
            continue;
        };
        rss += squares;
        df += points.len() - 2;
        own.push(Own { model: name.clone(), sigma: sigma.into(), covariance: inverse });
    }
    let m = own.len();
    if m < 3 {
        return Err(format!(
            "{m} models have points at two speeds or more and a law of their own: how models differ \
             needs three at least"
        ));
    }
    if df == 0 {
        return Err(
            "no model has points at three speeds or more: what is noise and what is difference \
                    between models cannot be told apart"
                .into(),
        );
    }
    let variance = rss / df as f64;
    own.iter_mut().for_each(|own| own.covariance *= variance);
    let between = restricted(&own)?;
    let (mean, covariance) = weighted(&own, &between).ok_or(TOO_UNCERTAIN)?;
    let quantile = t_975((m - 1) as f64);
    let of = |i: usize| {
        let se = libm::sqrt(covariance[(i, i)]);
        let sd_between = libm::sqrt(between[(i, i)].max(0.0));
        Mean {
            estimate: mean[i],
            se,
            interval_95: [mean[i] - quantile * se, mean[i] + quantile * se],
            // What is smaller is rounding.
            sd_between: if sd_between < 1e-9 * mean[i].abs() { 0.0 } else { sd_between },
        }
    };
    let (sigma_1, sigma_2) = (of(0), of(1));
    let product = sigma_1.sd_between * sigma_2.sd_between;
    let negligible = product <= 1e-6 * (mean[0] * mean[1]).abs();
    let models = own.iter().map(|own| {
        let precision = (between + own.covariance).try_inverse().unwrap_or_default();
        let shrunk = mean + between * precision * (own.sigma - mean);
        ModelLaw { model: own.model.clone(), own: own.sigma.into(), shrunk: shrunk.into() }
    });
    Ok(OverModels {
        models: models.collect(),
        covariance: [
            [covariance[(0, 0)], covariance[(0, 1)]],
            [covariance[(1, 0)], covariance[(1, 1)]],
        ],
        correlation: (!negligible).then(|| (between[(0, 1)] / product).clamp(-1.0, 1.0)),
        residual_sd: libm::sqrt(variance),
        residual_df: df,
        left_out,
        sigma_1,
        sigma_2,
    })
}

/// The mean of the models' σ weighted by D + Cᵢ, and its covariance.
fn weighted(own: &[Own], between: &Matrix2<f64>) -> Option<(Vector2<f64>, Matrix2<f64>)> {
    let (mut precision, mut right) = (Matrix2::zeros(), Vector2::zeros());
    for own in own {
        let inverse = (between + own.covariance).try_inverse()?;
        precision += inverse;
        right += inverse * own.sigma;
    }
    let covariance = precision.try_inverse()?;
    Some((covariance * right, covariance))
}

/// The covariance between models by restricted maximum likelihood.
fn restricted(own: &[Own]) -> Outcome<Matrix2<f64>> {
    let m = own.len() as f64;
    let mean = own.iter().map(|own| own.sigma).sum::<Vector2<f64>>() / m;
    let scatter = own.iter().map(|own| (own.sigma - mean) * (own.sigma - mean).transpose());
    let mut between: Matrix2<f64> = scatter.sum::<Matrix2<f64>>() / (m - 1.0);
    for _ in 0..MOST_STEPS {
        let (mean, covariance) = weighted(own, &between).ok_or(TOO_UNCERTAIN)?;
        let mut next = Matrix2::zeros();
        for own in own {
            let inverse = (between + own.covariance).try_inverse().ok_or(TOO_UNCERTAIN)?;
            let shift = between * inverse * (own.sigma - mean);
            let lost = inverse - inverse * covariance * inverse;
            next += shift * shift.transpose() + between - between * lost * between;
        }
        next /= m;
        let change = (next - between).norm();
        between = next;
        if change <= 1e-12 * between.norm() {
            return Ok(between);
        }
    }
    Err(format!(
        "the search for how much models differ did not end in {MOST_STEPS} steps (not converged); they \
         may differ by no more than noise"
    ))
}

#[cfg(test)]
mod tests {
    use super::super::least_squares::law;
    use super::*;

    fn points(models: &[(&str, [f64; 2])]) -> Vec<Point> {
        let noise = [0.004, -0.007, 0.002, 0.006, -0.005];
        let of = |(i, (name, sigma)): (usize, &(&str, [f64; 2]))| {
            let name = (*name).to_string();
            let sigma = *sigma;
            (0..5).map(move |k| {
                let speed = [1.0, 2.0, 4.0, 8.0, 16.0][k];
                let frequency = law(sigma, speed) + noise[(k + i) % 5];
                Point { model: Some(name.clone()), speed, frequency }
            })
        };
        models.iter().enumerate().flat_map(of).collect()
    }

    const MODELS: [(&str, [f64; 2]); 4] =
        [("a", [0.30, 1.0]), ("b", [0.34, 1.3]), ("c", [0.21, 0.9]), ("d", [0.26, 1.1])];

    #[test]
    fn names_and_order_change_nothing_but_the_names() {
        let ours = over_models(&points(&MODELS)).unwrap();
        let mut others = points(&MODELS);
        others.reverse();
        for point in &mut others {
            point.model = point
                .model
                .take()
                .map(|name| format!("{}-renamed", 9 - (name.as_bytes()[0] - b'a')));
        }
        let theirs = over_models(&others).unwrap();
        assert!((ours.sigma_1.estimate / theirs.sigma_1.estimate - 1.0).abs() < 1e-9);
        assert!((ours.sigma_2.sd_between / theirs.sigma_2.sd_between - 1.0).abs() < 1e-6);
    }

    #[test]
    fn laws_lie_between_their_own_and_the_mean() {
        let found = over_models(&points(&MODELS)).unwrap();
        for model in &found.models {
            let mean = found.sigma_1.estimate;
            let [own, shrunk] = [model.own[0] - mean, model.shrunk[0] - mean];
            assert!(own.abs() < 0.02 || own * shrunk > 0.0, "{model:?}");
        }
        let outside = [0.05, 0.95];
        assert!(
            found.sigma_1.sd_between > outside[0] * 0.5 && found.sigma_1.sd_between < outside[1]
        );
    }

    #[test]
    fn models_without_a_law_are_left_out_by_name() {
        let mut models = points(&MODELS);
        let rising = points(&[("rising", [-0.02, 1.0])]);
        models.extend(rising);
        let found = over_models(&models).unwrap();
        assert_eq!((found.models.len(), found.left_out), (4, vec!["rising".to_string()]));
    }

    #[test]
    fn models_that_differ_by_noise_alone_have_no_made_up_deviation() {
        let alike = ["a", "b", "c", "d"].map(|name| (name, [0.3, 1.0]));
        let reason = over_models(&points(&alike)).unwrap_err();
        assert!(reason.contains("not converged"), "{reason}");
        // One law in the same points: nothing is between the models.
        let mut same = points(&alike[..1]);
        for name in ["b", "c", "d"] {
            let others: Vec<Point> =
                same[..5].iter().map(|p| Point { model: Some(name.into()), ..p.clone() }).collect();
            same.extend(others);
        }
        let found = over_models(&same).unwrap();
        assert_eq!((found.sigma_1.sd_between, found.sigma_2.sd_between), (0.0, 0.0));
    }

    #[test]
    fn too_few_models_are_said_in_words() {
        let mut few = points(&MODELS[..2]);
        let reason = over_models(&few).unwrap_err();
        assert!(reason.starts_with("2 models have points at two speeds or more"), "{reason}");
        few.iter_mut().for_each(|point| point.model = None);
        assert!(over_models(&few).unwrap_err().starts_with("the points do not say"));
        let two_speeds: Vec<Point> =
            points(&MODELS).into_iter().filter(|p| p.speed < 3.0).collect();
        assert!(over_models(&two_speeds).unwrap_err().starts_with("no model has points at three"));
    }
}
