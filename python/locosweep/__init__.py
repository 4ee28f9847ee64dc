"""Parameter sweeps for rectilinear locomotion of snake, inchworm and in-pipe robots."""

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from locosweep._core import CancelToken as CancelToken
    from locosweep.characteristic import FrictionFit as FrictionFit
    from locosweep.characteristic import fit_friction as fit_friction
    from locosweep.diagnosis.distinction import Distinction as Distinction
    from locosweep.diagnosis.distinction import distinguish as distinguish
    from locosweep.diagnosis.pipeline import diagnose as diagnose
    from locosweep.diagnosis.result import Diagnosis as Diagnosis
    from locosweep.engine import sweep as sweep
    from locosweep.errors import Cancelled as Cancelled
    from locosweep.errors import DataFileError as DataFileError
    from locosweep.errors import InputError as InputError
    from locosweep.errors import InternalError as InternalError
    from locosweep.errors import LocosweepError as LocosweepError
    from locosweep.errors import SolveError as SolveError
    from locosweep.files import Robot as Robot
    from locosweep.files import load as load
    from locosweep.files import load_robot as load_robot
    from locosweep.gait import GaitRun as GaitRun
    from locosweep.gait import gaits as gaits
    from locosweep.gait import run_gait as run_gait
    from locosweep.gait_spec import GaitSpec as GaitSpec
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
    from locosweep.replay import effects as effects
    from locosweep.result import Result as Result
    from locosweep.spec import Spec as Spec
    from locosweep.trajectories import Trajectories as Trajectories
    from locosweep.trajectories import simulate as simulate

    __version__: str

# Imported when first used: NumPy takes longer to import than most commands run.
_HOMES = {
    "CancelToken": "_core",
    "Cancelled": "errors",
    "DataFileError": "errors",
    "Diagnosis": "diagnosis.result",
    "Distinction": "diagnosis.distinction",
    "Drive": "registry",
    "FrictionFit": "characteristic",
    "GaitRun": "gait",
    "GaitSpec": "gait_spec",
    "Grid": "grid",
    "InputError": "errors",
    "InternalError": "errors",
    "Law": "registry",
    "LocosweepError": "errors",
    "Parameter": "registry",
    "Quantity": "registry",
    "Result": "result",
    "Robot": "files",
    "SolveError": "errors",
    "Spec": "spec",
    "Status": "registry",
    "Trajectories": "trajectories",
    "diagnose": "diagnosis.pipeline",
    "distinguish": "diagnosis.distinction",
    "drives": "registry",
    "effects": "replay",
    "fit_friction": "characteristic",
    "gaits": "gait",
    "laws": "registry",
    "load": "files",
    "load_robot": "files",
    "methods": "registry",
    "parameters": "registry",
    "quantities": "registry",
    "reductions": "registry",
    "run_gait": "gait",
    "simulate": "trajectories",
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
