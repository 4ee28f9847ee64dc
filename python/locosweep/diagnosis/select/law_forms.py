"""Formulas of one variable that say what a law looks like: some twenty forms, the shortest wins.

A form is a sum of a few columns along the variable, whose sizes are solved for, at a shape, which
is looked for on a grid. What a form gains is a fall of chi2, and each of its numbers has the price
of a parameter: the shortest description of the law (after Rissanen's minimum description length).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import product
from typing import TYPE_CHECKING

import numpy as np

from locosweep.diagnosis.select.thresholds import LEAST_GAIN, PENALTY

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    Floats = NDArray[np.float64]
    Columns = Callable[[Floats, Floats], Floats]
    """Columns of a form along values of the variable, at shapes of shape (shapes, numbers)."""

_PLACES, _WIDTHS, _LENGTHS, _ENDS = 39, 9, 25, 13
"""Values of a place, a width, a wave's length and one of two ends that are tried: neighbours are
no farther apart than the halvings that follow can close."""
_HALVINGS = 6
"""Times that the grid around the best shape is halved: a sixtieth of a step is left."""
_POWERS = (0.5, 1.5, 2.0, 3.0)


@dataclass(frozen=True)
class Form:
    """A form of a law."""

    columns: Columns
    grids: tuple[str, ...] = ()
    """What each number of a shape is: a place, a width, a length, a power."""
    words: str = ""
    """Text with places for a size (`a`, or `b` per unit of the variable), the numbers of the shape,
    the variable's symbol and its largest value (`end`)."""
    constant: bool = True
    """Whether a constant beside it makes sense."""
    jumps: bool = False
    """Whether it changes at once somewhere."""


def _constant(u: Floats, s: Floats) -> Floats:
    return np.ones((len(s), u.size, 1))


def _line(u: Floats, s: Floats) -> Floats:
    return np.asarray(np.broadcast_to(u[None, :, None], (len(s), u.size, 1)))


def _above(u: Floats, s: Floats) -> Floats:
    return np.maximum(u[None] - s[:, :1], 0.0)[..., None]


def _below(u: Floats, s: Floats) -> Floats:
    return np.minimum(u[None] - s[:, :1], 0.0)[..., None]


def _outside(u: Floats, s: Floats) -> Floats:
    ends = np.sort(s, axis=1)
    return np.asarray(_above(u, ends[:, 1:]) + _below(u, ends[:, :1]))


def _step(u: Floats, s: Floats) -> Floats:
    return (u[None] > s[:, :1]).astype(float)[..., None]


def _rise(u: Floats, s: Floats) -> Floats:
    return 0.5 * (1.0 + np.tanh((u[None] - s[:, :1]) / s[:, 1:]))[..., None]


def _bump(u: Floats, s: Floats) -> Floats:
    return np.exp(-0.5 * ((u[None] - s[:, :1]) / s[:, 1:]) ** 2)[..., None]


def _pair(u: Floats, s: Floats) -> Floats:
    """Rise on one side of a place and fall on the other, 1 at the highest."""
    z = (u[None] - s[:, :1]) / s[:, 1:]
    return np.asarray((z * np.exp(0.5 - 0.5 * z**2))[..., None])


def _wave(u: Floats, s: Floats) -> Floats:
    angle = 2.0 * np.pi * u[None] / s[:, :1]
    return np.stack([np.sin(angle), np.cos(angle)], axis=2)


def _fading(u: Floats, s: Floats) -> Floats:
    return np.asarray(np.exp(-(u[None] - u.min()) / s[:, :1])[..., None])


def _power(u: Floats, s: Floats) -> Floats:
    """Grow with a power of the variable, 1 at the largest value."""
    share = u / np.abs(u).max()
    return np.asarray((np.sign(share)[None] * np.abs(share)[None] ** s[:, :1])[..., None])


_CONSTANT = Form(_constant, (), "{a}, the same everywhere", constant=False)
_FORMS = (
    _CONSTANT,
    Form(_line, (), "{b} of {symbol}"),
    Form(_above, ("place",), "{b} beyond {symbol} = {0}"),
    Form(_below, ("place",), "{b} below {symbol} = {0}"),
    Form(_outside, ("end", "end"), "{b} outside {symbol} = {0} to {1}"),
    Form(_step, ("place",), "{a} beyond {symbol} = {0}", jumps=True),
    Form(_rise, ("place", "width"), "{a} that comes around {symbol} = {0}, over {1:wide}"),
    Form(_bump, ("place", "width"), "{a} around {symbol} = {0}, {1:wide} wide"),
    Form(_pair, ("place", "width"), "up to {a} beyond {symbol} = {0} and the reverse before, "
                                    "largest {1} away"),
    Form(_wave, ("length",), "a wave of {a} every {0}"),
    Form(_fading, ("width",), "{a} that fades over {0}"),
    Form(_power, ("power",), "{a} at {symbol} = {end}, as its power {0:plain}", False),
)  # fmt: skip


