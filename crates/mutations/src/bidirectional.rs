//! Bidirectional mutation (Veach 11.4.2): deletes a run of vertices and inserts another, possibly of different length, by
//! bidirectional sampling between the two ends that are kept. It alone makes the chain ergodic.
//!
//! With l the last kept vertex on the light's side (-1 if none) and m the first kept on the eye's, `prefix` = l + 1 and
//! `suffix` = k + 1 - m. A pinhole or an orthographic camera is always kept: sampling it again would give the same vertex. A lens
//! may be deleted, m = k + 1, and a new point of it is sampled.

use ergodic_metropolis::{Density, RandomSource, renormalisation};
use ergodic_pathspace::{Path, PathSpace, Scene, density};
use ergodic_scattering::{Component, Repertoire};
use serde::{Deserialize, Serialize};

use crate::chains::{connect, trace, trace_sight};
use crate::{PathMutation, Registered, Rejection, Splice, wavelength};

/// Bidirectional mutation.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct Bidirectional {}

/// The greatest change of length in one mutation.
const MAX_CHANGE: usize = 8;

/// 2⁻ⁿ, exactly.
#[inline]
fn halving(n: usize) -> f64 {
    // The exponent field of a double holds 1023 for 2^0; beyond 2^-1022 the value no longer matters.
    f64::from_bits((1023 - n.min(1022) as u64) << 52)
}

/// Probability, up to normalisation, of deleting `edges` edges (Veach 11.4.2.1, p_{d,1}).
fn deletion_weight(edges: usize) -> f64 {
    match edges {
        1 => 0.25,
        2 => 0.5,
        n => halving(n),
    }
}

/// Probability, up to normalisation, of inserting as many edges as are deleted, changed by `change` (p_{a,1}).
fn insertion_weight(change: usize) -> f64 {
    match change {
        0 => 0.5,
        1 => 0.15,
        n => 0.2 * halving(n),
    }
}

/// The sum of [`insertion_weight`] over the changes 1 ..= `most` to one side: 0.15 + 0.2 (1/4 + 1/8 + …).
fn changes_up_to(most: usize) -> f64 {
    if most == 0 { 0.0 } else { 0.15 + 0.2 * (0.5 - halving(most)) }
}

/// The discrete choices of the mutation, in one place for both sampler and density.
struct Choices {
    /// Edges of the path that is changed.
    k: usize,
    /// Whether the camera's vertex may be deleted, so that the suffix may be 0.
    lens: bool,
}

impl Choices {
    fn new<R: Repertoire>(space: &PathSpace<R>, x: &Path<R>) -> Self {
        Self { k: x.length(), lens: space.scene.camera().has_aperture() }
    }

    /// Number of places for a deletion of `deleted` edges: m - l = deleted, -1 <= l, m <= k, or k + 1 with a lens. Deleting only
    /// the edge before vertex 0 or behind the camera, which is none, changes nothing.
    fn places(&self, deleted: usize) -> usize {
        if deleted == 1 { self.k } else { self.max_deleted() + 1 - deleted }
    }

    fn max_deleted(&self) -> usize {
        self.k + 1 + usize::from(self.lens)
    }

    /// The ways to split `inserted` edges, all as likely: how many vertices come from the light's side. All of them can, unless the
    /// camera's is among them.
    fn splits(suffix: usize, inserted: usize) -> usize {
        inserted - usize::from(suffix == 0)
    }

    fn deletion_total(&self) -> f64 {
        // 1/4 + 1/2 + sum over n = 3 ..= most of 2^-n.
        match self.max_deleted() {
            2 => 0.75,
            most => 1.0 - halving(most),
        }
    }

    /// A deletion: (prefix, number of deleted edges).
    #[inline(always)]
    fn choose_deletion(&self, rng: &mut impl RandomSource) -> (usize, usize) {
        let mut remaining = rng.uniform() * self.deletion_total();
        let mut deleted = 1;
        while deleted < self.max_deleted() {
            remaining -= deletion_weight(deleted);
            if remaining < 0.0 {
                break;
            }
            deleted += 1;
        }
        let place = rng.below(self.places(deleted));
        (if deleted == 1 { place + 1 } else { place }, deleted)
    }

    fn deletion_probability(&self, prefix: usize, deleted: usize) -> f64 {
        if deleted == 0 || deleted > self.max_deleted() || (deleted == 1 && prefix == 0) {
            return 0.0;
        }
        deletion_weight(deleted) / (self.deletion_total() * self.places(deleted) as f64)
    }

    /// The numbers of edges that may be inserted: the new length is allowed, and something changes.
    fn insertions<R: Repertoire>(
        &self,
        space: &PathSpace<R>,
        prefix: usize,
        deleted: usize,
    ) -> std::ops::RangeInclusive<usize> {
        let kept = self.k as isize - deleted as isize;
        let least_allowed = space.lengths.min_edges.max(1) as isize - kept;
        // One edge in place of one is the same path; one edge before vertex 0 would make no light vertex, one behind the camera
        // no camera.
        let camera_goes = prefix + deleted == self.k + 2;
        let least_change = if deleted == 1 || prefix == 0 || camera_goes { 2 } else { 1 };
        let least = least_allowed.max(least_change).max(deleted as isize - MAX_CHANGE as isize);
        let most = (space.lengths.max_edges as isize - kept).min((deleted + MAX_CHANGE) as isize);
        least as usize..=most.max(0) as usize
    }

