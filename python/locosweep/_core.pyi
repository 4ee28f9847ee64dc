from _typeshed import Incomplete, SupportsGetItem
from os import PathLike
from typing import Any, SupportsFloat, SupportsIndex, final

__all__ = ["CancelToken", "Drive", "Effect", "EffectFit", "EffectShape", "EquationError", "Experiment", "FrictionCandidate", "FrictionData", "FrictionOutcome", "FrictionParameter", "Gait", "GaitOutput", "GaitParameter", "GaitResult", "Law", "Misfit", "Parameter", "Quantity", "Replay", "Sweep", "characteristic", "derivative", "drives", "effect_parameter_count", "effects", "falls", "file_choices", "file_keys", "gait_outputs", "gait_parameters", "gait_run", "gaits", "imposed_force", "laws", "linear_response", "methods", "motor_power", "nearest", "noise", "other_sizes", "parameters", "pressings", "quantities", "rank_fits", "reality_forms", "reality_run", "reality_source", "reductions", "sensitivity_directions", "simd_level", "simd_levels", "spikes", "statuses", "threads_to_use", "version"]

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
    def contains(self, /) -> list[str]:
        """
        Effects with fewer parameters that it contains as a limit.
        """
    @property
    def continuous(self, /) -> bool:
        """
        Whether its law in `variable` never jumps, by whatever formula.
        """
    @property
    def drawn(self, /) -> bool:
        """
        Whether the blind check's reality has it.
        """
    @property
    def error_of(self, /) -> str | None:
        """
        Value of [uncertainty] that it is an error of.
        """
    @property
    def excludes(self, /) -> list[str]:
        """
        Effects that stand in its place: a model has one of them.
        """
    @property
    def first(self, /) -> int:
        """
        Place of the first parameter among those of all effects.
        """
    @property
    def fits(self, /) -> list[EffectFit]:
        """
        How fits treat each parameter.
        """
    @property
    def formula(self, /) -> str:
        """
        TeX.
        """
    @property
    def further(self, /) -> str | None:
        """
        A second variable of another law, which no other effect follows.
        """
    @property
    def keep(self, /) -> str | None:
        """
        Formula that starts must fulfil.
        """
    @property
    def least(self, /) -> float:
        """
        Magnitude below which an integrator resolves no more than the nominal model.
        """
    @property
    def levels(self, /) -> list[str]:
        """
        Names of those that stand beside the nominal Coulomb level.
        """
    @property
    def lowers_level(self, /) -> bool:
        """
        Beside it friction at rest may lie below the nominal Coulomb level.
        """
    @property
    def magnitude(self, /) -> tuple[str, str]:
        """
        Formulas of the smallest and the largest signed magnitude.
        """
    @property
    def meaning(self, /) -> str: ...
    @property
    def monotone(self, /) -> bool:
        """
        Whether its law in `variable` rises all along, or falls, by whatever formula.
        """
    @property
    def name(self, /) -> str: ...
    @property
    def needs(self, /) -> list[str]:
        """
        What a rig must have for it: body, rear_sensor, slope.
        """
    @property
    def one_sided(self, /) -> bool:
        """
        As a rival in the blind check it has strengths of one sign only.
        """
    @property
    def over(self, /) -> list[tuple[str, str]]:
        """
        Numbers of a rival of which every value is tried: names and formulas.
        """
    @property
    def parameters(self, /) -> list[Parameter]: ...
    @property
    def refined(self, /) -> str | None:
        """
        The number of `over` that is looked at between its values, too.
        """
    @property
    def shapes(self, /) -> list[EffectShape]: ...
    @property
    def shown(self, /) -> str:
        """
        Motion of the head without which it cannot show: at_rest (none), moving,
        forward or both_ways.
        """
    @property
    def site(self, /) -> str:
        """
        friction, drive, body, environment or sensor.
        """
    @property
    def spanned(self, /) -> list[tuple[str, str]]:
        """
        Numbers of a rival whose values are fitted together.
        """
    @property
    def steady(self, /) -> bool:
        """
        Whether its law in `variable` stays near its mean, by whatever formula.
        """
    @property
    def variable(self, /) -> str | None:
        """
        Variable that another law of the effect would follow; None where it is the
        error of a number, which has no other law.
        """
    @property
    def work(self, /) -> float:
        """
        Work of a replay with it, in replays of the nominal model.
        """