@dataclass(frozen=True, eq=False)
class Found:
    """The form that describes a law best."""

    form: Form
    shape: tuple[float, ...]
    sizes: Floats
    deviations: Floats
    """Standard deviations of the sizes."""
    constant: bool
    """Whether the last size is that of a constant beside it."""
    gain: float
    """Fall of chi2."""
    may_jump: bool = False
    """True if a form that changes at once describes the law, too."""

    def at(self, u: Floats) -> Floats:
        """Return the law at values of the variable."""
        columns = _columns(self.form, u, np.array([self.shape]), constant=self.constant)
        return np.asarray(columns[0] @ self.sizes)


def shortest(u: Floats, gram: Floats, moments: Floats) -> Found | None:
    """Return the form that describes a law best, by heights at values `u` of its variable.

    A law of heights h lowers chi2 by 2 `moments` h - h `gram` h. None where no form lowers it by
    more than its numbers cost.
    """
    best, least = None, 0.0
    gradual = sudden = -np.inf
    for form in _FORMS:
        for constant in (False, True) if form.constant else (False,):
            found = _best_shape(form, u, gram, moments, constant=constant)
            score = found.gain - PENALTY * (len(found.shape) + found.sizes.size)
            if form.jumps:
                sudden = max(sudden, score)
            else:
                gradual = max(gradual, score)
            if score > least:
                best, least = found, score
    return None if best is None else replace(best, may_jump=sudden > gradual - LEAST_GAIN)


def _columns(form: Form, u: Floats, shapes: Floats, *, constant: bool) -> Floats:
    columns = form.columns(u, shapes)
    ones = _CONSTANT.columns(u, shapes)
    return np.concatenate([columns, ones], axis=2) if constant else columns


def _best_shape(form: Form, u: Floats, gram: Floats, moments: Floats, *, constant: bool) -> Found:
    grids = [_grid(name, u) for name in form.grids]
    shapes = np.array(list(product(*grids)), dtype=float)
    steps = np.array([np.diff(grid).max(initial=0.0) for grid in grids])
    found = _solved(form, u, gram, moments, shapes, constant=constant)
    if "power" in form.grids:
        return found
    for _ in range(_HALVINGS if grids else 0):
        steps = steps / 2.0
        near = np.array(
            list(product(*([c - d, c, c + d] for c, d in zip(found.shape, steps, strict=True))))
        )
        low = np.array([grid.min() for grid in grids])
        high = np.array([grid.max() for grid in grids])
        found = _solved(form, u, gram, moments, np.clip(near, low, high), constant=constant)
    return found


def _grid(name: str, u: Floats) -> Floats:
    low, span = float(u.min()), float(np.ptp(u))
    match name:
        case "place":
            return low + span * np.linspace(0.0, 1.0, _PLACES + 2)[1:-1]
        case "end":
            return low + span * np.linspace(0.0, 1.0, _ENDS + 2)[1:-1]
        case "width":
            return np.geomspace(span / 32.0, span / 2.0, _WIDTHS)
        case "length":
            return np.geomspace(span / 8.0, 2.0 * span, _LENGTHS)
    return np.array(_POWERS)


def _solved(
    form: Form, u: Floats, gram: Floats, moments: Floats, shapes: Floats, *, constant: bool
) -> Found:
    """Return the best of some shapes, with the sizes that lower chi2 most."""
    columns = _columns(form, u, shapes, constant=constant)
    matrix = np.einsum("snk,nm,sml->skl", columns, gram, columns, optimize=True)
    right = np.einsum("snk,n->sk", columns, moments)
    scale = np.sqrt(np.maximum(np.einsum("skk->sk", matrix), 1e-300))
    unit = matrix / (scale[:, :, None] * scale[:, None, :])
    # A column that another one stands for, or that no reading sees, has no size of its own.
    inverse = np.linalg.pinv(unit, rcond=1e-9, hermitian=True)
    sizes = np.einsum("skl,sl->sk", inverse, right / scale) / scale
    gains = np.einsum("sk,sk->s", sizes, right)
    k = int(np.argmax(gains))
    deviations = np.sqrt(np.maximum(np.diag(inverse[k]), 0.0)) / scale[k]
    return Found(form, tuple(shapes[k].tolist()), sizes[k], deviations, constant, float(gains[k]))
