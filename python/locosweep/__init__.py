"""Parameter sweeps for rectilinear locomotion of snake, inchworm and in-pipe robots."""

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from locosweep._core import CancelToken as CancelToken
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
    from locosweep.grid import Grid as Grid
    from locosweep.registry import Parameter as Parameter
    from locosweep.registry import Quantity as Quantity
    from locosweep.registry import Status as Status
    from locosweep.registry import parameters as parameters
    from locosweep.registry import quantities as quantities
    from locosweep.registry import reductions as reductions
    from locosweep.result import Result as Result
    from locosweep.spec import Spec as Spec

    __version__: str

# Imported when first used: NumPy takes longer to import than most commands run.
_HOMES = {
    "CancelToken": "_core",
    "Cancelled": "errors",
    "DataFileError": "errors",
    "Grid": "grid",
    "InputError": "errors",
    "InternalError": "errors",
    "LocosweepError": "errors",
    "Parameter": "registry",
    "Quantity": "registry",
    "Result": "result",
    "Robot": "files",
    "SolveError": "errors",
    "Spec": "spec",
    "Status": "registry",
    "load": "files",
    "load_robot": "files",
    "parameters": "registry",
    "quantities": "registry",
    "reductions": "registry",
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