@final
class EffectFit:
    """
    How fits treat a parameter of an effect. Numbers that follow from a rig are
    formulas in its sizes.
    """
    def __repr__(self, /) -> str: ...
    @property
    def at(self, /) -> str:
        """
        Its value at a magnitude `u` and the shapes.
        """
    @property
    def beside_level(self, /) -> bool:
        """
        Without the effect it is the nominal Coulomb level.
        """
    @property
    def composed(self, /) -> str | None:
        """
        What a start is in full, from its `value` and the other parameters.
        """
    @property
    def judged(self, /) -> bool:
        """
        Data determine it well enough for its value to be judged.
        """
    @property
    def log(self, /) -> bool:
        """
        Fits step its logarithm.
        """
    @property
    def name(self, /) -> str: ...
    @property
    def off(self, /) -> float | None:
        """
        Value without the effect; None where none does it, or where it is the Coulomb level.
        """
    @property
    def only_with(self, /) -> str | None:
        """
        Key of the nominal Coulomb level with which it is used (mu_coulomb or
        coulomb_force); None with either.
        """
    @property
    def range(self, /) -> tuple[str, str]:
        """
        Smallest and largest value of fits.
        """
    @property
    def rival(self, /) -> str:
        """
        Its value as a rival at a strength `s`.
        """
    @property
    def starts(self, /) -> str:
        """
        First values, in `unit` unless `log`.
        """
    @property
    def unit(self, /) -> str:
        """
        A large change of it (of its logarithm if `log`).
        """
    @property
    def windows(self, /) -> tuple[str, str]:
        """
        The same where runs are replayed in windows.
        """

@final
class EffectShape:
    """
    A number that the parameters of an effect follow from beside its magnitude.
    """
    def __repr__(self, /) -> str: ...
    @property
    def log(self, /) -> bool:
        """
        Fits step its logarithm.
        """
    @property
    def name(self, /) -> str: ...
    @property
    def range(self, /) -> tuple[str, str]: ...
    @property
    def starts(self, /) -> str:
        """
        Formulas of first values and of the range.
        """
    @property
    def step(self, /) -> float:
        """
        Of a finite difference.
        """

@final
class EquationError:
    """
    Displacements of models along the measured motion of runs.
    """
    def __new__(cls, /, experiment: Experiment, motions: SupportsGetItem[int, tuple[Incomplete, Incomplete, Incomplete, SupportsGetItem[int, tuple[SupportsIndex, SupportsIndex]]]], block: SupportsIndex, means: Incomplete, weights: Incomplete, times: Incomplete) -> EquationError:
        """
        `experiment` has each run as a span; `motions` x, v and sliding distance at the samples
        of each, and its slides in one direction, pairs of first sample and one beyond the last.
        `means`, `weights` and `times` are those of blocks of `block` samples, slide by slide:
        mean reading of x, its inverse deviation (0 where nothing was read) and mean time.
        """
    def displacements(self, /, fits: SupportsGetItem[int, Incomplete], threads: SupportsIndex) -> Incomplete:
        """
        How far fits would have come in each slide under the forces of the measured motion, a
        row each: block by block in units of the noise, without the line in time of every slide.
        Bristles are left out, and what a fit says about the start of a run.
        """
    def fit(self, /, fits: SupportsGetItem[int, Incomplete], steps: SupportsIndex, tolerance: SupportsFloat | SupportsIndex, threads: SupportsIndex) -> list[tuple[Incomplete, float]]:
        """
        Improve fits; returns theta, without what is about the start of a run, and chi2 of each.
        """
    def jacobian(self, /, fit: Incomplete, threads: SupportsIndex) -> Incomplete:
        """
        Derivatives of the displacements of a fit, a row for every free value but those about
        the start of a run.
        """
    def measured(self, /) -> Incomplete:
        """
        What was measured, in the form of `displacements`.
        """

