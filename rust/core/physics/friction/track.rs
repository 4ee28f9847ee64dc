//! Friction along a smooth curve through six ratios, repeated along the track.

use super::{Contact, ContactState, Dry, Law, LawInfo, Parameters, ReferenceValue};
use crate::lane::Lane;
use crate::params::ParamId;

const KNOTS: usize = 6;

pub struct Track;

#[derive(Clone, Copy)]
pub struct Spline<L> {
    contact: Contact<L>,
    per_length: L,
    knots: [L; KNOTS],
    /// Second derivative at each knot, times the squared distance of knots over 6.
    bends: [L; KNOTS],
}

impl<L: Lane> Spline<L> {
    #[inline(always)]
    fn at(&self, level: L, at: &ContactState<L>) -> L {
        let zero = level.splat(0.0);
        let turns = at.x * self.per_length;
        let along = (turns - turns.floor()) * KNOTS as f64;
        // A position just below zero rounds up to the end of the last piece.
        let piece = along.floor().min(along.splat(KNOTS as f64 - 1.0));
        let s = along - piece;
        let [mut from, mut to, mut bend, mut next] = [zero; 4];
        for i in 0..KNOTS {
            let here = piece.le(piece.splat(i as f64 + 0.5));
            let here = L::and(here, piece.splat(i as f64 - 0.5).le(piece));
            let j = (i + 1) % KNOTS;
            from = L::select(here, self.knots[i], from);
            to = L::select(here, self.knots[j], to);
            bend = L::select(here, self.bends[i], bend);
            next = L::select(here, self.bends[j], next);
        }
        let left = s.splat(1.0) - s;
        let line = s.mul_add(to - from, from);
        let curve = ((left * left - 1.0) * left).mul_add(bend, ((s * s - 1.0) * s) * next);
        level * (line + curve).max(zero)
    }
}

impl Law for Track {
    const INFO: LawInfo = LawInfo {
        name: "track",
        formula: r"F = F_C\,\rho(x)\,\mathrm{sgn}\,v + \mu_V v,\quad \rho(x) \text{ the periodic cubic spline through } \rho_1 \dots \rho_6",
        source: "position-dependent friction by a spline; this project",
        limits: "may swing beyond its six ratios between them, never below 0; static friction varies alike",
        meaning: "levels along a smooth curve through six ratios",
        params: &[
            "mu_static",
            "mu_coulomb",
            "viscous",
            "track_length",
            "track_1",
            "track_2",
            "track_3",
            "track_4",
            "track_5",
            "track_6",
        ],
        reference: ReferenceValue {
            // Ratios of the cosine 1 + cos(2 pi x/L)/2; halfway between the
            // first two knots the spline is 229/160, the cosine 1.4330.
            parameters: &[
                ("mu_static", 0.5),
                ("mu_coulomb", 0.35),
                ("mass", 1.0),
                ("gravity", 12.0),
                ("viscous", 0.5),
                ("track_length", 0.375),
                ("track_1", 1.5),
                ("track_2", 1.25),
                ("track_3", 0.75),
                ("track_4", 0.5),
                ("track_5", 0.75),
                ("track_6", 1.25),
            ],
            speed: 2.0,
            at: (0.03125, 0.0, 0.0),
            force: 7.011_25,
            ..ReferenceValue::NONE
        },
    };
    type Coefficients<L: Lane> = Spline<L>;

    #[inline(always)]
    fn coefficients<L: Lane>(contact: &Contact<L>, params: &impl Parameters<L>) -> Spline<L> {
        use ParamId::{Track1, Track2, Track3, Track4, Track5, Track6};
        let length = params.get(ParamId::TrackLength);
        let mut knots = [length; KNOTS];
        for (knot, id) in knots.iter_mut().zip([Track1, Track2, Track3, Track4, Track5, Track6]) {
            *knot = params.get(id);
        }
        let at = |i: usize| knots[i % KNOTS];
        let turn = |i: usize| (at(i + 1) - at(i)) - (at(i) - at(i + 5));
        // b[i-1] + 4 b[i] + b[i+1] = turn[i] all round: the inverse of that
        // matrix repeats 26, -7, 2, -1, 2, -7 over 90.
        let mut bends = knots;
        for (i, bend) in bends.iter_mut().enumerate() {
            let near = turn(i + 1) + turn(i + 5);
            let far = turn(i + 2) + turn(i + 4);
            let sum = turn(i) * 26.0 - near * 7.0 + far * 2.0 - turn(i + 3);
            *bend = sum * (1.0 / 90.0);
        }
        Spline { contact: *contact, per_length: length.splat(1.0) / length, knots, bends }
    }
}

impl Dry for Track {
    const PLACED: bool = true;

    #[inline(always)]
    fn resistance<L: Lane>(law: &Spline<L>, speed: L, at: &ContactState<L>) -> L {
        law.contact.viscous.mul_add(speed, law.at(law.contact.coulomb, at))
    }
    #[inline(always)]
    fn break_away<L: Lane>(law: &Spline<L>, at: &ContactState<L>) -> L {
        law.at(law.contact.break_away, at)
    }
}
