"""Measured channels: what a sensor may read beside time and drive, a row a channel."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Channel:
    """What is known of a channel before it is measured.

    Attributes
    ----------
    name : str
        Its column in a file of runs.
    meaning : str
        For lists of columns.
    words, symbol : str
        For labels; the symbol is TeX.
    unit, rotary_unit : str
        SI, on a translational rig and on a rotary bench.
    sensor : str
        What `[sensor]` calls it: the keys are ``{sensor}_noise`` and, where its sensor
        rounds, ``{sensor}_resolution``.
    replayed : int or None
        Its row in what a replay of the core returns; None where it is not replayed.
    has_offset : bool
        Whether fits may shift the start of each run within the noise.
    from_rest : bool
        Whether a replay counts it from where the run found it.
    averaged : bool
        Whether it is the mean over a sample that counts where samples are merged:
        the drive, which is held, acts on it at once.
    """

    name: str
    meaning: str
    words: str
    symbol: str
    unit: str
    rotary_unit: str
    sensor: str
    replayed: int | None
    has_offset: bool = False
    from_rest: bool = False
    averaged: bool = False

    def unit_on(self, *, rotary: bool) -> str:
        """Return the unit on a rotary bench or on another rig.

        Examples
        --------
        >>> from locosweep.files.channels import CHANNELS
        >>> CHANNELS["force"].unit_on(rotary=True)
        'N m'
        """
        return self.rotary_unit if rotary else self.unit


CHANNELS = {
    channel.name: channel
    for channel in (
        Channel("x", "displacement of the head", "position", "x", "m", "rad", "position", 0,
                has_offset=True),
        Channel("x_rear", "displacement of the anchored body", "position of the body", "x_r",
                "m", "m", "position", 2, has_offset=True, from_rest=True),
        Channel("force", "force on the head from the drive", "drive force", "F_d", "N", "N m",
                "force", 3, averaged=True),
        Channel("v", "velocity of the head", "velocity", "v", "m/s", "rad/s", "velocity", 1),
        Channel("power", "electric power", "electric power", "P", "W", "W", "power", None,
                averaged=True),
    )
}  # fmt: skip
"""All channels, in the order of a file's columns."""

_ROWS = {channel.replayed: name for name, channel in CHANNELS.items()}
REPLAYED = tuple(_ROWS[row] for row in range(len(_ROWS) - 1))
"""Channels that a replay returns, in its order."""

PREDICTED = (*REPLAYED, *(name for name in CHANNELS if name not in REPLAYED))
"""Channels that a model predicts; electric power follows from them where it has a motor."""

OFFSETS = tuple(name for name in REPLAYED if CHANNELS[name].has_offset)
"""Channels whose start fits may shift."""