@final
class Experiment:
    """
    Measured runs, or windows of them, as they are replayed.
    """
    def __new__(cls, /, job: Replay, spans: SupportsGetItem[int, tuple[SupportsIndex, SupportsIndex, SupportsIndex, SupportsFloat | SupportsIndex, bool]], begins: Incomplete, motor: tuple[SupportsFloat | SupportsIndex, SupportsFloat | SupportsIndex] | None = None) -> Experiment:
        """
        `spans` lists what is replayed at a time: the number of a run, first sample, one
        beyond the last, factor on the mass, and whether the robot was turned round.
        `begins` has a row for each: position and speed; or, of a window, the position,
        speed and acceleration that were seen there, seconds since the start of its run,
        the position there, and the distance moved forward since the last rest or turn.
        `motor` is resistance and force constant.
        """
    def read(self, /, points: SupportsGetItem[int, Incomplete], spans: SupportsGetItem[int, SupportsIndex], threads: SupportsIndex, moved: Incomplete | None = None) -> Incomplete:
        """
        What the sensors would read: rows of x, v, x_rear and force, point after point, span
        after span. `moved` shifts position and speed at the start of each span.
        """

@final
class FrictionCandidate:
    """
    A friction law to fit, how its levels follow the load, and what the force
    sensor adds.
    """
    def __new__(cls, /, law: str, load: str = "constant", *, offset: bool = False, gain: bool = False) -> FrictionCandidate: ...
    def __repr__(self, /) -> str: ...
    @property
    def gain(self, /) -> bool: ...
    @property
    def law(self, /) -> str: ...
    @property
    def load(self, /) -> str: ...
    @property
    def offset(self, /) -> bool: ...

@final
class FrictionData:
    """
    Measured motion and friction force, run by run.
    """
    def __new__(cls, /, runs: SupportsGetItem[int, tuple[Incomplete, Incomplete, Incomplete, Incomplete, Incomplete, Incomplete, Incomplete, Incomplete]], normal: SupportsFloat | SupportsIndex, rest_speed: SupportsFloat | SupportsIndex) -> FrictionData:
        """
        Each run is (t, x, v, drive, load, force, rows, folds): columns of one
        length, the samples that count, and the fold of each of these, 255 where it
        is only fitted to. `normal` is the normal force in N where no load gives
        it; up to `rest_speed` (m/s) a sample is at rest.
        """
    def fit(self, /, candidates: SupportsGetItem[int, FrictionCandidate], threads: SupportsIndex, progress: Any | None = None, token: CancelToken | None = None) -> list[FrictionOutcome]:
        """
        Fit every candidate; what is found has their order.
        """
    def lacks(self, /, candidate: FrictionCandidate) -> str | None:
        """
        Why a candidate cannot be fitted to these data; None if it can.
        """

@final
class FrictionOutcome:
    """
    A candidate as fitted.
    """
    @property
    def freedom(self, /) -> float:
        """
        Independent pieces of data beyond the parameters.
        """
    @property
    def held_out(self, /) -> Incomplete:
        """
        The same by fits that never saw the row; NaN where there is none.
        """
    @property
    def memory(self, /) -> float:
        """
        Rows that carry as much as one independent one.
        """
    @property
    def parameters(self, /) -> list[FrictionParameter]: ...
    @property
    def predicted(self, /) -> Incomplete:
        """
        Force at every row, N.
        """
    @property
    def rms(self, /) -> float:
        """
        Root mean square of the residuals of the rows fitted to, N.
        """
    @property
    def settled(self, /) -> bool:
        """
        Whether the search came to rest.
        """

