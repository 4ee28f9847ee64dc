"""Result of a fit of friction laws."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from locosweep import _core
from locosweep.registry import law as law_record

if TYPE_CHECKING:
    import os

    from numpy.typing import ArrayLike, NDArray

    from locosweep._core import Law
    from locosweep.friction_fit.prepare import Prepared

_MOST = 1e3
"""Largest friction coefficient of the registry."""


@dataclass(frozen=True)
class FittedParameter:
    """One parameter of a fitted law.

    Names are those of the registry, and ``preload`` [N], ``force_offset`` [N] and
    ``load_gain``.
    """

    name: str
    unit: str
    meaning: str
    value: float
    std: float | None
    """Standard deviation; None where the data do not determine the value, where it is an
    edge on the track, or `bounded`."""
    interval: tuple[float, float] | None
    """95 % confidence interval, even about the value or, where the fit moves it, its
    logarithm."""
    bounded: bool
    """At an end of the range that was searched."""


@dataclass(frozen=True)
class FittedLaw:
    """One law as fitted.

    Attributes
    ----------
    law : str
        Its name in the registry.
    load : str
        Dependence of its levels on the load: constant, proportional or affine.
    offset, gain : bool
        The force sensor has a fitted offset, or a fitted share of the load.
    parameters : dict of str to FittedParameter
        By name.
    rms, held_out_rms : float
        Root mean square [N] of what is left of the samples fitted to, and of samples
        held out.
    sigmas : float
        Distance behind the best one on samples held out, in standard deviations.
    tied : bool
        Indistinguishable from the best one there.
    memory : float
        Samples that carry as much as one independent one.
    freedom : float
        Independent pieces of data beyond the parameters.
    settled : bool
        The search converged.
    remarks : list of str
        Parameters at an end of their range and levels outside the speeds measured: such a
        law does not win against one without among those that tie.
    normal : float
        Normal force [N] that `constant` levels count under.
    predicted, held_out : ndarray
        Force [N] at every sample that counts, by the fit and by fits that never saw
        the sample (NaN where there is none), shape (m,).
    """

    law: str
    load: str
    offset: bool
    gain: bool
    parameters: dict[str, FittedParameter]
    rms: float
    held_out_rms: float
    sigmas: float
    tied: bool
    memory: float
    freedom: float
    settled: bool
    remarks: list[str]
    normal: float
    predicted: NDArray[np.float64] = field(repr=False)
    held_out: NDArray[np.float64] = field(repr=False)

    @property
    def record(self) -> Law:
        """The law in the registry."""
        return law_record(self.law)

    @property
    def name(self) -> str:
        """Law and terms in one word, for tables and legends."""
        load = [] if self.load == "constant" else [f"{self.load} load"]
        return " + ".join([self.law, *load, *["offset"] * self.offset, *["load gain"] * self.gain])

    def normal_force(self, load: float | None = None) -> float:
        """Return the normal force [N] under a load [N]; without one that of constant levels."""
        if self.load == "constant" or load is None:
            return self.normal
        preload = self.parameters["preload"].value if "preload" in self.parameters else 0.0
        return abs(load) + preload

    def force(self, speed: ArrayLike, load: float | None = None) -> NDArray[np.float64]:
        """Friction force [N] of steady sliding at signed speeds [m/s], sensor errors left out.

        `load` [N] counts where the levels follow it.
        """
        speeds = np.asarray(speed, dtype=np.float64)
        force: NDArray[np.float64] = _core.characteristic(
            self.law, self._given(load), speeds.ravel()
        )
        return force.reshape(speeds.shape)

    def _given(self, load: float | None) -> list[tuple[str, float]]:
        known = {p.name for p in self.record.parameters}
        given = {n: p.value for n, p in self.parameters.items() if n in known}
        normal = self.normal_force(load)
        levels = [n for n in ("mu_static", "mu_coulomb") if n in given]
        # Under 1 N a coefficient counts newtons, of which there may be many.
        shift = max([1.0, *(given[n] / _MOST for n in levels)])
        given |= {n: given[n] / shift for n in levels}
        return [*given.items(), ("gravity", 0.0), ("wall_force", normal * shift)]


@dataclass(frozen=True, repr=False)
class FrictionFit:
    """Friction laws fitted to measured data, the best first.

    Attributes
    ----------
    chosen : FittedLaw
        Of the laws that tie on samples held out the one with the fewest parameters, if
        possible without `remarks`.
    laws : list of FittedLaw
        All, by what is left on samples held out.
    equal : list of FittedLaw
        Indistinguishable from the chosen one, with as few parameters.
    no_better : list of FittedLaw
        Indistinguishable too, with more parameters.
    status : str
        "chosen": no law with as few parameters ties; "tie": some do.
    summary : str
        One sentence for people.
    noise : float
        Standard deviation [N] of the force sensor's noise from sample to sample.
    shrink : float
        Share of the force's spread that the chosen law takes away on samples held
        out, 1 at best.
    left : dict of str to float
        Share of what the chosen law leaves that goes with v, x, t or load.
    skipped : dict of str to str
        Laws that were not fitted, and why.
    data : Prepared
        What was fitted to.
    notices : list of str
        What was not as expected.
    provenance : dict
        Version, hash of the data file, options.

    Examples
    --------
    >>> import numpy as np, locosweep as ls
    >>> t = np.linspace(0, 10, 800)
    >>> v = 0.02 * np.sin(2 * t)
    >>> noise = np.random.default_rng(1).normal(0, 0.01, t.size)
    >>> measured = {"t": t, "v": v, "force": 0.8 * np.sign(v) + 5 * v + noise}
    >>> fit = ls.fit_friction(measured, laws=["coulomb", "coulomb_viscous", "stribeck"])
    >>> fit.chosen.law
    'coulomb_viscous'
    >>> low, high = fit.chosen.parameters["viscous"].interval
    >>> low < 5 < high
    True
    """

    chosen: FittedLaw
    laws: list[FittedLaw]
    equal: list[FittedLaw]
    no_better: list[FittedLaw]
    status: str
    summary: str
    noise: float
    shrink: float
    left: dict[str, float]
    skipped: dict[str, str]
    data: Prepared = field(repr=False)
    notices: list[str]
    provenance: dict[str, object]

    def to_dict(self) -> dict[str, object]:
        """Everything but samples, as plain numbers and text: what ``friction.json`` holds."""
        from locosweep.friction_fit.report import as_dict

        return as_dict(self)

    def save(self, folder: str | os.PathLike[str]) -> list[str]:
        """Write ``friction.json``, ``friction.md`` and the pictures; return the files.

        The folder is made if missing; InputError if it cannot be made or written to.
        """
        from locosweep.friction_fit.report import save

        return [str(path) for path in save(self, folder)]

    def __repr__(self) -> str:
        from locosweep.friction_fit.report import as_text

        return as_text(self)

    def _repr_html_(self) -> str:
        from locosweep.friction_fit.picture import characteristic_figure
        from locosweep.plot.html import card

        return card(repr(self), characteristic_figure(self))
