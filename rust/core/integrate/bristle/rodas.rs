//! One step of RODAS (Hairer and Wanner 1996, Solving Ordinary Differential Equations II, section
//! IV.10): six stages, one small linear system.

use super::system::{Change, Ledger, Solver};
use super::{Bound, State, Step, Vector};
use crate::lane::Lane;
use crate::physics::friction::{Bristle, ContactState, MOST_STATES};
use crate::physics::segment::Segment;

/// The coefficients, in the form that multiplies no matrix: stage `i` is at the start plus
/// `REACH[i][j]` times what stage `j` solved, a share `TIMES[i]` of the step later; to its rates
/// come `MEMORY[i][j]` per step length times what stage `j` solved, and `SLOPES[i]` step lengths
/// times the derivative by time. The last stage solves the error of the embedded solution.
const STAGES: usize = 6;
const GAMMA: f64 = 0.25;
const TIMES: [f64; STAGES] = [0.0, 0.386, 0.21, 0.63, 1.0, 1.0];
const SLOPES: [f64; STAGES] = [0.25, -0.1043, 0.1035, -0.0362, 0.0, 0.0];
const REACH: [[f64; STAGES - 1]; STAGES] = [
    [0.0; 5],
    [1.544, 0.0, 0.0, 0.0, 0.0],
    [0.946_678_528_081_582_6, 0.255_701_169_898_328_4, 0.0, 0.0, 0.0],
    [3.314_825_187_068_521, 2.896_124_015_972_201, 0.998_641_913_997_781_7, 0.0, 0.0],
    [
        1.221_224_509_226_641,
        6.019_134_481_288_629,
        12.537_083_329_320_87,
        -0.687_886_036_105_895,
        0.0,
    ],
    [
        1.221_224_509_226_641,
        6.019_134_481_288_629,
        12.537_083_329_320_87,
        -0.687_886_036_105_895,
        1.0,
    ],
];
const MEMORY: [[f64; STAGES - 1]; STAGES] = [
    [0.0; 5],
    [-5.668_8, 0.0, 0.0, 0.0, 0.0],
    [-2.430_093_356_833_875, -0.206_359_915_709_191_5, 0.0, 0.0, 0.0],
    [-0.107_352_905_815_137_5, -9.594_562_251_023_355, -20.470_286_148_096_16, 0.0, 0.0],
    [
        7.496_443_313_967_647,
        -10.246_804_314_643_52,
        -33.999_903_528_199_05,
        11.708_908_932_061_6,
        0.0,
    ],
    [
        8.083_246_795_921_522,
        -7.981_132_988_064_893,
        -31.521_594_328_743_71,
        16.319_305_431_231_36,
        -6.058_818_238_834_054,
    ],
];
/// How far on a law is looked at again for its slope along the way, m (rad): far below every length
/// over which friction changes; and how much later, as a share of the step.
const NUDGE: f64 = 1e-7;
const NUDGED: f64 = 1e-6;

impl<Q: Bristle, L: Lane> Bound<Q, L> {
    /// Acceleration, rates of the states, force of the drive and force of friction.
    #[inline(always)]
    fn rates(
        &self,
        segment: &Segment<L>,
        law: &Q::Coefficients<L>,
        (t, drive, sprung): (L, L, bool),
        y: &Vector<L>,
    ) -> (L, [L; MOST_STATES], L, L) {
        let (x, v) = (y[0], y[1]);
        let mut z = [v; MOST_STATES];
        z.copy_from_slice(&y[2..]);
        let mut rates = Q::rates(law, v, &z);
        let against = Q::force(law, v, &z, &rates);
        let force = if sprung { segment.with_spring(drive, t, x, v) } else { drive };
        let mut push = force - segment.pull_back(x) - against;
        if let Some((driven, per_mass)) = Q::driven(law) {
            push = push - force;
            rates[driven] = force.mul_add(per_mass, rates[driven]);
        }
        (push * segment.per_mass, rates, force, against)
    }

