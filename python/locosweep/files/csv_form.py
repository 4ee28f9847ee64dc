"""What a user says of a CSV file whose text leaves it open."""

from __future__ import annotations

from dataclasses import dataclass

from locosweep.errors import InputError

SEPARATORS = {"tab": "\t", "semicolon": ";", "comma": ",", "bar": "|"}
"""Characters between columns, by their names in options."""
DECIMALS = {"point": ".", "comma": ","}
"""Decimal characters by their names in options."""


@dataclass(frozen=True)
class CsvForm:
    """Separator and decimal character, where they are given."""

    separator: str | None = None
    """Name or character of `SEPARATORS`."""
    decimal: str | None = None
    """``point`` or ``comma``."""

    def __post_init__(self) -> None:
        for name, value, known, allowed in (
            ("separator", self.separator, SEPARATORS, {*SEPARATORS, *SEPARATORS.values()}),
            ("decimal", self.decimal, DECIMALS, {*DECIMALS}),
        ):
            if value is not None and value not in allowed:
                raise InputError(f"{name} is {value!r}: allowed are {', '.join(known)}")
