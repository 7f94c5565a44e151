//! Every ray that this thread traces, in order, so that a profile can trace them again with nothing else done.
//!
//! Without the feature `record`, which only the profile program switches on, all this is empty and costs nothing.

use ergodic_geometry::Ray;
use ergodic_scattering::Repertoire;

use crate::Vertex;

#[cfg(feature = "record")]
pub use recorder::{Question, recorded};

/// Notes that the closest hit of `ray` is asked for.
#[inline(always)]
pub(crate) fn closest(_ray: &Ray) {
    #[cfg(feature = "record")]
    recorder::note(|| Question::Closest(*_ray));
}

/// Notes that the visibility between two vertices is asked for.
#[inline(always)]
pub(crate) fn visibility<R: Repertoire>(_a: &Vertex<R>, _b: &Vertex<R>) {
    #[cfg(feature = "record")]
    recorder::note(|| recorder::between(_a, _b));
}

#[cfg(feature = "record")]
mod recorder {
    use std::cell::RefCell;

    use ergodic_geometry::{Anchor, Ray, World};
    use ergodic_scattering::Repertoire;
    use glam::DVec3;

    use crate::{Kind, Vertex};

    thread_local! {
        static QUESTIONS: RefCell<Option<Vec<Question>>> = const { RefCell::new(None) };
    }

    /// What was asked of the [`World`].
    #[derive(Clone, Copy, Debug)]
    pub enum Question {
        /// [`World::intersect`].
        Closest(Ray),
        /// [`World::visible`].
        Visible(Anchor, Anchor),
        /// [`World::escapes`].
        Escapes(Anchor, DVec3),
    }

    impl Question {
        /// Asks again; whether anything was hit.
        #[inline(always)]
        pub fn ask(&self, world: &World) -> bool {
            match self {
                Self::Closest(ray) => std::hint::black_box(world.intersect(ray)).is_some(),
                Self::Visible(a, b) => !world.visible(a, b),
                Self::Escapes(a, direction) => !world.escapes(a, *direction),
            }
        }
    }

    /// What [`crate::Scene::mutually_visible`] asks.
    pub(super) fn between<R: Repertoire>(a: &Vertex<R>, b: &Vertex<R>) -> Question {
        match (a.kind, b.kind) {
            (Kind::DistantLight(_) | Kind::Environment, _) => Question::Escapes(b.anchor(), -a.interaction.ng),
            (_, Kind::DistantLight(_) | Kind::Environment) => Question::Escapes(a.anchor(), -b.interaction.ng),
            _ => Question::Visible(a.anchor(), b.anchor()),
        }
    }

    pub(super) fn note(question: impl FnOnce() -> Question) {
        QUESTIONS.with_borrow_mut(|questions| {
            if let Some(questions) = questions {
                questions.push(question());
            }
        });
    }

    /// Does `work` and returns all that it asked, in order.
    pub fn recorded(work: impl FnOnce()) -> Vec<Question> {
        QUESTIONS.set(Some(Vec::new()));
        work();
        QUESTIONS.take().unwrap_or_default()
    }
}
