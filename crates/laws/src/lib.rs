//! Statistical laws that samplers, proposal kernels and chains must obey, as functions for tests.
//!
//! Three layers. Tests of significance: [`chi_square`], [`kolmogorov_smirnov_uniform`], z and t limits, [`sidak`].
//! Densities against samplers: [`grid_chi_square`], [`sphere_chi_square`]. Kernels: the way back has support
//! ([`way_back`]), detailed balance ([`detailed_balance`]), the volume law ([`volume`]), one-step invariance
//! ([`Invariance`]) and symmetry of the flow ([`Flow`]).
//!
//! Every law here can fail: [`faults`] plants the mistakes that it is there to find, and each test of a correct kernel
//! should stand beside a test that a planted fault is caught.

pub mod faults;

mod chi_square;
mod flow;
mod grid;
mod invariance;
mod kolmogorov;
mod random;
mod reversibility;
mod significance;
mod sphere;
mod volume;

pub use ergodic_metropolis::diagnostics::Moments;

pub use chi_square::{ChiSquare, ChiSquareError, chi_square};
pub use flow::{Flow, FlowVerdict};
pub use grid::{Grid, GridChiSquare, grid_chi_square, integrate};
pub use invariance::{Invariance, InvarianceVerdict, one_step_invariance};
pub use kolmogorov::{KolmogorovSmirnov, kolmogorov_smirnov_uniform};
pub use random::generator;
pub use reversibility::{DetailedBalance, WayBack, detailed_balance, way_back};
pub use significance::{chi_square_tail, normal_limit, normal_two_sided, sidak, student_two_sided, z_score};
pub use sphere::{SphereGrid, sphere_chi_square};
pub use volume::{Volume, VolumeBin, volume};
