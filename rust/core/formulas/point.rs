//! One point of a sweep as the formulas see it, and the two accelerations from
//! which every closed form is made: what an anchor holds and what drags a mover.

use super::params::{PARAM_COUNT, ParamId};
use crate::lane::Lane;

/// Two numbers per parameter: the value, and one derived from it once per axis
/// value instead of once per point.
pub const COLUMNS: usize = 2 * PARAM_COUNT;

/// The derived number of a parameter's value.
pub fn columns(id: ParamId, value: f64) -> [f64; 2] {
    match id {
        ParamId::SlopeDeg => [cos_deg(value), sin_deg(value)],
        ParamId::CornerDeg => [value, 1.0 / cos_deg(value)],
        ParamId::Segments | ParamId::Moving | ParamId::Mass => [value, 1.0 / value],
        _ => [value, 0.0],
    }
}

/// Exact at multiples of 90 degrees, and the same bits on every system.
fn cos_deg(angle: f64) -> f64 {
    sin_deg(90.0 - angle.abs())
}

fn sin_deg(angle: f64) -> f64 {
    let a = angle.abs();
    let sine =
        if a <= 45.0 { libm::sin(a.to_radians()) } else { libm::cos((90.0 - a).to_radians()) };
    if a == 90.0 {
        return 1.0f64.copysign(angle);
    }
    sine.copysign(angle)
}

macro_rules! point {
    ($($field:ident $id:ident $column:ident;)+) => {
        /// The parameters of one point, in lanes.
        #[derive(Clone, Copy)]
        pub struct Point<L> { $(pub $field: L),+ }

        impl<T> Point<T> {
            /// Collects a point from its columns.
            #[inline(always)]
            pub fn gather(mut column: impl FnMut(usize) -> T) -> Self {
                Self { $($field: column(ParamId::$id.$column())),+ }
            }
        }

        impl<T: Copy> Point<T> {
            /// Makes a point from another, column by column.
            #[inline(always)]
            pub fn map<V>(&self, mut f: impl FnMut(usize, T) -> V) -> Point<V> {
                Point { $($field: f(ParamId::$id.$column(), self.$field)),+ }
            }

            /// Makes a point from two others, column by column.
            #[inline(always)]
            pub fn zip<U: Copy, V>(
                &self,
                other: &Point<U>,
                mut f: impl FnMut(usize, T, U) -> V,
            ) -> Point<V> {
                Point { $($field: f(ParamId::$id.$column(), self.$field, other.$field)),+ }
            }
        }

        impl<L: Lane> Point<L> {
            /// Lane `i` as a scalar point.
            #[inline(always)]
            pub fn lane(&self, i: usize) -> Point<f64> {
                Point { $($field: self.$field.lane(i)),+ }
            }
        }
    };
}

point! {
    mu_static MuStatic main;
    mu_coulomb MuCoulomb main;
    segments Segments main;
    per_segments Segments derived;
    cos_slope SlopeDeg main;
    sin_slope SlopeDeg derived;
    mass Mass main;
    per_mass Mass derived;
    gravity Gravity main;
    stroke Stroke main;
    viscous Viscous main;
    moving Moving main;
    per_moving Moving derived;
    anchor_weight AnchorWeight main;
    drive_limit DriveLimit main;
    speed_limit SpeedLimit main;
    anchors_ahead AnchorsAhead main;
    brake Brake main;
    skin_ratio SkinRatio main;
    wall_force WallForce main;
    wall_release WallRelease main;
    per_cos_corner CornerDeg derived;
    coulomb_term CoulombTerm main;
    time Time main;
    speed Speed main;
    segments_min SegmentsMin main;
    segments_max SegmentsMax main;
}

impl<L: Lane> Point<L> {
    /// The same point with another segment count.
    #[inline(always)]
    pub fn with_segments(mut self, segments: L) -> Self {
        self.segments = segments;
        self.per_segments = segments.splat(1.0) / segments;
        self
    }

    /// Normal acceleration (force per mass) on a segment that keeps `share` of
    /// its wall force: weight in a groove of half angle beta, plus preload.
    #[inline(always)]
    fn normal(&self, share: L) -> L {
        let pressed = (self.wall_force * self.per_mass) * share;
        (self.gravity * self.per_cos_corner).mul_add(self.cos_slope, pressed)
    }

    #[inline(always)]
    pub fn anchor_normal(&self) -> L {
        self.normal(self.gravity.splat(1.0))
    }

    #[inline(always)]
    pub fn mover_normal(&self) -> L {
        self.normal(self.gravity.splat(1.0) - self.wall_release)
    }

    /// Friction coefficient of the anchors, which lean backward.
    #[inline(always)]
    pub fn mu_anchor(&self) -> L {
        self.mu_static * self.skin_ratio
    }

    /// The part of an anchor's weight that pulls it down the slope, per mass.
    #[inline(always)]
    pub fn anchor_pull(&self) -> L {
        (self.anchor_weight * self.gravity) * self.sin_slope
    }

    /// What one anchor holds beside its own weight, per mass:
    /// A = mu_S n - w g sin(alpha). Negative: it slides back by itself.
    #[inline(always)]
    pub fn hold(&self) -> L {
        self.mu_anchor().mul_add(self.anchor_normal(), -self.anchor_pull())
    }

    /// What opposes one moving segment, per mass: B = mu_C n + g sin(alpha).
    #[inline(always)]
    pub fn drag(&self) -> L {
        self.mu_coulomb.mul_add(self.mover_normal(), self.gravity * self.sin_slope)
    }

    /// Anchors per moving segment, (N - k)/k.
    #[inline(always)]
    pub fn anchor_ratio(&self) -> L {
        (self.segments - self.moving) * self.per_moving
    }
}

/// All columns from named values, defaults for the rest; NaN where a parameter
/// has neither.
pub fn row(given: &[(ParamId, f64)]) -> [f64; COLUMNS] {
    let mut all = [f64::NAN; COLUMNS];
    for id in ParamId::all() {
        let value = given.iter().rev().find(|(g, _)| *g == id).map(|(_, v)| *v);
        if let Some(value) = value.or(id.param().default) {
            [all[id.main()], all[id.derived()]] = columns(id, value);
        }
    }
    all
}

impl Point<f64> {
    /// A point from named values, see [`row`]. For tests, examples and single
    /// answers.
    pub fn of(given: &[(ParamId, f64)]) -> Self {
        let all = row(given);
        Self::gather(|c| all[c])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn right_angles_are_exact() {
        assert_eq!((sin_deg(90.0), cos_deg(90.0)), (1.0, 0.0));
        assert_eq!((sin_deg(-90.0), cos_deg(-90.0)), (-1.0, 0.0));
        assert_eq!((sin_deg(0.0), cos_deg(0.0)), (0.0, 1.0));
        assert!((sin_deg(30.0) - 0.5).abs() < 1e-16);
        assert!((cos_deg(60.0) - 0.5).abs() < 1e-16);
    }
}