    /// The sum of [`insertion_weight`] over a range.
    fn insertion_total(range: &std::ops::RangeInclusive<usize>, deleted: usize) -> f64 {
        let (least, most) = (*range.start(), *range.end());
        if least > most {
            0.0
        } else if least > deleted {
            changes_up_to(most - deleted) - changes_up_to(least - deleted - 1)
        } else if most < deleted {
            changes_up_to(deleted - least) - changes_up_to(deleted - most - 1)
        } else {
            insertion_weight(0) + changes_up_to(most - deleted) + changes_up_to(deleted - least)
        }
    }

    fn choose_insertion<R: Repertoire>(
        &self,
        space: &PathSpace<R>,
        prefix: usize,
        deleted: usize,
        rng: &mut impl RandomSource,
    ) -> Option<usize> {
        let range = self.insertions(space, prefix, deleted);
        let mut remaining = rng.uniform() * Self::insertion_total(&range, deleted);
        let mut last = None;
        for inserted in range {
            last = Some(inserted);
            remaining -= insertion_weight(inserted.abs_diff(deleted));
            if remaining < 0.0 {
                break;
            }
        }
        last
    }

    fn insertion_probability<R: Repertoire>(
        &self,
        space: &PathSpace<R>,
        prefix: usize,
        deleted: usize,
        inserted: usize,
    ) -> f64 {
        let range = self.insertions(space, prefix, deleted);
        if !range.contains(&inserted) {
            return 0.0;
        }
        insertion_weight(inserted.abs_diff(deleted)) / Self::insertion_total(&range, deleted)
    }
}

impl Bidirectional {
    /// Samples `count` vertices from the light's side, from index `first` on.
    fn walk_from_light<R: Repertoire>(
        space: &PathSpace<R>,
        y: &mut Path<R>,
        first: usize,
        count: usize,
        rng: &mut impl RandomSource,
    ) -> Result<(), Rejection> {
        let scene = &space.scene;
        for i in first..first + count {
            if i == 0 {
                scene.sample_emitter(y.wavelength, &mut y.vertices[0], rng);
                continue;
            }
            if i == 1 {
                let [light, met, ..] = &mut y.vertices[..] else { return Err(Rejection::Escaped) };
                if !scene.sample_emission(light, y.wavelength, met, rng) {
                    return Err(Rejection::Escaped);
                }
                y.derive_edges(scene, 0, 1);
            } else {
                let before = &mut y.vertices[i - 1];
                let w_from = -y.edges[i - 2].direction;
                let u = [rng.uniform(), rng.uniform(), rng.uniform()];
                let (w, component) = before.interaction.sample(w_from, u).ok_or(Rejection::Absorbed)?;
                before.component = component;
                trace(scene, y, i - 1, i, w, rng)?;
            }
        }
        Ok(())
    }

    /// Samples `count` vertices from the eye's side, from index `last` down.
    fn walk_from_eye<R: Repertoire>(
        space: &PathSpace<R>,
        y: &mut Path<R>,
        last: usize,
        count: usize,
        rng: &mut impl RandomSource,
    ) -> Result<(), Rejection> {
        let scene = &space.scene;
        let k = y.length();
        for i in (last + 1 - count..=last).rev() {
            if i == k {
                y.vertices[k] = scene.sample_eye(rng);
            } else if i + 1 == k {
                let camera = scene.camera();
                let raster = camera.sample_raster([rng.uniform(), rng.uniform()]);
                trace_sight(scene, y, &camera.sight(y.vertices[k].position, raster), rng)?;
            } else {
                let before = &mut y.vertices[i + 1];
                let u = [rng.uniform(), rng.uniform(), rng.uniform()];
                let (w, component) =
                    before.interaction.sample(y.edges[i + 1].direction, u).ok_or(Rejection::Absorbed)?;
                before.component = component;
                trace(scene, y, i + 1, i, w, rng)?;
            }
        }
        Ok(())
    }

    /// Makes vertex `i` an end of the connection.
    fn make_connectable<R: Repertoire>(y: &mut Path<R>, i: usize) -> Result<(), Rejection> {
        let k = y.length();
        let vertex = &mut y.vertices[i];
        if i > 0 && i < k && !vertex.interaction.has_rough() {
            return Err(Rejection::NotConnectable);
        }
        vertex.component = Component::Rough;
        Ok(())
    }
}

impl Registered for Bidirectional {
    const ERGODIC: bool = true;

    fn validate(&self) -> Result<(), String> {
        Ok(())
    }
}

