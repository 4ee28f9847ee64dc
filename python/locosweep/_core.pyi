from _typeshed import Incomplete, SupportsGetItem
from typing import Any, SupportsFloat, SupportsIndex, final

__all__ = ["CancelToken", "Drive", "Effect", "Gait", "GaitOutput", "GaitParameter", "GaitResult", "Law", "Parameter", "Quantity", "Replay", "Sweep", "characteristic", "drives", "effect_parameter_count", "effects", "file_choices", "file_keys", "gait_outputs", "gait_parameters", "gait_run", "gaits", "laws", "methods", "parameters", "quantities", "reductions", "simd_level", "simd_levels", "statuses", "threads_to_use", "version"]

@final
class CancelToken:
    """
    Stops a running sweep from another thread.
    """
    def __new__(cls, /) -> CancelToken: ...
    def cancel(self, /) -> None:
        """
        Ask the sweep that holds this token to stop.
        """
    @property
    def done(self, /) -> int:
        """
        Evaluations finished so far.
        """

@final
class Drive:
    """
    A drive: the force that the actuator is told to give, over time.
    """
    def __repr__(self, /) -> str: ...
    @property
    def formula(self, /) -> str: ...
    @property
    def meaning(self, /) -> str: ...
    @property
    def name(self, /) -> str: ...
    @property
    def parameters(self, /) -> list[Parameter]: ...

@final
class Effect:
    """
    An effect that a nominal model of a measured run may lack.
    """
    def __repr__(self, /) -> str: ...
    @property
    def first(self, /) -> int:
        """
        Place of the first parameter among those of all effects.
        """
    @property
    def formula(self, /) -> str:
        """
        TeX.
        """
    @property
    def meaning(self, /) -> str: ...
    @property
    def name(self, /) -> str: ...
    @property
    def parameters(self, /) -> list[Parameter]: ...
    @property
    def site(self, /) -> str:
        """
        friction, drive, body, environment or sensor.
        """

@final
class Gait:
    """
    A gait: which segments move, phase by phase.
    """
    def __repr__(self, /) -> str: ...
    @property
    def meaning(self, /) -> str: ...
    @property
    def name(self, /) -> str: ...

@final
class GaitOutput:
    """
    A number that the run of a gait leaves.
    """
    def __repr__(self, /) -> str: ...
    @property
    def meaning(self, /) -> str: ...
    @property
    def name(self, /) -> str: ...
    @property
    def symbol(self, /) -> str: ...
    @property
    def unit(self, /) -> str: ...

@final
class GaitParameter:
    """
    A parameter of a run, where it stands in a gait file, and whether it belongs
    to the run, to each segment or to each joint.
    """
    @property
    def key(self, /) -> str: ...
    @property
    def parameter(self, /) -> Parameter: ...
    @property
    def part(self, /) -> str: ...
    @property
    def table(self, /) -> str: ...

@final
class GaitResult:
    """
    What a run leaves. The rows of `x`, `v` and `slide` have a number per segment,
    those of `force` one per joint, one row after another.
    """
    @property
    def force(self, /) -> Incomplete: ...
    @property
    def phase(self, /) -> Incomplete: ...
    @property
    def power(self, /) -> Incomplete: ...
    @property
    def propulsive(self, /) -> Incomplete: ...
    @property
    def results(self, /) -> list[tuple[str, float]]:
        """
        Name and value, in the order of `gait_outputs`.
        """
    @property
    def slide(self, /) -> Incomplete: ...
    @property
    def slip(self, /) -> Incomplete:
        """
        Way that each segment slides backward per cycle, m.
        """
    @property
    def status(self, /) -> int:
        """
        Code of the status; every result is NaN where it is not 0.
        """
    @property
    def t(self, /) -> Incomplete: ...
    @property
    def v(self, /) -> Incomplete: ...
    @property
    def x(self, /) -> Incomplete: ...

@final
class Law:
    """
    A friction law.
    """
    def __repr__(self, /) -> str: ...
    @property
    def exact(self, /) -> bool:
        """
        Motion between events is known in closed form.
        """
    @property
    def formula(self, /) -> str:
        """
        TeX, in the symbols of the parameters.
        """
    @property
    def kind(self, /) -> str:
        """
        dry, smooth or bristle.
        """
    @property
    def limits(self, /) -> str: ...
    @property
    def meaning(self, /) -> str: ...
    @property
    def name(self, /) -> str: ...
    @property
    def parameters(self, /) -> list[Parameter]: ...
    @property
    def source(self, /) -> str: ...

