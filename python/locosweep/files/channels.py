"""Measured channels: what a sensor may read beside time and drive, a row a channel."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Channel:
    """Properties of a measured channel, a column of a file of runs."""

    name: str
    meaning: str
    """For lists of columns."""
    words: str
    symbol: str
    """TeX, for labels with `words`."""
    unit: str
    """SI, on a translational rig; `rotary_unit` on a rotary bench."""
    rotary_unit: str
    sensor: str
    """Name in `[sensor]`, with ``_noise`` and, where the sensor rounds, ``_resolution``."""
    replayed: int | None
    """Row of the core's replay; None where the channel is not replayed."""
    has_offset: bool = False
    """Fits may shift the start of each run within the noise."""
    from_rest: bool = False
    """A replay counts it from its value at the start of the run."""
    averaged: bool = False
    """Merged samples are averaged: the drive, which is held, acts on the channel at once."""

    def unit_on(self, *, rotary: bool) -> str:
        """Return the unit on a rotary bench or on another rig."""
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
