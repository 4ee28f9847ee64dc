"""Parameter sweeps for rectilinear locomotion of snake, inchworm and in-pipe robots."""

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from locosweep._core import CancelToken as CancelToken
    from locosweep.diagnosis.design.distinguish import Distinction as Distinction
    from locosweep.diagnosis.design.distinguish import distinguish as distinguish
    from locosweep.diagnosis.pipeline import diagnose as diagnose
    from locosweep.diagnosis.report.result import Diagnosis as Diagnosis
    from locosweep.engine import sweep as sweep
    from locosweep.errors import Cancelled as Cancelled
    from locosweep.errors import DataFileError as DataFileError
    from locosweep.errors import InputError as InputError
    from locosweep.errors import InternalError as InternalError
    from locosweep.errors import LocosweepError as LocosweepError
    from locosweep.errors import SolveError as SolveError
    from locosweep.files.results import load as load
    from locosweep.files.robot import Robot as Robot
    from locosweep.files.robot import load_robot as load_robot
    from locosweep.friction_fit import FrictionFit as FrictionFit
    from locosweep.friction_fit import fit_friction as fit_friction
    from locosweep.grid import Grid as Grid
    from locosweep.registry import Drive as Drive
    from locosweep.registry import Law as Law
    from locosweep.registry import Parameter as Parameter
    from locosweep.registry import Quantity as Quantity
    from locosweep.registry import Status as Status
    from locosweep.registry import drives as drives
    from locosweep.registry import laws as laws
    from locosweep.registry import methods as methods
    from locosweep.registry import parameters as parameters
    from locosweep.registry import quantities as quantities
    from locosweep.registry import reductions as reductions
    from locosweep.result import Result as Result
    from locosweep.run_folder.run import Run as Run
    from locosweep.run_folder.run import open_run as open_run
    from locosweep.simulation.gait import GaitRun as GaitRun
    from locosweep.simulation.gait import gaits as gaits
    from locosweep.simulation.gait import run_gait as run_gait
    from locosweep.simulation.replay import effects as effects
    from locosweep.simulation.trajectories import Trajectories as Trajectories
    from locosweep.simulation.trajectories import simulate as simulate
    from locosweep.specs.gait import GaitSpec as GaitSpec
    from locosweep.specs.sweep import Spec as Spec
    from locosweep.uncertainty.propagation import Propagation as Propagation
    from locosweep.uncertainty.propagation import propagate as propagate
    from locosweep.uncertainty.sensitivity import Sensitivity as Sensitivity
    from locosweep.uncertainty.sensitivity import sensitivity as sensitivity
    from locosweep.virtual_grid.open_grid import open_grid as open_grid

    __version__: str

# Imported when first used: NumPy takes longer to import than most commands run.
_HOMES = {
    "CancelToken": "_core",
    "Cancelled": "errors",
    "DataFileError": "errors",
    "Diagnosis": "diagnosis.report.result",
    "Distinction": "diagnosis.design.distinguish",
    "Drive": "registry",
    "FrictionFit": "friction_fit",
    "GaitRun": "simulation.gait",
    "GaitSpec": "specs.gait",
    "Grid": "grid",
    "InputError": "errors",
    "InternalError": "errors",
    "Law": "registry",
    "LocosweepError": "errors",
    "Parameter": "registry",
    "Propagation": "uncertainty.propagation",
    "Quantity": "registry",
    "Result": "result",
    "Robot": "files.robot",
    "Run": "run_folder.run",
    "Sensitivity": "uncertainty.sensitivity",
    "SolveError": "errors",
    "Spec": "specs.sweep",
    "Status": "registry",
    "Trajectories": "simulation.trajectories",
    "diagnose": "diagnosis.pipeline",
    "distinguish": "diagnosis.design.distinguish",
    "drives": "registry",
    "effects": "simulation.replay",
    "fit_friction": "friction_fit",
    "gaits": "simulation.gait",
    "laws": "registry",
    "load": "files.results",
    "load_robot": "files.robot",
    "methods": "registry",
    "open_grid": "virtual_grid.open_grid",
    "open_run": "run_folder.run",
    "parameters": "registry",
    "propagate": "uncertainty.propagation",
    "quantities": "registry",
    "reductions": "registry",
    "run_gait": "simulation.gait",
    "sensitivity": "uncertainty.sensitivity",
    "simulate": "simulation.trajectories",
    "sweep": "engine",
}

__all__ = [*_HOMES, "__version__"]


def __getattr__(name: str) -> object:
    value: object
    if name == "__version__":
        value = import_module("locosweep._core").version()
    elif name in _HOMES:
        value = getattr(import_module(f"locosweep.{_HOMES[name]}"), name)
    else:
        raise AttributeError(f"module 'locosweep' has no attribute '{name}'")
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
