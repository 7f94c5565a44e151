//! What can be wrong with a finite chain.

use thiserror::Error;

/// What is wrong with a matrix, a distribution or the chain they describe. Rows and columns count from 0.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum FiniteError {
    /// There are no states.
    #[error("the matrix has no rows; give at least one state")]
    Empty,
    /// A row has not as many entries as there are rows.
    #[error("row {row} has {length} entries, but the matrix has {states} rows; give one entry for each state")]
    NotSquare {
        /// Which row.
        row: usize,
        /// Its entries.
        length: usize,
        /// The number of rows.
        states: usize,
    },
    /// An entry is no probability.
    #[error("row {row}, column {column} is {value}; a probability lies between 0 and 1")]
    Entry {
        /// Which row.
        row: usize,
        /// Which column.
        column: usize,
        /// The entry.
        value: f64,
    },
    /// A row does not sum to 1.
    #[error("row {row} sums to {sum}; divide its entries by that, or put what is missing on column {row} (to stay)")]
    RowSum {
        /// Which row.
        row: usize,
        /// Its sum.
        sum: f64,
    },
    /// A vector over the states has the wrong length.
    #[error("{length} values were given for {states} states; give one for each")]
    Length {
        /// Values given.
        length: usize,
        /// The number of states.
        states: usize,
    },
    /// A vector over the states holds what is no weight.
    #[error("the weight of state {state} is {value}; weights are finite and not negative")]
    Weight {
        /// Which state.
        state: usize,
        /// Its weight.
        value: f64,
    },
    /// All weights are 0.
    #[error("all weights are 0; give at least one state a positive weight")]
    NoWeight,
    /// Some state cannot be reached from some other, so that there is no unique stationary distribution.
    #[error("state {to} cannot be reached from state {from}; give a positive probability to some way there")]
    Reducible {
        /// The state one starts from.
        from: usize,
        /// The state one never reaches.
        to: usize,
    },
    /// Detailed balance does not hold, so that the matrix has no real spectrum to speak of.
    #[error(
        "not reversible: the flow between states {row} and {column} differs by {residual:e} one way and the other; \
         build the matrix by Metropolis-Hastings, or ask for nothing that needs detailed balance"
    )]
    NotReversible {
        /// One state.
        row: usize,
        /// The other.
        column: usize,
        /// |π_i P_ij - π_j P_ji|.
        residual: f64,
    },
    /// While a kernel was enumerated its target or density was not a number.
    #[error("the target or the density is not a number for the proposal from state {from} to state {to}")]
    Faulty {
        /// The state proposed from.
        from: usize,
        /// The state proposed.
        to: usize,
    },
}
