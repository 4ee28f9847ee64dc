//! The laws with their kernels, chosen once per sweep: what is compiled per law and
//! SIMD level.

use super::packs::{Cells, Stretch, Visit, each_pack};
use super::scalar;
use crate::integrate::bristle::{self, BristleContact, Rosenbrock};
use crate::integrate::dry_contact::{self, DryContact};
use crate::integrate::exact::{self, Exact};
use crate::integrate::runge_kutta::RungeKutta;
use crate::integrate::smooth::{self, Ahead, SmoothContact, Steps};
use crate::integrate::{Method, Tally, Watch};
use crate::lane::{Level, Pack, Task, run};
use crate::physics::for_each_law;
use crate::physics::friction::*;
use crate::physics::segment::Segment;
use std::marker::PhantomData;
use std::sync::atomic::Ordering;

/// A law's trajectories, compiled for every SIMD level.
type Kernel = fn(Level, Stretch);

macro_rules! kernels {
    ($($kind:ident $file:ident::$law:ident),+ $(,)?) => {
        /// In the order of `LAWS`; static, so that they are compiled here and not by who asks.
        static KERNELS: &[Kernel] = &[$(kernels!(@$kind $law)),+];
    };
    (@dry $law:ident) => {
        |level, stretch| {
            if stretch.simulation.method.is_scalar() {
                scalar::dormand_prince(stretch, scalar::bind::<$law>);
            } else {
                run(level, DryRuns::<$law> { stretch, law: PhantomData });
            }
        }
    };
    (@smooth $law:ident) => {
        |level, stretch| {
            if stretch.simulation.method == Method::RungeKutta {
                run(level, SmoothRuns::<$law> { stretch, law: PhantomData });
            } else {
                run(level, BristleRuns::<Stiff<$law>> { stretch, law: PhantomData });
            }
        }
    };
    (@bristle $law:ident) => {
        |level, stretch| run(level, BristleRuns::<$law> { stretch, law: PhantomData })
    };
}
for_each_law!(kernels);

/// Simulates a stretch of cells.
#[inline(never)]
pub fn simulate(level: Level, stretch: Stretch) {
    KERNELS[stretch.simulation.law_index](level, stretch);
}

/// Takes the coefficients of a law on a pack of cells and hands them on. Only this is
/// compiled per law, with what a law does in a step; the loops are shared by all laws
/// of a kind.
type Bind<P, C> = fn(&Segment<P>, &Cells<P>, &mut dyn FnMut(&C));

/// Runs a stretch by what `method` makes of the law, compiled for the pack's instructions.
#[inline(always)]
fn each_bound<P: Pack, C: ?Sized>(
    token: P::Token,
    stretch: Stretch,
    bind: Bind<P, C>,
    mut method: impl FnMut(&C, &Segment<P>, &mut Visit<P>) -> Tally<P>,
) {
    let like = P::broadcast(token, 0.0);
    like.outlined(
        #[inline(always)]
        || {
            each_pack::<P>(
                token,
                stretch,
                #[inline(always)]
                |cells, segment, visit| {
                    let mut tally = None;
                    bind(segment, cells, &mut |contact| {
                        tally = Some(like.outlined(
                            #[inline(always)]
                            || method(contact, segment, visit),
                        ));
                    });
                    tally.unwrap_or_else(|| Tally::start(segment, Watch::NOTHING))
                },
            );
        },
    );
}

struct DryRuns<'a, Q> {
    stretch: Stretch<'a>,
    law: PhantomData<Q>,
}

impl<Q: Dry> Task for DryRuns<'_, Q> {
    type Output = ();

    #[inline(always)]
    fn run<P: Pack>(self, token: P::Token) {
        if const { Q::LINEAR } && self.stretch.simulation.method == Method::Exact {
            // A piece is too short to hide a call.
            let Stretch { watch, cancel, .. } = self.stretch;
            let go_on = || !cancel.load(Ordering::Relaxed);
            each_pack::<P>(
                token,
                self.stretch,
                #[inline(always)]
                |cells, segment, visit| {
                    let contact = &exact::Bound::<Q, P>(Q::coefficients(&segment.contact, cells));
                    visit.drive(Exact { segment, contact, go_on }, watch)
                },
            );
        } else {
            dry_runs(token, self.stretch, |segment: &Segment<P>, cells, then| {
                then(&dry_contact::Bound::<Q, P>(coefficients::<Q, P>(segment, cells)));
            });
        }
    }
}

#[inline(always)]
fn coefficients<Q: Law, P: Pack>(segment: &Segment<P>, cells: &Cells<P>) -> Q::Coefficients<P> {
    segment.mass.outlined(
        #[inline(always)]
        || Q::coefficients(&segment.contact, cells),
    )
}

fn dry_runs<P: Pack>(token: P::Token, stretch: Stretch, bind: Bind<P, dyn DryContact<P>>) {
    let Stretch { simulation, watch, cancel, .. } = stretch;
    let go_on = || !cancel.load(Ordering::Relaxed);
    let locate = simulation.locate;
    each_bound(
        token,
        stretch,
        bind,
        #[inline(always)]
        |contact, segment, visit| {
            let step = segment.step;
            let method = RungeKutta::<_, _, _>::new(segment, contact, locate, step, go_on);
            visit.drive(method, watch)
        },
    );
}

struct SmoothRuns<'a, Q> {
    stretch: Stretch<'a>,
    law: PhantomData<Q>,
}

impl<Q: Smooth> Task for SmoothRuns<'_, Q> {
    type Output = ();
    const CHAINED: bool = true;

    #[inline(always)]
    fn run<P: Pack>(self, token: P::Token) {
        smooth_runs(token, self.stretch, |segment: &Segment<P>, cells, then| {
            then(&smooth::Bound::<Q, P>(coefficients::<Q, P>(segment, cells)));
        });
    }
}

fn smooth_runs<P: Pack>(token: P::Token, stretch: Stretch, bind: Bind<P, dyn SmoothContact<P>>) {
    let Stretch { simulation, watch, cancel, ref trace, .. } = stretch;
    let go_on = || !cancel.load(Ordering::Relaxed);
    // Stations cut steps, which are then no longer those worked out ahead.
    let ahead = if trace.is_some() { &[][..] } else { &simulation.ahead };
    each_bound(
        token,
        stretch,
        bind,
        #[inline(always)]
        |contact, segment, visit| {
            let (ahead, sprung) = (Ahead(ahead), simulation.sprung);
            visit.drive(Steps::new(segment, contact, sprung, ahead, go_on), watch)
        },
    );
}

struct BristleRuns<'a, Q> {
    stretch: Stretch<'a>,
    law: PhantomData<Q>,
}

impl<Q: Bristle> Task for BristleRuns<'_, Q> {
    type Output = ();

    #[inline(always)]
    fn run<P: Pack>(self, token: P::Token) {
        bristle_runs(token, self.stretch, |segment: &Segment<P>, cells, then| {
            then(&bristle::Bound::<Q, P>(coefficients::<Q, P>(segment, cells)));
        });
    }
}

fn bristle_runs<P: Pack>(token: P::Token, stretch: Stretch, bind: Bind<P, dyn BristleContact<P>>) {
    let Stretch { simulation, watch, cancel, .. } = stretch;
    let go_on = || !cancel.load(Ordering::Relaxed);
    let adaptive = simulation.method == Method::Rosenbrock;
    each_bound(
        token,
        stretch,
        bind,
        #[inline(always)]
        |contact, segment, visit| {
            visit.drive(Rosenbrock::new(segment, contact, adaptive, go_on), watch)
        },
    );
}
