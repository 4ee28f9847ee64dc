//! EFFECT REGISTRY: what a nominal model of a measured run may lack, a row an
//! effect. A new effect is its row here and its formula where `Plant` takes it up.
//! Names, laws and parameters are those of the contract that files and reports use.

use super::row::Need::{Body, RearSensor, Slope};
use super::row::{
    EFFECT, EITHER_SIGN, EffectInfo, EffectParam, LevelForm, Magnitude, Off, PARAM, POSITIVE,
    SHAPE, Shape, Shown, Site, Variable, param,
};

macro_rules! effects {
    ($($id:ident { $($row:tt)+ })+) => {
        #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
        #[repr(usize)]
        pub enum Effect { $($id),+ }

        impl Effect {
            pub const ALL: &'static [Effect] = &[$(Effect::$id),+];
        }

        /// In the order of `Effect::ALL`.
        pub const EFFECTS: &[EffectInfo] = &[$(EffectInfo { $($row)+, ..EFFECT }),+];
    };
}

const INF: f64 = f64::INFINITY;
const STIFF: Off = Off::At(INF);

/// Dry friction that is 0 makes bristles infinitely stiff, steps of no length: a
/// thousandth of the level is always left.
const MOST_LOST: &str = "-(1 - 0.001)";
const LEAST_LEFT: &str = "0.001 * level";
/// Lags are looked for from a third of a sample to a tenth of a run, also in windows: a window
/// knows from the samples before it what stands behind a lag.
const LAGS: &str = "max(interval * 0.3, duration * [5e-4, 2e-3, 5e-3, 0.01, 0.03, 0.1])";
/// Delays, of either sign, are looked for up to a tenth of what is replayed at once.
const DELAYS: &str =
    "both(max(interval * 0.3, replayed * [5e-4, 2e-3, 5e-3, 0.01, 0.03, 0.1])) / (0.1 * replayed)";
const SLOWLY: Shape = Shape {
    name: "T",
    starts: "duration * [0.1, 0.6, 4]",
    low: "1e-2 * duration",
    high: "20 * duration",
    ..SHAPE
};
const DAMPING: Shape = Shape { name: "zeta", starts: "[0.3]", low: "1e-3", high: "3", ..SHAPE };
/// Less than no viscosity at all would be a motor.
const LEAST_DRAG: &str = "-min(1, viscous / (force / speed))";
/// A lighter mass on the drive's side, in that of the head, is stiff.
const LIGHTEST: f64 = 1e-2;
const SIDE: &str = "max(u, 0.01) * mass";
const RIVAL_SIDE: &str = "mass * share * min(max(s / 0.1, 0.02), 1)";
const LATE: EffectParam = EffectParam {
    unit: "0.1 * replayed",
    starts: DELAYS,
    low: "-0.3 * replayed",
    high: "0.3 * replayed",
    at: "u * duration",
    ..PARAM
};
const OVER_TIME: EffectParam = EffectParam {
    param: param("T", "T", "s", (1e-9, 1e9), ""),
    off: Off::Never,
    log: true,
    starts: "duration * [0.03, 0.1, 0.3, 1, 3]",
    low: "0.01 * duration",
    high: "10 * duration",
    at: "T",
    rival: "share * duration",
    ..PARAM
};
const SIDE_MASS: EffectParam = EffectParam {
    param: param("m_d", "m_d", "kg", (1e-9, 1e9), "mass on the drive's side"),
    off: Off::Never,
    log: true,
    low: "1e-3 * mass",
    high: "10 * mass",
    at: SIDE,
    rival: RIVAL_SIDE,
    judged: false,
    ..PARAM
};
const GRIP: EffectParam =
    EffectParam { log: true, low: "1e-3 * force / grip", high: "3 * force / grip", ..PARAM };

