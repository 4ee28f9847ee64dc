//! What every registered friction law promises, whatever its formula.

mod promises;
#[path = "../common/random.rs"]
mod random;

use locosweep::Error;
use locosweep::lane::{Lane, Level, Pack, Task, run};
use locosweep::physics::friction::*;
use locosweep::physics::{PARAMS, ParamId};
use random::Random;
use std::marker::PhantomData;

/// Where a law is asked.
#[derive(Debug, Clone, Copy)]
struct Ask<L> {
    speed: L,
    contact_state: ContactState<L>,
    states: [L; MOST_STATES],
}

const OUTPUTS: usize = 36;
/// Place of whether a dry law changes with time.
const AGES: usize = 4;

/// All functions of a law at once, on any lanes.
trait Probe {
    fn outputs<L: Lane>(params: &impl Parameters<L>, ask: &Ask<L>) -> [L; OUTPUTS];
}

struct OfDry<D>(PhantomData<D>);
struct OfSmooth<S>(PhantomData<S>);
struct OfBristle<B>(PhantomData<B>);

impl<D: Dry> Probe for OfDry<D> {
    #[inline(always)]
    fn outputs<L: Lane>(params: &impl Parameters<L>, ask: &Ask<L>) -> [L; OUTPUTS] {
        let law = D::coefficients(&Contact::of(params), params);
        let mut all = [ask.speed.splat(0.0); OUTPUTS];
        all[0] = D::resistance(&law, ask.speed, &ask.contact_state);
        all[1] = D::break_away(&law, &ask.contact_state);
        if D::LINEAR {
            (all[2], all[3]) = D::linear(&law, &ask.contact_state);
        }
        all[AGES] = ask.speed.splat(if D::ages(&law) { 1.0 } else { 0.0 });
        all
    }
}

impl<S: Smooth> Probe for OfSmooth<S> {
    #[inline(always)]
    fn outputs<L: Lane>(params: &impl Parameters<L>, ask: &Ask<L>) -> [L; OUTPUTS] {
        let law = S::coefficients(&Contact::of(params), params);
        let mut all = [ask.speed.splat(0.0); OUTPUTS];
        all[0] = S::force(&law, ask.speed);
        all
    }
}

impl<B: Bristle> Probe for OfBristle<B> {
    #[inline(always)]
    fn outputs<L: Lane>(params: &impl Parameters<L>, ask: &Ask<L>) -> [L; OUTPUTS] {
        let law = B::coefficients(&Contact::of(params), params);
        let zero = ask.speed.splat(0.0);
        let rates = B::rates(&law, ask.speed, &ask.states);
        let partials = B::partials(&law, ask.speed, &ask.states);
        let mut all = [zero; OUTPUTS];
        all[0] = B::force(&law, ask.speed, &ask.states, &rates);
        all[1] = B::stored(&law, &ask.states);
        all[2] = partials.force_v;
        let steady = B::steady(&law, ask.speed);
        for i in 0..B::STATES {
            all[4 + i] = rates[i];
            all[8 + i] = steady[i];
            all[12 + i] = partials.rate_v[i];
            all[16 + i] = partials.force_z[i];
            for j in 0..B::STATES {
                all[20 + 4 * i + j] = partials.rate_z[i][j];
            }
        }
        all
    }
}

/// One set of parameters and one question.
#[derive(Clone)]
struct Case {
    values: Values,
    ask: Ask<f64>,
}

/// Parameters of as many cases as there are lanes.
struct Lanes<'a, P> {
    like: P,
    cases: &'a [Case],
}

impl<P: Pack> Parameters<P> for Lanes<'_, P> {
    #[inline(always)]
    fn get(&self, id: ParamId) -> P {
        self.like.fill(|i| self.cases[i].values.get(id))
    }
    #[inline(always)]
    fn derived(&self, id: ParamId) -> P {
        self.like.fill(|i| self.cases[i].values.derived(id))
    }
}

struct Wide<'a, T> {
    cases: &'a [Case],
    out: &'a mut Vec<[f64; OUTPUTS]>,
    law: PhantomData<T>,
}

impl<T: Probe> Task for Wide<'_, T> {
    type Output = ();

    #[inline(always)]
    fn run<P: Pack>(self, token: P::Token) {
        let like = P::broadcast(token, 0.0);
        for cases in self.cases.chunks_exact(P::LANES) {
            let lanes = |f: &dyn Fn(&Ask<f64>) -> f64| like.fill(|i| f(&cases[i].ask));
            let ask = Ask {
                speed: lanes(&|ask| ask.speed),
                contact_state: ContactState {
                    direction: lanes(&|ask| ask.contact_state.direction),
                    x: lanes(&|ask| ask.contact_state.x),
                    sliding_distance: lanes(&|ask| ask.contact_state.sliding_distance),
                    drive: lanes(&|ask| ask.contact_state.drive),
                    t: lanes(&|ask| ask.contact_state.t),
                },
                states: [0, 1, 2, 3].map(|k| lanes(&|ask| ask.states[k])),
            };
            let all = T::outputs(&Lanes { like, cases }, &ask);
            self.out.extend((0..P::LANES).map(|i| all.map(|lane| lane.lane(i))));
        }
    }
}

