//! The cap on the diffuse lobe of a layered surface, so that both its lobes together make no energy.

use glam::DVec3;

use super::{Layered, Lobe, through};
use crate::effects::Effects;
use crate::ggx::Roughness;
use crate::{Rgb, specular_albedo};

impl<R: Roughness, E: Effects> Layered<R, E> {
    /// At least the directional albedo of the dielectric's reflection for light at cosine `cos` with the surface: the albedo
    /// itself for a smooth one.
    #[inline]
    fn reflected(&self, cos: f64, inside: bool) -> Rgb {
        if self.reflection != Lobe::RoughReflection {
            return self.dielectric_at(cos, inside);
        }
        let at = |alpha: f64| {
            if self.is_by_schlick() {
                self.dielectric.integrated(specular_albedo::schlick(cos, alpha))
            } else {
                specular_albedo::at_most(|cos| self.dielectric_at(cos, inside), cos, alpha)
            }
        };
        let (least, largest) = (self.alpha.least(), self.alpha.largest());
        // Between two roughnesses the albedo is about between theirs.
        if least == largest { at(least) } else { at(least).max(at(largest)) }
    }

    /// Whether the dielectric's reflectance is Schlick's.
    #[inline]
    fn is_by_schlick(&self) -> bool {
        !self.dielectric.exact && !self.effects.has_film()
    }

    /// The share of the light that gets to the diffuse lobes and back along `a` and `b`, where the dielectric reflects
    /// `dielectric`: glTF's 1 - max F, but no more than leaves room for what is reflected. The same for both exchanged.
    #[inline]
    pub(super) fn kept(&self, dielectric: Rgb, a: DVec3, b: DVec3) -> f64 {
        let kept = through(dielectric);
        let color = self.diffuse_color();
        if self.reflection == Lobe::Absent {
            return kept;
        }
        if !self.is_by_schlick() {
            let reflected = |w: DVec3| self.reflected(w.z.abs(), self.is_inside(w));
            return capped(capped(kept, color, reflected(a)), color, reflected(b));
        }
        // From both sides the same, and more at the more grazing direction. Most surfaces have room for more than that
        // whatever the angle, or the roughness, is.
        let cos = a.z.abs().min(b.z.abs());
        let most = specular_albedo::schlick_at_most(cos, self.alpha.least());
        if (color * kept + self.dielectric.integrated([1.0, most])).max_element() <= 1.0 {
            return kept;
        }
        self.looked_up(kept, cos)
    }

    /// The cap for Schlick's reflectance by the table. Rare enough to be a call, which keeps the common way short.
    #[cold]
    #[inline(never)]
    fn looked_up(&self, kept: f64, cos: f64) -> f64 {
        capped(kept, self.diffuse_color(), self.reflected(cos, false))
    }
}

/// `kept`, or as much of it as lets diffuse light of this colour and what is `reflected` be at most 1 in every channel.
#[inline]
pub(super) fn capped(mut kept: f64, color: Rgb, reflected: Rgb) -> f64 {
    let room = (1.0 - reflected).max(Rgb::ZERO);
    for (color, room) in color.to_array().into_iter().zip(room.to_array()) {
        if color * kept > room {
            kept = room / color;
        }
    }
    kept
}
