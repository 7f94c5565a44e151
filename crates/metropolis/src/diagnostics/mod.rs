//! How far a chain's averages can be trusted: autocorrelation time, effective sample size, R-hat, runs of rejections.

mod autocorrelation;
mod batch_means;
mod moments;
mod r_hat;
mod runs;

pub use autocorrelation::{Autocorrelation, autocorrelation};
pub use batch_means::BatchMeans;
pub use moments::Moments;
pub use r_hat::{r_hat, split_r_hat, time_between_chains};
pub use runs::Runs;