@final
class FrictionParameter:
    """
    A parameter as a fit found it.
    """
    @property
    def bounded(self, /) -> bool:
        """
        At an end of the range that was searched.
        """
    @property
    def logarithmic(self, /) -> bool:
        """
        Its logarithm is what the fit moves and errors are even in.
        """
    @property
    def meaning(self, /) -> str: ...
    @property
    def name(self, /) -> str: ...
    @property
    def std(self, /) -> float:
        """
        inf where the data say nothing of it, NaN where it has none.
        """
    @property
    def unit(self, /) -> str: ...
    @property
    def value(self, /) -> float: ...

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
    What a run leaves. The rows of `x`, `v`, `slide` and `heap` have a number per
    segment, those of `force` one per joint, one row after another.
    """
    @property
    def force(self, /) -> Incomplete: ...
    @property
    def heap(self, /) -> Incomplete:
        """
        Fresh ground whose lubricant each segment pushes along, m; empty where the
        robot meets none.
        """
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
        Distance that each segment slides backward per cycle, m.
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
class Misfit:
    """
    Measured runs, and how far models may be from them.
    """
    def __new__(cls, /, experiment: Experiment, channels: SupportsGetItem[int, tuple[SupportsIndex | None, Incomplete, Incomplete]], shifts: SupportsGetItem[int, SupportsGetItem[int, tuple[SupportsIndex, Incomplete]]]) -> Misfit:
        """
        `channels` lists what was measured: the row of `Experiment.read` that predicts it,
        None for electric power, readings, and inverse deviations, 0 where a sample does
        not count. `shifts` lists what may differ from span to span: the channels that it
        acts on, by number, and what a deviation of it changes in their weighted readings.
        """
    def corrections(self, /, terms: SupportsGetItem[int, Incomplete], motion: Incomplete | None, spans: SupportsGetItem[int, SupportsIndex], threads: SupportsIndex, to: Incomplete) -> None:
        """
        What small forces along a motion over some spans, or, without one, errors of the position
        that is read, change of residuals: terms a row each, in tables one after another, into the
        front of the rows of `to`.
        """
    def evaluate(self, /, fits: SupportsGetItem[int, Incomplete], spans: SupportsGetItem[int, SupportsIndex], threads: SupportsIndex, keep: bool) -> list[tuple[float, Incomplete | None]]:
        """
        Chi2 of fits over some spans, and, where they are kept, their residuals and last
        those of what is known before.
        """
    def fit(self, /, fits: SupportsGetItem[int, Incomplete], known: SupportsGetItem[int, bool], spans: SupportsGetItem[int, SupportsIndex], steps: SupportsIndex, tolerance: SupportsFloat | SupportsIndex, least: SupportsFloat | SupportsIndex | None, threads: SupportsIndex) -> tuple[list[tuple[Incomplete, float, Incomplete, float]], int]:
        """
        Improve fits; `known` says of which chi2 is known, `least` is the
        smallest one that others have come to, None where each fit stands alone.
        Returns theta, chi2, covariance and damping of each, and the number of
        samples that were replayed.
        """
    def jacobian(self, /, fit: Incomplete, spans: SupportsGetItem[int, SupportsIndex], threads: SupportsIndex) -> Incomplete:
        """
        Derivatives of a fit's residuals over some spans, a row for every free value.
        """
    def residuals(self, /, points: SupportsGetItem[int, Incomplete], spans: SupportsGetItem[int, SupportsIndex], threads: SupportsIndex, most: SupportsFloat | SupportsIndex = ...) -> Incomplete:
        """
        Whitened residuals of models over some spans, a row each: channel by channel, span
        by span, and last the shifts in deviations, at most `most` of them.
        """

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
    def larger_is_better(self, /) -> bool: ...
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
    def run(self, /, columns: SupportsGetItem[int, tuple[SupportsIndex, SupportsIndex, SupportsIndex, SupportsGetItem[int, str]]], values: Incomplete, shares: Incomplete, starts: Incomplete, threads: SupportsIndex, progress: Any | None = None, token: CancelToken | None = None, channels: SupportsGetItem[int, SupportsIndex] | None = None) -> Incomplete:
        """
        Replay columns, each (run, first sample, one beyond the last, effects).

        `values` holds the parameters of all effects, a row a column; `shares`
        factors on nominal mass, Coulomb level and gain, and the clock offset in
        s; `starts` position and speed at the window's start. `channels` are the rows that
        are returned, by number, of x, v, x_rear and force, which come without it; all columns
        one after another.
        """
    def run_with_sensitivities(self, /, columns: SupportsGetItem[int, tuple[SupportsIndex, SupportsIndex, SupportsIndex, SupportsGetItem[int, str]]], values: Incomplete, shares: Incomplete, starts: Incomplete, directions: SupportsGetItem[int, SupportsGetItem[int, SupportsIndex]], threads: SupportsIndex, progress: Any | None = None, token: CancelToken | None = None, channels: SupportsGetItem[int, SupportsIndex] | None = None) -> tuple[Incomplete, Incomplete]:
        """
        The same with derivatives: `directions` lists for every column what they are taken
        by, as `sensitivity_directions` numbers them. Returns the rows of `run`, and as many
        in which a column has as many of its lengths as it has directions, one direction
        after another.
        """

@final
class Sweep:
    """
    A checked grid and what to compute on it.
    """
    def __new__(cls, /, axes: SupportsGetItem[int, tuple[str, Incomplete]], fixed: SupportsGetItem[int, tuple[str, SupportsFloat | SupportsIndex]], requests: SupportsGetItem[int, tuple[str, str | None, SupportsFloat | SupportsIndex | None]], over: str | None = None, *, law: str | None = None, drive: str | None = None, gait: str | None = None, method: str | None = None, locate: bool = True, table: tuple[Incomplete, Incomplete] | None = None, motion: bool = False, sample: SupportsGetItem[int, tuple[str, Incomplete]] = ...) -> Sweep:
        """
        `requests` are (quantity, reduction or None, q or None). Law, drive, method
        and table (times and values) count where a quantity is simulated; `motion`
        says that it is looked at itself, which prefers a method with dense output.
        `sample` is a last axis along which several parameters take their values together.
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
    def trace(self, /, stations: Incomplete, threads: SupportsIndex, progress: Any | None = None, token: CancelToken | None = None) -> tuple[list[Incomplete], Incomplete]:
        """
        Position, speed, drive force and direction of sliding (0 at rest) of every
        cell at `stations` (shares of the duration): shape (cells, stations) each; and
        the status codes of the cells.
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

def derivative(t: Incomplete, y: Incomplete, order: SupportsIndex) -> tuple[Incomplete, float, float, int]:
    """
    Derivative of order 1 or 2 of noisy samples, the standard deviation of their
    noise, that of the derivative, and the samples of the window that was used.
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

