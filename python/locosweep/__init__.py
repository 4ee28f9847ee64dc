"""Parameter sweeps for rectilinear locomotion of snake, inchworm and in-pipe robots."""

from locosweep._core import CancelToken as CancelToken
from locosweep._core import version as _version
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
from locosweep.engine import sweep as sweep

__version__: str = _version()