impl PathMutation for Bidirectional {
    fn propose<R: Repertoire>(
        &self,
        space: &PathSpace<R>,
        x: &Path<R>,
        y: &mut Path<R>,
        rng: &mut impl RandomSource,
    ) -> Result<Splice, Rejection> {
        let scene = &space.scene;
        let k = x.length();
        let choices = Choices::new(space, x);
        let (prefix, deleted) = choices.choose_deletion(rng);
        let inserted = choices.choose_insertion(space, prefix, deleted, rng).ok_or(Rejection::NoLength)?;
        // m = l + deleted, so the suffix is what follows vertex m - 1 = prefix + deleted - 2.
        let first_kept = prefix + deleted - 1;
        let suffix = k + 1 - first_kept;
        // s vertices from the light's side, the others from the eye's.
        let s = rng.below(Choices::splits(suffix, inserted));
        let t = inserted - 1 - s;
        if !(prefix..=first_kept).any(|s| density::strategy_exists(&x.vertices, s)) {
            // A run of Dirac vertices between kept ones: no split could sample it again, so there is no way back.
            return Err(Rejection::NotConnectable);
        }
        let new_end = prefix + inserted - 1;
        y.begin(x, prefix, inserted - 1, suffix);
        // A walk says by which component it leaves the last vertex that is kept.
        y.release_ends();
        y.wavelength = wavelength::draw(scene, x, Splice { prefix, suffix }, rng);

        Self::walk_from_light(space, y, prefix, s, rng)?;
        if t > 0 {
            Self::walk_from_eye(space, y, prefix + inserted - 2, t, rng)?;
        }
        if prefix + s == 0 {
            // Nothing from the light's side: the walk from the eye must have landed on a light.
            y.vertices[0].component = Component::Rough;
            y.derive_scattering(scene, 0, new_end.min(y.length()));
            if y.scattering[0].max_element() <= 0.0 {
                return Err(Rejection::NoEmitter);
            }
        } else {
            let end = prefix + s - 1;
            Self::make_connectable(y, end)?;
            Self::make_connectable(y, end + 1)?;
            connect(scene, y, end)?;
            // The vertices next to new ones scatter in other directions than before.
            if let Some(last) = end.checked_sub(1) {
                y.derive_scattering(scene, prefix.saturating_sub(1), last);
            }
            y.derive_scattering(scene, end + 2, new_end.min(y.length()));
        }
        Ok(Splice { prefix, suffix })
    }

    fn density<R: Repertoire>(&self, space: &PathSpace<R>, from: &Path<R>, to: &Path<R>, plan: Splice) -> Density {
        let scene = &space.scene;
        let Splice { prefix, suffix } = plan;
        let new_end = to.vertices.len() - suffix;
        let inserted = new_end - prefix + 1;
        let deleted = from.vertices.len() - suffix - prefix + 1;
        let choices = Choices::new(space, from);
        let discrete = choices.deletion_probability(prefix, deleted)
            * choices.insertion_probability(space, prefix, deleted, inserted)
            / Choices::splits(suffix, inserted) as f64
            * wavelength::pdf_of_draw(scene, from, to, plan);
        if discrete <= 0.0 {
            return Density::ZERO;
        }
        let mut density = Self::sum_over_splits(scene, to, prefix, new_end);
        density.multiply(discrete);
        density
    }
}

impl Bidirectional {
    /// The sum over all splits of the new vertices `prefix .. new_end` into some from the light and the rest from
    /// the eye, each of which could have made them.
    ///
    /// With l and e the densities from either side, sum = Σ_s Π_{i<s} l_i Π_{i>=s} e_i over the splits that exist, in one
    /// pass from the light: multiplying what is there by e_i, then adding the split after i.
    fn sum_over_splits<R: Repertoire>(scene: &Scene<R>, path: &Path<R>, prefix: usize, new_end: usize) -> Density {
        let vertices = &path.vertices[..];
        let mut power = 0;
        let mut from_light = 1.0;
        let mut sum = if density::strategy_exists(vertices, prefix) { 1.0 } else { 0.0 };
        for i in prefix..new_end {
            if sum != 0.0 {
                sum *= density::pdf_area_from_eye(scene, path, i);
            }
            from_light *= density::pdf_area_from_light(scene, path, i);
            if density::strategy_exists(vertices, i + 1) {
                sum += from_light;
            }
            if let Some((factor, by)) = renormalisation(from_light.max(sum)) {
                from_light *= factor;
                sum *= factor;
                power += by;
            }
        }
        Density::new(sum).scaled(power)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn totals_are_sums_of_weights() {
        for deleted in 1..20 {
            for least in 0..30 {
                for most in 0..30 {
                    let sum: f64 = (least..=most).map(|n: usize| insertion_weight(n.abs_diff(deleted))).sum();
                    let total = Choices::insertion_total(&(least..=most), deleted);
                    assert!((total - sum).abs() <= 1e-15, "{deleted} {least} {most}: {total} {sum}");
                }
            }
        }
    }
}
