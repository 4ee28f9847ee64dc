//! Equation of motion along a measured motion: by how much a plant would have moved the
//! head over each slide, if it moved as it was measured. Friction meets the measured speed,
//! so no error of a model feeds back into its motion, and a model costs no search for events.

use super::driven_side::DrivenSide;
use super::replay::{Samples, Start, segment};
use crate::lane::Lane;
use crate::physics::effects::{Measured, Plant};
use crate::physics::friction::{ContactState, Dry};

/// What was measured of a run, at its samples.
#[derive(Debug, Clone, Copy)]
pub struct MeasuredMotion<'a> {
    pub x: &'a [f64],
    pub v: &'a [f64],
    /// Distance moved forward since the last rest or turn.
    pub sliding_distance: &'a [f64],
    /// Slides in one direction: first sample and one beyond the last.
    pub slides: &'a [(usize, usize)],
}

/// Mean of a sample and the next.
#[inline(always)]
fn middle(values: &[f64], i: usize) -> f64 {
    0.5 * (values[i] + values[i + 1])
}

/// Mean over each block of samples of the position that the sensor would read, without
/// start and start speed of the slide: `read` gets the blocks of all slides in turn.
#[inline(always)]
pub fn displacements<L: Lane>(
    plant: &Plant<L>,
    samples: Samples,
    motion: MeasuredMotion,
    block: usize,
    mut go_on: impl FnMut() -> bool,
    mut read: impl FnMut(L),
) {
    let zero = plant.mass.splat(0.0);
    let times = samples.times;
    let nowhere = Start { x: zero, v: zero, sliding_distance: zero };
    let segment = &segment(plant, &plant.path, samples, nowhere);
    let drive = &segment.drive;
    let mut t = zero.splat(times[0]);
    let mut clock = drive.clock(t);
    let mut side = plant.joint.map(|joint| DrivenSide::new(joint, drive.force(t, &clock)));
    let [scale, drift, delay] = plant.sensor;
    let mut first = 0;
    for (from, to) in motion.slides.iter().copied() {
        if !go_on() {
            return;
        }
        let (mut x, mut v) = (zero, zero);
        let (mut sum, mut count) = (zero, 0_usize);
        for i in first..to {
            if i >= from {
                let since = times[i] - times[from];
                let seen = drift.mul_add(zero.splat(since), (scale + 1.0) * x);
                sum = sum + (seen - delay * motion.v[i]);
                count += 1;
                if count == block || i + 1 == to {
                    read(sum * (1.0 / count as f64));
                    (sum, count) = (zero, 0);
                }
            }
            if i + 1 == to {
                // The next slide may begin with this sample.
                break;
            }
            let until = zero.splat(times[i + 1]);
            let mut impulse = zero;
            while L::any(t.lt(until)) {
                let end = drive.piece_end(clock.piece);
                let active = t.lt(until);
                let next = L::select(active, end.min(until), t);
                let dt = (next - t).max(zero);
                impulse = dt.mul_add(drive.mean(t, dt, &clock), impulse);
                let over = L::and(active, end.le(next));
                drive.turn_over(&mut clock, end, over);
                t = next;
            }
            let dt = times[i + 1] - times[i];
            if let Some(side) = &mut side {
                impulse = side.pass_on(impulse, motion.v[i + 1] - motion.v[i], dt);
            }
            if i < from {
                continue;
            }
            let force = impulse * (1.0 / dt);
            let (at_x, at_v) = (zero.splat(middle(motion.x, i)), zero.splat(middle(motion.v, i)));
            let direction = at_v.sign();
            let at = ContactState {
                direction,
                x: at_x,
                sliding_distance: zero.splat(middle(motion.sliding_distance, i)),
                drive: force,
                t: zero.splat(middle(times, i)),
            };
            let against = Measured::resistance(&plant.friction, at_v.abs(), &at);
            let net = force - segment.pull_back(at_x) - direction * against;
            let gained = (net * segment.per_mass) * dt;
            x = (gained * 0.5 + v).mul_add(zero.splat(dt), x);
            v = v + gained;
        }
        first = to - 1;
    }
}