    #[inline(always)]
    pub(super) fn attempt_here(
        &self,
        segment: &Segment<L>,
        state: &State<L>,
        dt: L,
        energy: bool,
    ) -> Step<L> {
        let zero = dt.splat(0.0);
        let count = Q::STATES;
        let size = 2 + count;
        let mut y: Vector<L> = [zero; MOST_STATES + 2];
        (y[0], y[1]) = (state.x, state.v);
        y[2..size].copy_from_slice(&state.z[..count]);
        let (t, clock) = (state.t, &state.clock);
        let (varies, steady) = (Q::varies(&self.0), segment.drive.is_steady());
        let sprung = L::any(zero.lt(segment.spring.abs() + segment.damper.abs()));
        let first = segment.commanded(t, clock);
        let start = self.placed(state, &y, (t, first));
        let partials = Q::partials(&start, state.v, &state.z);
        let (per_dt, own) = (dt.splat(1.0) / dt, dt * GAMMA);
        let (mut along, mut aging) = (Change::none(zero), Change::none(zero));
        if varies {
            // The law a little further on, and a little later.
            let way = zero.splat(NUDGE);
            let mut further = y;
            further[0] = further[0] + way;
            let law = self.placed(state, &further, (t, first));
            along = Change::between::<Q>(&start, &law, state, way);
            let pause = dt * NUDGED;
            let soon = t + pause;
            let law = self.placed(state, &y, (soon, segment.commanded(soon, clock)));
            aging = Change::between::<Q>(&start, &law, state, pause);
        }
        let solver =
            Solver::new::<Q>(segment, &partials, &along, state.x, (per_dt * (1.0 / GAMMA), own));
        // What the drive accelerates, and how that changes with time.
        let force_t = segment.force_slope(t, clock);
        let (pushed, per_mass) = match Q::driven(&start) {
            Some((driven, per_mass)) => (2 + driven, per_mass),
            None => (1, segment.per_mass),
        };
        let mut slope_t: Vector<L> = [zero; MOST_STATES + 2];
        if varies {
            slope_t[1] = -(aging.force * segment.per_mass);
            slope_t[2..size].copy_from_slice(&aging.rates[..count]);
        }
        slope_t[pushed] = force_t.mul_add(per_mass, slope_t[pushed]);
        // Work and friction are components like any other, only that nothing depends on them.
        let mut ledger = None;
        let (mut work, mut heat) = ([zero; STAGES], [zero; STAGES]);
        let mut k = [[zero; MOST_STATES + 2]; STAGES];
        let mut at = y;
        let mut spent = (zero, zero);
        for stage in 0..STAGES {
            at = y;
            for (before, share) in k.iter().zip(&REACH[stage]).take(stage) {
                for i in 0..size {
                    at[i] = before[i].mul_add(zero.splat(*share), at[i]);
                }
            }
            let now = dt.mul_add(zero.splat(TIMES[stage]), t);
            let drive = if steady { first } else { segment.commanded(now, clock) };
            let here;
            let mut law = &start;
            if varies {
                here = self.placed(state, &at, (now, drive));
                law = &here;
            }
            let (a, rates, force, against) = self.rates(segment, law, (now, drive, sprung), &at);
            // The rates come last: all else is known before them.
            let mut right: Vector<L> = [zero; MOST_STATES + 2];
            let pause = dt * SLOPES[stage];
            for i in 1..size {
                right[i] = pause * slope_t[i];
            }
            for (before, share) in k.iter().zip(&MEMORY[stage]).take(stage) {
                let share = per_dt * *share;
                for i in 0..size {
                    right[i] = share.mul_add(before[i], right[i]);
                }
            }
            right[0] = right[0] + at[1];
            right[1] = right[1] + a;
            for i in 0..count {
                right[2 + i] = right[2 + i] + rates[i];
            }
            k[stage] = solver.solve::<Q>(&right);
            if energy {
                let book = match ledger {
                    Some(book) => book,
                    None => Ledger::new::<Q>(segment, &partials, (force, against), y[1], own),
                };
                ledger = Some(book);
                let mut flow = ((pause * force_t).mul_add(y[1], force * at[1]), against * at[1]);
                spent = (zero, zero);
                for before in 0..stage {
                    let share = per_dt * MEMORY[stage][before];
                    flow.0 = share.mul_add(work[before], flow.0);
                    flow.1 = share.mul_add(heat[before], flow.1);
                    let share = zero.splat(REACH[stage][before]);
                    spent.0 = share.mul_add(work[before], spent.0);
                    spent.1 = share.mul_add(heat[before], spent.1);
                }
                (work[stage], heat[stage]) = book.solve::<Q>(flow, &k[stage]);
            }
        }
        let [.., last] = k;
        let mut z = [zero; MOST_STATES];
        let (mut error, mut speed_error) = (zero, zero);
        for i in 0..size {
            let new = at[i] + last[i];
            let scale = scale::<Q, L>(segment.tolerance, i, y[i], new);
            let own = (last[i] / scale).abs();
            error = error.max(own);
            if i == 1 {
                speed_error = own;
            }
            at[i] = new;
        }
        z[..count].copy_from_slice(&at[2..size]);
        let error = L::select(error.not_nan(), error, zero.splat(f64::INFINITY));
        let [.., last_work] = work;
        let [.., last_heat] = heat;
        let (work, heat) = (spent.0 + last_work, spent.1 + last_heat);
        Step { x: at[0], v: at[1], z, work, heat, error, speed_error }
    }

    /// The law at a state of a step from `from`, at a time and under what the drive gives then.
    #[inline(always)]
    fn placed(&self, from: &State<L>, y: &Vector<L>, (t, drive): (L, L)) -> Q::Coefficients<L> {
        let way = from.sliding_distance + (y[0] - from.x);
        let at = ContactState {
            direction: y[1].sign(),
            x: y[0],
            sliding_distance: way.max(t.splat(0.0)),
            drive,
            t,
        };
        Q::placed(&self.0, &at)
    }
}

/// Sizes of x, m (rad), and v, m/s, below which their errors count as those of these sizes. Ringing
/// bristles are slower than that most of the time: a tenth of this speed takes half as long again
/// and moves no position by a micrometre, ten times this speed moves some by ten. What replays leave
/// is held by `cargo test --release --test replay bristles`.
const FLOORS: [f64; 2] = [1e-6, 1e-3];

/// Size of an error that just passes.
#[inline(always)]
fn scale<Q: Bristle, L: Lane>(tolerance: L, i: usize, from: L, to: L) -> L {
    let floor = if i < 2 { FLOORS[i] } else { Q::FLOORS[i - 2] };
    tolerance * (from.abs().max(to.abs()) + floor)
}
