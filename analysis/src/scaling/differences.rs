//! Differences between scale values, with tests of all pairs.

use super::fit::{Estimate, Scale};
use crate::maths::corrections::holm;
use crate::maths::distributions::normal_tail;
use crate::maths::p_value::PValue;
use serde::Serialize;

/// How far one item is above another.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Difference {
    /// The item with the larger value.
    pub item: String,
    /// The item that it is compared with.
    pub over: String,
    /// The places of both among the items.
    #[serde(skip)]
    pub places: [usize; 2],
    /// The difference of their scale values, in the unit of the model.
    #[serde(flatten)]
    pub estimate: Estimate,
    /// The difference over its standard error.
    pub z: f64,
    /// Wald's test that the difference is zero, two-sided, approximate.
    pub p: PValue,
    /// That p with Holm's correction for all pairs of items.
    pub p_holm: PValue,
}

/// The differences of all t(t − 1)/2 pairs of items, compared directly or not, from the best item down.
///
/// # Formula
/// ```text
/// z = (sᵢ − sⱼ)/√(vᵢᵢ + vⱼⱼ − 2vᵢⱼ) ~ N(0, 1)
/// ```
pub fn differences(scale: &Scale) -> Vec<Difference> {
    let order = scale.best_first();
    let pairs = order.iter().enumerate();
    let pairs = pairs.flat_map(|(rank, i)| order[rank + 1..].iter().map(move |j| [*i, *j]));
    let mut differences: Vec<Difference> = pairs
        .map(|places @ [i, j]| {
            let estimate = scale.difference(i, j);
            let z = estimate.value / estimate.se;
            let p = PValue::new(2.0 * normal_tail(z.abs()));
            let (item, over) = (scale.items[i].clone(), scale.items[j].clone());
            Difference { item, over, places, estimate, z, p, p_holm: p }
        })
        .collect();
    let p: Vec<f64> = differences.iter().map(|difference| difference.p.value()).collect();
    for (difference, corrected) in differences.iter_mut().zip(holm(&p)) {
        difference.p_holm = PValue::new(corrected);
    }
    differences
}