@final
class Parameter:
    """
    A parameter: what it is called, measured in, and which values it may take.
    """
    def __repr__(self, /) -> str: ...
    @property
    def allowed(self, /) -> str:
        """
        What is allowed, in words.
        """
    def check(self, /, value: SupportsFloat | SupportsIndex) -> float:
        """
        Raise InputError where the value is not allowed.
        """
    @property
    def default(self, /) -> float | None:
        """
        None where the user must give it.
        """
    @property
    def file_key(self, /) -> tuple[str, str] | None:
        """
        Table and key in a robot file, where it has one.
        """
    @property
    def integer(self, /) -> bool: ...
    @property
    def meaning(self, /) -> str: ...
    @property
    def name(self, /) -> str: ...
    @property
    def range(self, /) -> tuple[float, float]:
        """
        Smallest and largest value allowed.
        """
    @property
    def symbol(self, /) -> str: ...
    @property
    def unit(self, /) -> str: ...

@final
class Quantity:
    """
    A quantity that a sweep can compute.
    """
    def __repr__(self, /) -> str: ...
    @property
    def formula(self, /) -> str:
        """
        TeX, in the symbols of the parameters.
        """
    @property
    def integer(self, /) -> bool: ...
    @property
    def limits(self, /) -> str: ...
    @property
    def meaning(self, /) -> str: ...
    @property
    def name(self, /) -> str: ...
    @property
    def parameters(self, /) -> list[Parameter]: ...
    @property
    def simulated(self, /) -> bool:
        """
        Found by simulating a trajectory; law and drive then add parameters.
        """
    @property
    def source(self, /) -> str: ...
    @property
    def symbol(self, /) -> str: ...
    @property
    def unit(self, /) -> str: ...

@final
class Replay:
    """
    Runs of a drive, and the model that they are replayed through.
    """
    def __new__(cls, /, nominal: dict[str, SupportsFloat | SupportsIndex], runs: SupportsGetItem[int, tuple[Incomplete, Incomplete, SupportsFloat | SupportsIndex]]) -> Replay:
        """
        `nominal` has the keys segments, mass, gravity, viscous, slope_deg, gain,
        limit, and mu_coulomb or coulomb_force; for a pendulum also
        gravity_torque. Each run is (times in s from 0, drive, slope in degrees).
        """
    @property
    def lengths(self, /) -> list[int]:
        """
        Samples of each run.
        """
    def run(self, /, columns: SupportsGetItem[int, tuple[SupportsIndex, SupportsIndex, SupportsIndex, SupportsGetItem[int, str]]], values: Incomplete, shares: Incomplete, starts: Incomplete, threads: SupportsIndex, progress: Any | None = None, token: CancelToken | None = None) -> list[Incomplete]:
        """
        Replay columns, each (run, first sample, one beyond the last, effects).

        `values` holds the parameters of all effects, a row a column; `shares`
        factors on nominal mass, Coulomb level and gain, and the clock offset in
        s; `starts` position and speed at the window's start. Returns x, v, x_rear
        and force, all columns one after another.
        """