effects! {
    ViscousFriction {
        name: "viscous_friction",
        formula: r"F_f \mathrel{+}= c v",
        meaning: "friction that grows with speed",
        variable: Some(Variable::Speed),
        monotone: true,
        magnitude: Magnitude { low: LEAST_DRAG, ..EFFECT.magnitude },
        params: &[EffectParam {
            param: param("c", "c", "N s/m", (-1e9, 1e9), "viscous coefficient beside the nominal one"),
            unit: "force / speed",
            low: "-viscous",
            at: "u * (force / speed)",
            rival: "s * (level / speed)",
            ..PARAM
        }]
    }
    QuadraticDrag {
        name: "quadratic_drag",
        work: 2.0,
        formula: r"F_f \mathrel{+}= c_2 v|v|",
        meaning: "drag that grows with the square of speed",
        variable: Some(Variable::Speed),
        monotone: true,
        magnitude: Magnitude { low: "0", ..EFFECT.magnitude },
        params: &[EffectParam {
            param: param("c2", "c_2", "N s^2/m^2", (-1e9, 1e9), "quadratic coefficient"),
            unit: "force / speed / speed",
            starts: POSITIVE,
            at: "u * (force / speed / speed)",
            rival: "s * (level / speed) / speed",
            ..PARAM
        }]
    }
    StribeckFriction {
        name: "stribeck_friction",
        work: 10.0,
        formula: r"F_f \mathrel{+}= (F_s - F_c)\,e^{-|v/v_s|^\delta}\,\mathrm{sgn}\,v,\ \text{break-away at } F_s",
        meaning: "friction falls from a higher level at rest",
        variable: Some(Variable::Speed),
        contains: &["coulomb_error"],
        magnitude: Magnitude {
            low: "0",
            shapes: &[
                Shape {
                    name: "v_s", starts: "speed * [0.01, 0.1, 0.4]", low: "1e-4 * speed",
                    high: "10 * speed", ..SHAPE
                },
                Shape { name: "delta", low: "0.5", high: "2.5", ..SHAPE },
            ],
            ..EFFECT.magnitude
        },
        over: &[("share", "[0.03, 0.1, 0.35]"), ("delta", "[1, 2]")],
        params: &[
            // Friction that rises from rest on is another cause.
            EffectParam {
                param: param("F_s", "F_s", "N", (0.0, 1e9), "break-away level, at the nominal slope"),
                off: Off::Coulomb,
                unit: "level",
                starts: "[1.03, 1.1, 1.4]",
                low: "least_level",
                high: "20 * force",
                at: "level * (1 + u)",
                rival: "level * max(1 + s, 0.05)",
                ..PARAM
            },
            EffectParam {
                param: param("v_s", "v_s", "m/s", (1e-9, 1e6), "speed over which it falls"),
                off: Off::Never,
                log: true,
                starts: "speed * [0.003, 0.01, 0.03, 0.1, 0.3, 1]",
                low: "1e-4 * speed",
                high: "10 * speed",
                at: "v_s",
                rival: "share * speed",
                ..PARAM
            },
            EffectParam {
                param: param("delta", r"\delta", "1", (0.1, 4.0), "exponent of the fall"),
                off: Off::Never,
                log: true,
                starts: "[1.2]",
                low: "0.5",
                high: "2.5",
                at: "delta",
                rival: "delta",
                judged: false,
                ..PARAM
            },
        ]
    }
    PreslidingCompliance {
        name: "presliding_compliance",
        work: 7.0,
        formula: r"\dot z = v - \sigma_0 |v| z/g,\ F_f = \sigma_0 z + \sigma_1 \dot z",
        meaning: "the contact gives way elastically before it slides",
        variable: Some(Variable::Turned),
        magnitude: Magnitude { low: "0", shapes: &[DAMPING], ..EFFECT.magnitude },
        one_sided: true,
        over: &[("zeta", "[0.3, 1]")],
        params: &[
            EffectParam {
                param: param("sigma0", r"\sigma_0", "N/m", (1e-3, INF), "stiffness of the contact"),
                off: STIFF,
                log: true,
                starts: "level / (travel * [1e-4, 1e-3, 1e-2, 1e-1])",
                low: "level / (10 * travel)",
                high: "level / (1e-6 * travel)",
                at: "level / (max(u, 1e-12) * travel)",
                rival: "level / (max(s, 1e-4) * travel)",
                ..PARAM
            },
            EffectParam {
                param: param("sigma1", r"\sigma_1", "N s/m", (0.0, 1e9), "damping of the contact"),
                off: Off::Never,
                log: true,
                starts: "[0.01, 0.5]",
                composed: Some("value * critical(sigma0, mass)"),
                low: "1e-4 * critical(level / travel, mass)",
                high: "3 * critical(level / (1e-6 * travel), mass)",
                at: "zeta * critical(sigma0, mass)",
                rival: "zeta * critical(sigma0, mass)",
                judged: false,
                ..PARAM
            },
        ]
    }
    DirectionDependentFriction {
        name: "direction_dependent_friction",
        formula: r"F_c = F_{c+} \text{ for } v > 0,\ F_{c-} \text{ for } v < 0",
        meaning: "friction differs between forward and backward",
        variable: Some(Variable::Speed),
        shown: Shown::BothWays,
        contains: &["coulomb_error", "slope_error"],
        magnitude: Magnitude {
            high: "1",
            shapes: &[Shape {
                name: "common", starts: "[0]", low: "-1", high: "10", log: false, step: 1e-3,
            }],
            ..EFFECT.magnitude
        },
        spanned: &[("forward", "[1, 0]")],
        params: &[
            EffectParam {
                param: param("F_c_forward", "F_{c+}", "N", (0.0, 1e9), "Coulomb level forward, at the nominal slope"),
                off: Off::Coulomb,
                unit: "level",
                starts: "[0.8, 0.95, 1.05, 1.2]",
                low: LEAST_LEFT,
                at: "max(0, level * (1 + common + u))",
                rival: "level * max(1 + forward * s, 0)",
                ..PARAM
            },
            EffectParam {
                param: param("F_c_backward", "F_{c-}", "N", (0.0, 1e9), "Coulomb level backward, at the nominal slope"),
                off: Off::Coulomb,
                unit: "level",
                starts: "[0.8, 0.95, 1.05, 1.2]",
                low: LEAST_LEFT,
                at: "max(0, level * (1 + common - u))",
                rival: "level * max(1 + (1 - forward) * s, 0)",
                ..PARAM
            },
        ]
    }
    PositionDependentFriction {
        name: "position_dependent_friction",
        work: 8.0,
        formula: r"F_c\,(1 + a\sin(2\pi x/L + p))",
        meaning: "friction varies along the track",
        variable: Some(Variable::ContactState),
        contains: &["coulomb_error"],
        magnitude: Magnitude {
            low: "0",
            high: "1",
            shapes: &[
                Shape {
                    name: "L", starts: "travel * [0.08, 0.2, 0.5, 1.2]", low: "0.02 * travel",
                    high: "10 * travel", ..SHAPE
                },
                Shape {
                    name: "p", starts: "[0, 1.57, 3.14, 4.71]", low: "-100", high: "100",
                    log: false, ..SHAPE
                },
            ],
            ..EFFECT.magnitude
        },
        // From short ones to a slope.
        over: &[("L", "travel * geomspace(0.2, 7, 13)")],
        spanned: &[("p", "[0, 0.5 * pi]")],
        refined: Some("L"),
        params: &[
            EffectParam {
                param: param("a", "a", "1", (-1.0, 1.0), "relative amplitude"),
                starts: "[0.05]",
                low: MOST_LOST,
                high: "1 - 0.001",
                rival: "min(max(s, -0.95), 0.95)",
                ..PARAM
            },
            EffectParam {
                param: param("L", "L", "m", (1e-6, 1e6), "period along the track"),
                off: Off::Never,
                log: true,
                starts: "travel * geomspace(0.04, 3, 20)",
                low: "0.02 * travel",
                high: "10 * travel",
                at: "L",
                rival: "L",
                ..PARAM
            },
            EffectParam {
                param: param("p", "p", "rad", (-100.0, 100.0), "phase at the column's zero"),
                off: Off::Never,
                starts: "[0, 1.57, 3.14, 4.71]",
                low: "-100",
                high: "100",
                at: "p",
                rival: "p",
                judged: false,
                ..PARAM
            },
        ]
    }
    LoadDependentFriction {
        name: "load_dependent_friction",
        formula: r"F_f \mathrel{+}= \mu_l |F_d|\,\mathrm{sgn}\,v",
        meaning: "friction grows with the drive force",
        variable: Some(Variable::Load),
        monotone: true,
        magnitude: Magnitude { low: "-0.9", ..EFFECT.magnitude },
        params: &[EffectParam {
            param: param("mu_l", r"\mu_l", "1", (-1.0, 1e3), "friction per newton of drive force"),
            low: "-1",
            high: "10",
            ..PARAM
        }]
    }
    FrictionDrift {
        name: "friction_drift",
        formula: r"F_c\,(1 + a(1 - e^{-t/T}))",
        meaning: "friction changes over the time of a run",
        variable: Some(Variable::Time),
        monotone: true,
        // What changes at once is as well a mass that is picked up.
        continuous: true,
        contains: &["coulomb_error"],
        magnitude: Magnitude { shapes: &[SLOWLY], ..EFFECT.magnitude },
        over: &[("share", "[0.15, 0.5, 1.5]")],
        params: &[
            EffectParam {
                param: param("a", "a", "1", (-1.0, 1e3), "relative change in the end"),
                starts: "both([0.01, 0.1, 0.3])",
                low: MOST_LOST,
                high: "10",
                rival: "min(max(s, -0.95), 0.95)",
                ..PARAM
            },
            EffectParam {
                param: param("T", "T", "s", (1e-9, 1e9), "time over which it changes"),
                ..OVER_TIME
            },
        ]
    }
    LubricantBuildup {
        name: "lubricant_buildup",
        work: 2.0,
        formula: r"F_f \mathrel{+}= k_b s,\ v > 0",
        meaning: "lubricant piles up before the segment as it moves forward",
        variable: Some(Variable::Swept),
        monotone: true,
        shown: Shown::Forward,
        params: &[EffectParam {
            param: param("k_b", "k_b", "N/m", (-1e6, 1e9), "resistance per distance swept since the last rest or turn"),
            unit: "force / travel",
            starts: POSITIVE,
            at: "u * (force / travel)",
            rival: "s * level / travel",
            ..PARAM
        }]
    }
    DriveSaturation {
        name: "drive_saturation",
        site: Site::Drive,
        formula: r"|F_d| \le F_\mathrm{max}",
        meaning: "the drive gives no more than a limit",
        variable: Some(Variable::Drive),
        monotone: true,
        magnitude: Magnitude { low: "0", high: "1", ..EFFECT.magnitude },
        one_sided: true,
        params: &[EffectParam {
            param: param("F_max", r"F_\mathrm{max}", "N", (0.0, INF), "largest drive force"),
            off: STIFF,
            log: true,
            // Of several runs, the strongest one alone may reach the limit, and just its peaks: below
            // the next start a limit takes much more off, above the peak it takes nothing.
            starts: "peak * [0.3, 0.45, 0.6, 0.75, 0.85, 0.92, 0.96, 0.98, 0.99, 0.995, 0.998]",
            low: "0.02 * force",
            high: "max(2 * force, peak)",
            at: "force * (1 - u)",
            rival: "force * max(1 - s, 0.05)",
            ..PARAM
        }]
    }
    DriveLag {
        name: "drive_lag",
        work: 2.0,
        site: Site::Drive,
        formula: r"T\dot F_d + F_d = \mathrm{gain}\cdot\mathrm{drive}",
        meaning: "the drive force follows its command slowly",
        variable: Some(Variable::History),
        magnitude: Magnitude { low: "0", high: "1", ..EFFECT.magnitude },
        one_sided: true,
        params: &[EffectParam {
            param: param("T", "T", "s", (0.0, 1e6), "time constant"),
            log: true,
            starts: LAGS,
            low: "0.003 * interval",
            high: "duration",
            at: "u * duration",
            rival: "max(s, 1e-5)",
            ..PARAM
        }]
    }
    DriveDelay {
        name: "drive_delay",
        site: Site::Drive,
        formula: r"F_d(t) = \mathrm{gain}\cdot\mathrm{drive}(t - T)",
        meaning: "the drive force follows its command late",
        variable: Some(Variable::History),
        further: Some(Variable::Change),
        error_of: Some("clock"),
        magnitude: Magnitude { low: "0", high: "0.3", ..EFFECT.magnitude },
        one_sided: true,
        params: &[EffectParam { param: param("T", "T", "s", (-1e3, 1e6), "delay"), ..LATE }]
    }
    DriveDeadzone {
        name: "drive_deadzone",
        site: Site::Drive,
        formula: r"F_d = 0 \text{ below } d, \text{ else shortened by } d",
        meaning: "small commands give no force",
        variable: Some(Variable::Drive),
        magnitude: Magnitude { low: "0", high: "1", ..EFFECT.magnitude },
        one_sided: true,
        params: &[EffectParam {
            param: param("d", "d", "N", (0.0, 1e9), "half width of the dead zone"),
            unit: "force",
            starts: "[0.003, 0.01, 0.03, 0.1, 0.3, 0.5]",
            high: "force",
            at: "u * force",
            rival: "s * level",
            ..PARAM
        }]
    }
    DriveGainError {
        name: "drive_gain_error",
        site: Site::Drive,
        formula: r"F_d = (1 + e)\,\mathrm{gain}\cdot\mathrm{drive}",
        meaning: "the drive gives more or less than commanded, in proportion",
        variable: Some(Variable::Drive),
        error_of: Some("gain"),
        params: &[EffectParam {
            param: param("e", "e", "1", (-1.0, 1e3), "relative error of the gain"),
            low: "-0.95",
            high: "10",
            ..PARAM
        }]
    }
    BackEmf {
        name: "back_emf",
        site: Site::Drive,
        formula: r"F_d = \mathrm{gain}\cdot\mathrm{drive} - k_e v",
        meaning: "the drive gives less the faster it moves",
        variable: Some(Variable::Speed),
        monotone: true,
        magnitude: Magnitude { low: LEAST_DRAG, ..EFFECT.magnitude },
        params: &[EffectParam {
            param: param("k_e", "k_e", "N s/m", (-1e9, 1e9), "loss of force per speed"),
            unit: "force / speed",
            low: "-viscous",
            at: "u * (force / speed)",
            rival: "s * (level / speed)",
            ..PARAM
        }]
    }
    SupplySag {
        name: "supply_sag",
        site: Site::Drive,
        formula: r"\mathrm{gain}\,(1 - a(1 - e^{-t/T}))",
        meaning: "the supply sags over the time of a run",
        variable: Some(Variable::Sag),
        monotone: true,
        // What falls at once is as well a mass that is picked up.
        continuous: true,
        contains: &["drive_gain_error"],
        magnitude: Magnitude { high: "1", shapes: &[SLOWLY], ..EFFECT.magnitude },
        over: &[("share", "[0.15, 0.5, 1.5]")],
        params: &[
            EffectParam {
                param: param("a", "a", "1", (-1e3, 1.0), "relative loss in the end"),
                starts: "both([0.01, 0.1, 0.3])",
                low: "-5",
                high: "1",
                rival: "min(max(s, -0.95), 0.95)",
                ..PARAM
            },
            EffectParam {
                param: param("T", "T", "s", (1e-9, 1e9), "time over which it sags"),
                ..OVER_TIME
            },
        ]
    }
    // Play and spring show by the mass behind them: without it they change nothing.
    TransmissionBacklash {
        name: "transmission_backlash",
        work: 25.0,
        site: Site::Drive,
        formula: r"m_d \ddot x_d = F_d - F_c,\ F_c = 0 \text{ while } |x_d - x| < b",
        meaning: "play between drive and head",
        variable: Some(Variable::History),
        excludes: &["transmission_compliance"],
        magnitude: Magnitude {
            low: "0",
            high: "3",
            least: LIGHTEST,
            shapes: &[Shape {
                name: "b", starts: "travel * [1e-3, 2e-2]", low: "1e-6 * travel", high: "travel",
                ..SHAPE
            }],
        },
        one_sided: true,
        over: &[("share", "[0.05, 0.25]")],
        params: &[
            EffectParam {
                param: param("b", "b", "m", (0.0, 1e6), "half the gap"),
                off: Off::Never,
                log: true,
                starts: "travel * [1e-5, 1e-3, 1e-2, 0.1]",
                low: "1e-8 * travel",
                high: "travel",
                at: "b",
                rival: "s * travel",
                ..PARAM
            },
            EffectParam { starts: "mass * [0.005, 0.03, 0.2, 1]", ..SIDE_MASS },
        ]
    }
    TransmissionCompliance {
        name: "transmission_compliance",
        work: 20.0,
        site: Site::Drive,
        formula: r"m_d \ddot x_d = F_d - F_s,\ F_s = k (x_d - x) + d (\dot x_d - v)",
        meaning: "a spring between drive and head",
        variable: Some(Variable::History),
        excludes: &["transmission_backlash"],
        magnitude: Magnitude {
            low: "0",
            high: "3",
            least: LIGHTEST,
            shapes: &[
                Shape {
                    name: "k", starts: "mass * (2 * pi * [4, 15]) ** 2", low: "mass",
                    high: "mass * 1e5", ..SHAPE
                },
                DAMPING,
            ],
        },
        one_sided: true,
        over: &[("share", "[0.05, 0.25]")],
        params: &[
            EffectParam {
                param: param("k", "k", "N/m", (1e-6, INF), "stiffness"),
                off: STIFF,
                log: true,
                // The last ones ring within a sample of most sensors: rigid but for the mass behind them.
                starts: "mass * (2 * pi * [2, 5, 12, 30, 100, 300]) ** 2",
                low: "mass",
                high: "mass * 1e6",
                // A spring that rings within a sample is rigid in windows.
                windows: Some(("min(mass, 0.1 * mass / interval ** 2)", "mass / interval ** 2")),
                at: "k",
                rival: "force / (max(s, 1e-3) * travel)",
                ..PARAM
            },
            EffectParam {
                param: param("d", "d", "N s/m", (0.0, 1e9), "damping"),
                off: Off::Never,
                log: true,
                starts: "[0.1, 0.6]",
                composed: Some("value * critical(k, m_d)"),
                low: "1e-4 * critical(mass, mass)",
                high: "3 * critical(mass * 1e6, mass)",
                windows: Some(("1e-3 * mass / replayed", "mass / interval")),
                at: "zeta * critical(k, m_d)",
                rival: "0.2 * critical(k, m_d * mass / (m_d + mass))",
                judged: false,
                ..PARAM
            },
            EffectParam {
                starts: "mass * [0.01, 0.1, 0.7]",
                windows: Some(("0.1 * mass", "10 * mass")),
                ..SIDE_MASS
            },
        ]
    }
    SlopeError {
        name: "slope_error",
        site: Site::Environment,
        formula: r"\alpha \to \alpha + \Delta\alpha",
        meaning: "the ground is steeper or flatter than assumed",
        variable: Some(Variable::Terrain),
        steady: true,
        needs: &[Slope],
        magnitude: Magnitude { high: "1", ..EFFECT.magnitude },
        params: &[EffectParam {
            param: param("d_alpha_deg", r"\Delta\alpha", "deg", (-90.0, 90.0), "error of the slope"),
            unit: "degrees(min(1, level / weight))",
            low: "-45",
            high: "45",
            at: "u * degrees(min(1, level / weight))",
            rival: "min(max(20 * s, -60), 60)",
            ..PARAM
        }]
    }
    PayloadMass {
        name: "payload_mass",
        site: Site::Body,
        formula: r"m \to m + \Delta m",
        meaning: "the head carries more or less mass than assumed",
        error_of: Some("mass"),
        lowers_level: true,
        magnitude: Magnitude { low: "-0.95", ..EFFECT.magnitude },
        params: &[EffectParam {
            param: param("dm", r"\Delta m", "kg", (-1e9, 1e9), "error of the mass"),
            unit: "mass",
            starts: "[-0.3, -0.1, -0.03, -0.01, -0.003, 0.003, 0.01, 0.03, 0.1, 0.3, 1]",
            low: "-0.95 * mass",
            high: "20 * mass",
            at: "u * mass",
            rival: "mass * max(s, -0.9)",
            ..PARAM
        }]
    }
    CoulombError {
        name: "coulomb_error",
        formula: r"\mu_C \to \mu_C + \Delta\mu",
        meaning: "friction is higher or lower than assumed",
        error_of: Some("mu_coulomb"),
        lowers_level: true,
        params: &[
            EffectParam {
                param: param("d_mu", r"\Delta\mu", "1", (-1e3, 1e3), "error of the coefficient"),
                only: Some(LevelForm::Coefficient),
                unit: "level / weight",
                low: "-(1 - 0.001) * nominal_level / weight",
                at: "u * (level / weight)",
                rival: "s * mu",
                ..PARAM
            },
            EffectParam {
                param: param("d_force", r"\Delta F", "N", (-1e9, 1e9), "the same as a force, where the model gives coulomb_force"),
                only: Some(LevelForm::Force),
                unit: "level",
                low: "0.001 * nominal_level - nominal_level",
                at: "u * level",
                rival: "s * level",
                ..PARAM
            },
        ]
    }
    AnchorSlip {
        name: "anchor_slip",
        site: Site::Body,
        formula: r"(N-1) m \dot v_r = -F_d - F_r - (N-1) m g \sin\alpha",
        meaning: "the anchored body slides where the drive exceeds its grip",
        needs: &[Body, RearSensor],
        shown: Shown::AtRest,
        keep: Some("mu_coulomb <= mu_static * 1.0001"),
        magnitude: Magnitude {
            low: "0",
            high: "0.99",
            shapes: &[Shape { name: "ratio", starts: "[0.9]", low: "0.1", ..SHAPE }],
            ..EFFECT.magnitude
        },
        one_sided: true,
        params: &[
            EffectParam {
                param: param("mu_static", r"\mu_{S,r}", "1", (0.0, INF), "static friction coefficient of the body"),
                off: STIFF,
                starts: "force / grip * [0.3, 0.5, 0.7, 0.85, 0.97]",
                at: "force / grip * (1 - u)",
                rival: "force * max(1 - s, 0.05) / grip",
                ..GRIP
            },
            EffectParam {
                param: param("mu_coulomb", r"\mu_{C,r}", "1", (0.0, 1e3), "Coulomb friction coefficient of the body"),
                off: Off::Never,
                starts: "force / grip * [0.3, 0.5, 0.7, 0.85, 0.95]",
                at: "mu_static * ratio",
                rival: "0.9 * mu_static",
                ..GRIP
            },
        ]
    }
    SensorScale {
        name: "sensor_scale",
        site: Site::Sensor,
        formula: r"x \to x_0 + (1 + e)(x - x_0)",
        meaning: "the position is read too long or too short",
        variable: Some(Variable::Reading),
        magnitude: Magnitude { low: "-0.95", ..EFFECT.magnitude },
        params: &[EffectParam {
            param: param("e", "e", "1", (-1.0, 1e3), "relative error of the scale"),
            low: "-0.95",
            high: "10",
            ..PARAM
        }]
    }
    SensorDrift {
        name: "sensor_drift",
        site: Site::Sensor,
        formula: r"x \to x + b t",
        meaning: "the position reading drifts",
        variable: Some(Variable::Clock),
        magnitude: Magnitude { low: "-10", ..EFFECT.magnitude },
        params: &[EffectParam {
            param: param("b", "b", "m/s", (-1e6, 1e6), "drift"),
            unit: "travel / duration",
            starts: EITHER_SIGN,
            low: "-inf",
            at: "u * (travel / duration)",
            rival: "s * travel / duration",
            ..PARAM
        }]
    }
    SensorDelay {
        name: "sensor_delay",
        site: Site::Sensor,
        formula: r"x \to x(t - T)",
        meaning: "the position is read late",
        variable: Some(Variable::Late),
        // What changes at once where the motion turns is play of the sensor.
        continuous: true,
        magnitude: Magnitude { low: "0", high: "0.3", ..EFFECT.magnitude },
        one_sided: true,
        params: &[EffectParam { param: param("T", "T", "s", (-1e3, 1e6), "delay"), ..LATE }]
    }
}
