//! Python's view of the core: convert, enter the door, convert back.

mod arrays;
mod door;
mod effects;
mod equation_error;
mod file_sizes;
mod fit;
mod friction_fit;
mod gait;
mod reality;
mod replay;
mod slides;
mod sweep;
mod tables;

use pyo3::prelude::pymodule;

#[pymodule]
mod _core {
    #[pymodule_export]
    use super::effects::{EffectFit, EffectRecord, EffectShape, effect_parameter_count, effects};
    #[pymodule_export]
    use super::equation_error::EquationError;
    #[pymodule_export]
    use super::file_sizes::other_sizes;
    #[pymodule_export]
    use super::fit::{Experiment, Misfit};
    #[pymodule_export]
    use super::friction_fit::{
        FrictionCandidate, FrictionData, FrictionOutcome, FrictionParameter, derivative, falls,
        imposed_force, noise, pressings, rank_fits, spikes,
    };
    #[pymodule_export]
    use super::gait::{
        GaitOutputRecord, GaitParameter, GaitRecord, GaitResult, gait_outputs, gait_parameters,
        gait_run, gaits,
    };
    #[pymodule_export]
    use super::reality::{reality_forms, reality_run, reality_source};
    #[pymodule_export]
    use super::replay::{Replay, motor_power, sensitivity_directions};
    #[pymodule_export]
    use super::slides::linear_response;
    #[pymodule_export]
    use super::sweep::{CancelToken, Sweep};
    #[pymodule_export]
    use super::tables::{
        Drive, Law, Parameter, Quantity, characteristic, drives, file_choices, file_keys, laws,
        methods, nearest, parameters, quantities, reductions, simd_level, simd_levels, statuses,
        threads_to_use, version,
    };
}
