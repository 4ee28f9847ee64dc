//! Many robots, one per lane. Lanes that run together share segment count,
//! movers, cycles and whether there is lubricant, so points are grouped by them.

use super::{GaitTally, Now, Observer, Plan, RunOptions, simulate, simulate_lanes};
use crate::lane::{Lane, Level, Pack, Task, run};
use crate::physics::friction::Parameters;
use crate::physics::gait::{Gait, Schedule};
use crate::physics::lubricant::Lubricant;
use crate::physics::point::COLUMNS;
use crate::physics::{ParamId, Robot, Status};
use std::sync::atomic::{AtomicBool, Ordering};

/// All columns of one point (see `physics::point::row`).
pub type Row = [f64; COLUMNS];

/// Points of a pack, a row per lane.
struct Lanes<'a, L> {
    like: L,
    rows: &'a [&'a Row],
}

impl<L: Lane> Parameters<L> for Lanes<'_, L> {
    fn get(&self, id: ParamId) -> L {
        self.like.fill(|i| self.rows[i][id.main()])
    }
    fn derived(&self, id: ParamId) -> L {
        self.like.fill(|i| self.rows[i][id.derived()])
    }
}

/// What lanes must share.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Key {
    ideal: bool,
    lubricated: bool,
    segments: u64,
    moving: u64,
    cycles: u64,
}

fn key(row: &Row) -> Key {
    let whole = |id: ParamId| row[id.main()] as u64;
    Key {
        ideal: row[ParamId::JointStiffness.main()].is_infinite(),
        lubricated: Lubricant::of(&Lanes { like: 0.0, rows: &[row] }).acts(),
        segments: whole(ParamId::Segments),
        moving: whole(ParamId::Moving),
        cycles: whole(ParamId::Cycles),
    }
}

fn options<L: Lane>(params: &impl Parameters<L>) -> RunOptions<L> {
    RunOptions {
        time_step: params.get(ParamId::TimeStep),
        dwell: params.get(ParamId::Dwell),
        impact: params.get(ParamId::Impact),
        break_away: params.get(ParamId::BreakAway),
    }
}

fn schedule(gait: Gait, key: Key) -> Result<Schedule, Status> {
    gait.schedule(key.segments as usize, key.moving as usize)
}

/// Sees nothing of a run but whether it is still wanted.
#[derive(Clone, Copy)]
struct Flag<'a>(&'a AtomicBool);

impl<L> Observer<L> for Flag<'_> {
    const ON: bool = false;
    fn see(&mut self, _: &Now<L>) {}
    #[inline(always)]
    fn go_on(&self) -> bool {
        !self.0.load(Ordering::Relaxed)
    }
}

/// Lanes of elastic robots that share `key`.
#[inline(always)]
fn together<L: Lane>(
    schedule: &Schedule,
    key: Key,
    params: &impl Parameters<L>,
    mut flag: impl Observer<L>,
) -> GaitTally<L> {
    let robot = Robot::uniform(params, key.segments as usize);
    let plan = Plan { schedule, cycles: key.cycles as usize };
    simulate_lanes(&robot, &plan, &options(params), &mut flag)
}

fn alone(schedule: &Schedule, key: Key, row: &Row, mut flag: impl Observer<f64>) -> GaitTally<f64> {
    let params = Lanes { like: 0.0, rows: &[row] };
    let robot = Robot::uniform(&params, key.segments as usize);
    let plan = Plan { schedule, cycles: key.cycles as usize };
    simulate(&robot, &plan, &options(&params), &mut flag)
}