@final
class Sweep:
    """
    A checked grid and what to compute on it.
    """
    def __new__(cls, /, axes: SupportsGetItem[int, tuple[str, Incomplete]], fixed: SupportsGetItem[int, tuple[str, SupportsFloat | SupportsIndex]], requests: SupportsGetItem[int, tuple[str, str | None, SupportsFloat | SupportsIndex | None]], over: str | None = None, *, law: str | None = None, drive: str | None = None, gait: str | None = None, method: str | None = None, locate: bool = True, table: tuple[Incomplete, Incomplete] | None = None, motion: bool = False) -> Sweep:
        """
        `requests` are (quantity, reduction or None, q or None). Law, drive, method
        and table (times and values) count where a quantity is simulated; `motion`
        says that it is looked at itself, which prefers a method with dense output.
        """
    @property
    def axes(self, /) -> list[str]:
        """
        Names of the axes of the result, in order.
        """
    @property
    def cells(self, /) -> int:
        """
        Cells of each result.
        """
    @property
    def choice(self, /) -> tuple[str, str, str] | None:
        """
        Law, drive and method in use, where trajectories are simulated.
        """
    @property
    def evaluations(self, /) -> int:
        """
        How often a formula is evaluated.
        """
    @property
    def fixed(self, /) -> list[tuple[str, float]]:
        """
        Name and value of every parameter that is not an axis.
        """
    @property
    def gait(self, /) -> str | None:
        """
        Gait in use, where whole robots are simulated.
        """
    def run(self, /, outputs: SupportsGetItem[int, tuple[SupportsIndex, Any]], threads: SupportsIndex, chunk: SupportsIndex | None = None, progress: Any | None = None, token: CancelToken | None = None, level: str | None = None, fresh: bool = False) -> None:
        """
        Fill arrays: each output is (number of the request, array). An array of
        uint8 receives status codes. `fresh`: the arrays were never written to.
        """
    @property
    def shape(self, /) -> list[int]:
        """
        Shape of each result.
        """
    @property
    def simulates(self, /) -> bool:
        """
        Whether trajectories are simulated.
        """
    def trace(self, /, stations: Incomplete, threads: SupportsIndex, progress: Any | None = None, token: CancelToken | None = None) -> list[Incomplete]:
        """
        Position, speed, drive force and direction of sliding (0 at rest) of every
        cell at `stations` (shares of the duration): shape (cells, stations) each.
        """
    def working_bytes(self, /, threads: SupportsIndex) -> int:
        """
        Bytes needed beside the results.
        """

def characteristic(law: str, given: SupportsGetItem[int, tuple[str, SupportsFloat | SupportsIndex]], speeds: Incomplete) -> Incomplete:
    """
    Signed friction force of steady sliding at each speed; 0 at rest for smooth
    laws, else what friction holds against a forward push.
    """

def drives() -> list[Drive]:
    """
    All drives.
    """

def effect_parameter_count() -> int:
    """
    Number of the parameters of all effects.
    """

def effects() -> list[Effect]:
    """
    All effects, in the order of the registry.
    """

def file_choices() -> list[tuple[str, str, list[str]]]:
    """
    Table, key and allowed words of the keys of a robot file that take a word.
    """

def file_keys() -> list[Parameter]:
    """
    Keys of a robot file that are not parameters of the closed forms.
    """

def gait_outputs() -> list[GaitOutput]:
    """
    What the run of a gait leaves, in order.
    """

def gait_parameters() -> list[GaitParameter]:
    """
    What the run of a gait takes.
    """

def gait_run(gait: str, parameters: SupportsGetItem[int, tuple[str, SupportsFloat | SupportsIndex]], per_segment: SupportsGetItem[int, tuple[str, SupportsGetItem[int, SupportsFloat | SupportsIndex]]], per_joint: SupportsGetItem[int, tuple[str, SupportsGetItem[int, SupportsFloat | SupportsIndex]]], trace_every: SupportsFloat | SupportsIndex | None = None, token: CancelToken | None = None) -> GaitResult:
    """
    Runs a gait. `parameters` hold for all parts alike, `per_segment` and
    `per_joint` have a value for each; the motion is kept every `trace_every`
    seconds, and only its start where that is not given.
    """

def gaits() -> list[Gait]:
    """
    All gaits.
    """

def laws() -> list[Law]:
    """
    All friction laws.
    """

def methods() -> list[tuple[str, str]]:
    """
    Name and meaning of every method of simulation.
    """

def parameters() -> list[Parameter]:
    """
    All parameters of the closed forms.
    """

def quantities() -> list[Quantity]:
    """
    All quantities, in the order of their equations.
    """

def reductions() -> list[tuple[str, str]]:
    """
    Name and meaning of every reduction.
    """

def simd_level() -> str:
    """
    SIMD level in use.
    """

def simd_levels() -> list[str]:
    """
    SIMD levels that this machine runs, lowest first.
    """

def statuses() -> list[tuple[int, str, str]]:
    """
    Code, name and sentence of every status.
    """

def threads_to_use(asked: SupportsIndex | None = None) -> int:
    """
    Threads that a call would use.
    """

def version() -> str:
    """
    Version of the package.
    """