def falls() -> list[tuple[str, bool]]:
    """
    Name of every parameter that says over which speeds friction passes from one level to
    the other, and whether it is one over that speed.
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

def imposed_force(law: str, given: SupportsGetItem[int, tuple[str, SupportsFloat | SupportsIndex]], t: Incomplete, x: Incomplete, v: Incomplete, normal: Incomplete, drive: Incomplete, rest_speed: SupportsFloat | SupportsIndex = 0.0) -> Incomplete:
    """
    Signed friction force of a law at every sample of an imposed motion, under
    the normal force in N given at each sample.

    States of a bristle law are integrated along it; of a dry law at rest, so up
    to `rest_speed`, it is what the law holds in the direction in which the motion
    goes on.
    """

def laws() -> list[Law]:
    """
    All friction laws.
    """

def linear_response(forces: Incomplete, motion: Incomplete) -> tuple[Incomplete, Incomplete]:
    """
    First-order change of position and speed of a motion under small forces, a row a force.

    The motion is given by speed, seconds to the next sample and whether it is the last of its
    run, sample by sample, by the head's mass in kg and viscous coefficient in N s/m, by the share
    of a change of speed that is left at the next sample, 1 but where the head turns round, and by
    the stiffness with which gravity pulls the head back, in N/m.
    """

def methods() -> list[tuple[str, str]]:
    """
    Name and meaning of every method of simulation.
    """

def motor_power(force: Incomplete, speed: Incomplete, motor: tuple[SupportsFloat | SupportsIndex, SupportsFloat | SupportsIndex, SupportsFloat | SupportsIndex]) -> Incomplete:
    """
    Electric power in W at forces and speeds, of a motor that is given by its supply
    voltage, resistance and force constant.
    """

def nearest(given: str, known: SupportsGetItem[int, str]) -> str | None:
    """
    The known name that was probably meant, if one is close to what was given.
    """

def noise(t: Incomplete, y: Incomplete) -> float:
    """
    Standard deviation of white noise on samples of something smooth.
    """

def other_sizes(folders: SupportsGetItem[int, str | PathLike[str]], names: SupportsGetItem[int, str], sizes: SupportsGetItem[int, SupportsGetItem[int, SupportsIndex]]) -> list[dict[int, int | None]]:
    """
    Files of folders that have not the sizes that they should have.

    `names` are those of the files of each folder, `sizes` for each folder what they should be;
    links are not followed. Returns for each folder, by index of a name, the size that was found,
    None where there is no such file.

    OSError, with its number and its folder, where one cannot be read.
    """

def parameters() -> list[Parameter]:
    """
    All parameters of the closed forms.
    """

def pressings() -> list[tuple[str, str]]:
    """
    Name and meaning of every relation between friction level and load.
    """

def quantities() -> list[Quantity]:
    """
    All quantities, in the order of their equations.
    """

def rank_fits(residuals: SupportsGetItem[int, Incomplete], lengths: SupportsGetItem[int, SupportsIndex]) -> list[tuple[float, float, bool]]:
    """
    Of several fits, given the residuals of each on the same samples in runs of
    `lengths`: root mean square, distance from the best in standard deviations, and
    whether it cannot be told from the best.
    """

def reality_forms() -> list[tuple[str, str, list[str]]]:
    """
    All laws of the blind check: cause, form, parameters. The form `law` is the
    one that the cause's name stands for, `outside` is nobody's cause.
    """

def reality_run(runs: SupportsGetItem[int, tuple[Incomplete, Incomplete, SupportsFloat | SupportsIndex]], jobs: SupportsGetItem[int, tuple[SupportsIndex, dict[str, SupportsFloat | SupportsIndex], SupportsGetItem[int, tuple[str, str, dict[str, SupportsFloat | SupportsIndex]]], tuple[SupportsFloat | SupportsIndex, SupportsFloat | SupportsIndex], SupportsFloat | SupportsIndex, SupportsIndex]], threads: SupportsIndex, token: CancelToken | None = None) -> list[list[Incomplete]]:
    """
    Run drives through realities: what the sensors would read, without noise.

    `runs` are (times in s from 0, drive, slope in degrees); each job is (run,
    rig, effects as (name, form, parameters), start position and speed, longest
    step in s, seed of what is random in it). Returns x, v, x_rear and force for
    each job.
    """

def reality_source() -> str:
    """
    The text of all that makes the reality: cases drawn with other text are other cases.
    """

def reductions() -> list[tuple[str, str]]:
    """
    Name and meaning of every reduction.
    """

def sensitivity_directions() -> list[str]:
    """
    Names of what derivatives may be taken by beside the parameters of effects, which
    come first: they follow in this order.
    """

def simd_level() -> str:
    """
    SIMD level in use.
    """

def simd_levels() -> list[str]:
    """
    SIMD levels that this machine runs, lowest first.
    """

def spikes(values: Incomplete, times: SupportsFloat | SupportsIndex) -> list[int]:
    """
    Numbers of the samples that stand alone, further from the median of their
    neighbours than `times` the spread of such distances.
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