/// One robot per lane, whatever the lanes have in common. The more of them
/// share segments, movers and cycles the faster; each lane's result is the same
/// in any company.
#[inline(always)]
pub fn gait_tally<L: Lane>(gait: Gait, params: &impl Parameters<L>) -> GaitTally<L> {
    let like = params.get(ParamId::Mass);
    let mut rows: Vec<Row> = Vec::new();
    like.map(|x| {
        rows.push([f64::NAN; COLUMNS]);
        x
    });
    for id in ParamId::all() {
        let (value, derived) = (params.get(id), params.derived(id));
        for (i, row) in rows.iter_mut().enumerate() {
            row[id.main()] = value.lane(i);
            row[id.derived()] = derived.lane(i);
        }
    }
    let keys: Vec<Key> = rows.iter().map(key).collect();
    let mut done: Vec<Option<GaitTally<f64>>> = vec![None; rows.len()];
    while let Some(first) = done.iter().position(Option::is_none) {
        let shared = keys[first];
        let members: Vec<usize> = (0..rows.len()).filter(|i| keys[*i] == shared).collect();
        match schedule(gait, shared) {
            Err(status) => {
                let none = GaitTally::none(0.0, status);
                members.iter().for_each(|i| done[*i] = Some(none));
            }
            Ok(schedule) if shared.ideal => {
                members
                    .iter()
                    .for_each(|i| done[*i] = Some(alone(&schedule, shared, &rows[*i], ())));
            }
            Ok(schedule) => {
                // Lanes of other groups run along as copies.
                let pick = |i: usize| if keys[i] == shared { &rows[i] } else { &rows[first] };
                let picked: Vec<&Row> = (0..rows.len()).map(pick).collect();
                let all = together(&schedule, shared, &Lanes { like, rows: &picked }, ());
                members.iter().for_each(|i| done[*i] = Some(all.lane(*i)));
            }
        }
    }
    GaitTally::fill(like, |i| done[i].unwrap_or(GaitTally::none(0.0, Status::NotFinite)))
}

struct Packs<'a, F> {
    schedule: &'a Schedule,
    key: Key,
    members: &'a [usize],
    point: &'a (dyn Fn(usize) -> Row + Sync),
    flag: Flag<'a>,
    each: F,
}

impl<F: FnMut(usize, GaitTally<f64>)> Task for Packs<'_, F> {
    type Output = ();

    #[inline(always)]
    fn run<P: Pack>(mut self, token: P::Token) {
        for members in self.members.chunks(P::LANES) {
            let rows: Vec<Row> = members.iter().map(|i| (self.point)(*i)).collect();
            let last = rows.len() - 1;
            let rows: Vec<&Row> = (0..P::LANES).map(|i| &rows[i.min(last)]).collect();
            let params = Lanes { like: P::broadcast(token, 0.0), rows: &rows };
            let all = together(self.schedule, self.key, &params, self.flag);
            for (lane, i) in members.iter().enumerate() {
                (self.each)(*i, all.lane(lane));
            }
        }
    }
}

/// Runs the robots of the points 0 to `count`, and hands each result to `each`
/// with the number of its point, in no particular order. Once `cancel` is up runs
/// end at once, without results.
pub fn ensemble(
    level: Level,
    gait: Gait,
    count: usize,
    point: &(dyn Fn(usize) -> Row + Sync),
    cancel: &AtomicBool,
    each: &mut dyn FnMut(usize, GaitTally<f64>),
) {
    let flag = Flag(cancel);
    let mut order: Vec<(Key, usize)> = (0..count).map(|i| (key(&point(i)), i)).collect();
    order.sort_unstable();
    for group in order.chunk_by(|a, b| a.0 == b.0) {
        let shared = group[0].0;
        let members: Vec<usize> = group.iter().map(|m| m.1).collect();
        match schedule(gait, shared) {
            Err(status) => members.iter().for_each(|i| each(*i, GaitTally::none(0.0, status))),
            Ok(schedule) if shared.ideal => {
                members.iter().for_each(|i| each(*i, alone(&schedule, shared, &point(*i), flag)));
            }
            Ok(schedule) => {
                let each = |i, tally| each(i, tally);
                let (schedule, members) = (&schedule, &members[..]);
                run(level, Packs { schedule, key: shared, members, point, flag, each });
            }
        }
    }
}
