//! What every statistic rests on: distributions, intervals, p-values, linear algebra and chance.

pub mod binomial;
pub mod bootstrap;
pub mod corrections;
pub mod distributions;
pub mod f_ratio;
pub mod fisher_exact;
pub mod goodness_of_fit;
pub mod logistic;
pub mod normal_quantile;
pub mod p_value;
pub mod permutation;
pub mod proportion;
pub mod random;
pub mod resampling;
pub mod signed_rank;
pub mod student;
pub mod studentized_range;
