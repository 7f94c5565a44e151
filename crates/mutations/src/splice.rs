//! What every path mutation says of its proposals.

use std::convert::Infallible;

/// How many vertices survive at each end. Symmetric in the two paths: the same splice describes the way back.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Splice {
    /// Vertices kept at the light end.
    pub prefix: usize,
    /// Vertices kept at the eye end.
    pub suffix: usize,
}

/// Why a candidate could not be built.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rejection {
    /// A ray left the scene.
    Escaped,
    /// The image point left the film.
    OffFilm,
    /// A traced vertex lacks the component that the path has there.
    WrongComponent,
    /// The connecting edge is blocked.
    Occluded,
    /// The connection would end on a Dirac component.
    NotConnectable,
    /// The last traced vertex does not emit.
    NoEmitter,
    /// The surface scatters nothing in the direction drawn.
    Absorbed,
    /// The connecting edge would carry nothing: one of its ends faces away from the other, or scatters nothing towards it.
    Dark,
    /// No length that could be inserted is allowed.
    NoLength,
    /// The turn, measured between the vertices, lies just outside the range it was drawn from: rays leave surfaces a little
    /// way out, so that over a very short edge the direction to the next vertex is not quite the one drawn.
    OutOfRange,
}

/// Of a mutation that always makes a candidate.
impl From<Infallible> for Rejection {
    fn from(never: Infallible) -> Self {
        match never {}
    }
}

impl Rejection {
    /// All reasons, in the order in which tables show them.
    pub const ALL: [Self; 10] = [
        Self::Escaped,
        Self::OffFilm,
        Self::WrongComponent,
        Self::Occluded,
        Self::NotConnectable,
        Self::NoEmitter,
        Self::Absorbed,
        Self::Dark,
        Self::NoLength,
        Self::OutOfRange,
    ];

    /// A name for tables and files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Escaped => "escaped",
            Self::OffFilm => "off_film",
            Self::WrongComponent => "wrong_component",
            Self::Occluded => "occluded",
            Self::NotConnectable => "not_connectable",
            Self::NoEmitter => "no_emitter",
            Self::Absorbed => "absorbed",
            Self::Dark => "dark",
            Self::NoLength => "no_length",
            Self::OutOfRange => "out_of_range",
        }
    }
}