/// A law's table entry with its functions for tests.
struct Tested {
    entry: &'static LawEntry,
    outputs: fn(&Case) -> [f64; OUTPUTS],
    wide: fn(Level, &[Case]) -> Vec<[f64; OUTPUTS]>,
}

fn tested<T: Probe>(info: LawInfo) -> Tested {
    Tested {
        entry: LawEntry::parse(info.name).unwrap(),
        outputs: |case| T::outputs(&case.values, &case.ask),
        wide: |level, cases| {
            let mut out = Vec::with_capacity(cases.len());
            run(level, Wide::<T> { cases, out: &mut out, law: PhantomData });
            out
        },
    }
}

macro_rules! laws {
    (@dry $law:ident) => { tested::<OfDry<$law>>($law::INFO) };
    (@smooth $law:ident) => { tested::<OfSmooth<$law>>($law::INFO) };
    (@bristle $law:ident) => { tested::<OfBristle<$law>>($law::INFO) };
    ($($kind:ident $file:ident::$law:ident),+ $(,)?) => { vec![$(laws!(@$kind $law)),+] };
}

fn laws() -> Vec<Tested> {
    locosweep::for_each_law!(laws)
}

impl Random {
    /// A value that contacts have.
    fn usual(&mut self, id: ParamId) -> f64 {
        use ParamId::*;
        match id {
            MuStatic => self.log(0.3, 1.0),
            MuCoulomb => self.log(0.05, 0.3),
            Mass => self.log(0.05, 5.0),
            Gravity => 9.81,
            SlopeDeg | CornerDeg => 60.0 * self.unit(),
            WallForce | Viscous | ViscousLoad | Quadratic | PowerDrag => self.log(0.01, 10.0),
            LoadFriction | RippleAmplitude => self.unit(),
            LoadExponent | PowerExponent => 0.5 + 1.5 * self.unit(),
            StribeckExponent | MixedExponent | DahlExponent => 0.5 + 1.5 * self.unit(),
            StribeckSpeed | MixedSpeed | TransitionSpeed | DampingSpeed => self.log(1e-3, 0.1),
            ModelicaDecay => self.log(1.0, 1e3),
            BristleStiffness => self.log(1e4, 1e6),
            BristleDamping => self.log(1.0, 1e3),
            ElasticShare => 0.9 * self.unit(),
            Attraction => self.log(1.0, 1e3),
            StiffnessSpread => 1.0 + 3.0 * self.unit(),
            DwellTime => self.log(0.01, 10.0),
            SkinRatio | PatchRatio => self.log(0.5, 3.0),
            RipplePhaseDeg => 360.0 * self.unit(),
            RippleLength | PatchLength | TrackLength => self.log(1e-3, 0.1),
            PatchStart => 0.1 * self.unit(),
            Track1 | Track2 | Track3 | Track4 | Track5 | Track6 => 2.0 * self.unit(),
            Buildup | BuildupRoot | Snowplough => self.log(0.1, 10.0),
            _ => id.param().default.unwrap_or(1.0),
        }
    }

    /// An end of the range, or anything inside.
    fn hostile(&mut self, id: ParamId) -> f64 {
        let (low, high) = id.param().range;
        let ends = [low, high, id.param().default.unwrap_or(1.0), self.usual(id)];
        let value = ends[(self.unit() * 4.0) as usize];
        if id.param().allows(value) { value } else { self.usual(id) }
    }

    fn values(&mut self, mut one: impl FnMut(&mut Self, ParamId) -> f64) -> Vec<(ParamId, f64)> {
        ParamId::all().map(|id| (id, one(self, id))).collect()
    }

    /// A question to a law whose elements slide after about `deflection`.
    fn ask(&mut self, deflection: f64) -> Ask<f64> {
        let speed = self.log(1e-5, 3.0) * self.sign();
        Ask {
            speed,
            contact_state: ContactState {
                direction: speed.signum(),
                x: 0.2 * (self.unit() - 0.3),
                sliding_distance: 0.1 * self.unit(),
                drive: 10.0 * (self.unit() - 0.5),
                t: 0.0,
            },
            states: [(); MOST_STATES].map(|()| 2.2 * (self.unit() - 0.5) * deflection),
        }
    }

    fn usual_case(&mut self, law: &LawEntry) -> Case {
        let values = Values::of(&self.values(Random::usual));
        let contact = Contact::of(&values);
        let mut ask = self.ask(contact.break_away / values.get(ParamId::BristleStiffness));
        if law.kind == Kind::Dry {
            ask.speed = ask.speed.abs();
        }
        if law.info.name == "gonthier" {
            ask.states[1] = self.unit();
        }
        Case { values, ask }
    }
}
