"""Tables of others: the wanted columns of a CSV or Parquet file or of a frame, by our names."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from locosweep.errors import DataFileError, InputError, first_line
from locosweep.files import csv_text, stamps
from locosweep.files.csv_form import CsvForm
from locosweep.files.raw import MOST_BYTES, STANDARD_INPUT, check_size, contents
from locosweep.files.sources import frame_of, is_frame
from locosweep.files.units import bracketed, is_unit
from locosweep.registry import unknown

if TYPE_CHECKING:
    from collections.abc import Collection, Sequence

    import polars as pl

    Wanted = Mapping[str, Sequence[str]]
    """Allowed SI units of a column by our name; none for labels."""

MOST_COLUMNS = 1000
"""Columns of a file of which all are looked at; logs have some dozens."""
_WITH_UNIT = re.compile(r"[+-]?[\d.,]+(?:[eE][+-]?\d+)?\s*([A-Za-zµ°%][A-Za-zµ°%/]*)")
_COMMA = r"^\s*[+-]?\d*,\d+([eE][+-]?\d+)?\s*$"
_POINT = r"^\s*[+-]?\d*\.\d+([eE][+-]?\d+)?\s*$"
_GROUPS = r"^\s*[+-]?[1-9]\d{0,2}(,\d{3})+\s*$"
GROUPED = r"^\s*[+-]?[1-9]\d{0,2}(,\d{3})+(\.\d*)?([eE][+-]?\d+)?\s*$"
"""Numbers with commas between groups of digits."""


@dataclass(frozen=True)
class Table:
    """Wanted columns by our names, as they stand in a file or frame."""

    path: str
    """What messages call it."""
    frame: pl.DataFrame
    labels: dict[str, str]
    """Names in the file, by ours."""
    others: list[str]
    """Columns that are not wanted."""
    wanted: Wanted
    units: dict[str, str] = field(default_factory=dict)
    """Units that the file states itself, in brackets or in a row below the names."""
    notices: list[str] = field(default_factory=list)
    refused: type[InputError] = DataFileError


def read_table(
    data: Any,
    wanted: Wanted,
    needed: Collection[str],
    columns: Mapping[str, str] | None = None,
    form: CsvForm | None = None,
    *,
    name: str = "data",
) -> Table:
    """Return the wanted columns of a file, or of a frame of any maker, by our names.

    `needed` columns must be there; `columns` maps our names to those of the file, where a unit
    in brackets may follow; `name` is what messages call a frame. Refuses what cannot be read,
    is empty, or lacks a column or has it twice: a file with DataFileError, a frame with
    InputError.
    """
    columns = dict(columns or {})
    for own in columns:
        if own not in wanted:
            raise InputError(f"column: {unknown('column', own, wanted)}")
    for their in columns.values():
        if list(columns.values()).count(their) > 1:
            twice = " and ".join(own for own in columns if columns[own] == their)
            raise InputError(f"column: {twice} are both {their}: allowed is one of them")
    # Columns that are given come first: one of them may bear a name of ours.
    theirs = {own: columns.get(own, own) for own in (*columns, *wanted)}
    asked = {own: text for own, text in theirs.items() if own in (*needed, *columns)}
    form = form or CsvForm()
    notices: list[str] = []
    if is_frame(data):
        frame = frame_of(data, name)
        found = _found(name, InputError, frame.columns, theirs, asked)
        picked = frame.select(frame.columns[place] for place, _ in found.values())
    else:
        path = Path(data)
        if path != STANDARD_INPUT and not path.is_file():
            raise DataFileError(f"{path}: {'a folder' if path.is_dir() else 'no such file'}")
        if path.suffix.lower() == ".parquet":
            parts = _parquet(path, theirs, asked)
        else:
            parts = _csv(path, theirs, asked, form, notices)
        return _finished(*parts, wanted, DataFileError, form, notices)
    picked.columns = list(found)
    return _finished(name, picked, found, frame.columns, wanted, InputError, form, notices)


def whole_table(path: Path, form: CsvForm) -> tuple[list[str], pl.DataFrame]:
    """Return the names of all columns of a file, and the columns as they stand, by their places.

    DataFileError as `read_table`, and for more than `MOST_COLUMNS` columns.
    """
    import polars as pl

    if path.suffix.lower() != ".parquet":
        text = csv_text.parsed(contents(path), str(path), form.separator)
        _check_width(path, text.names)
        return text.names, csv_text.frame_of(text, str(path), range(len(text.names)))
    try:
        names = list(pl.read_parquet_schema(path))
    except (OSError, pl.exceptions.PolarsError, pl.exceptions.PanicException) as error:
        raise _unreadable(path, error) from None
    _check_width(path, names)
    _, frame, _, _ = _parquet(path, {name: name for name in names}, {})
    frame.columns = [str(place) for place in range(len(names))]
    return names, frame


def _check_width(path: Path, names: Sequence[str]) -> None:
    if len(names) > MOST_COLUMNS:
        raise DataFileError(f"{path}: {len(names)} columns, allowed are up to {MOST_COLUMNS}")


def _unreadable(path: Path, error: BaseException) -> DataFileError:
    return DataFileError(f"{path}: not a readable Parquet file: {first_line(error)}")


Found = dict[str, tuple[int, str]]
"""Place and stated unit of each column, by our name."""


def _csv(
    path: Path,
    theirs: Mapping[str, str],
    asked: Mapping[str, str],
    form: CsvForm,
    notices: list[str],
) -> tuple[str, pl.DataFrame, Found, list[str]]:
    # Not by a name: the bytes are let go as soon as the rows are cut out of them.
    text = csv_text.parsed(contents(path), str(path), form.separator)
    if text.above:
        notices.append(f"{path}: lines above the names left out: {text.above}")
    if text.comments:
        marks = " or ".join(csv_text.COMMENTS)
        notices.append(f"{path}: lines left out as comments: {text.comments} (begin with {marks})")
    found = _found(str(path), DataFileError, text.names, theirs, asked)
    frame = csv_text.frame_of(text, str(path), [place for place, _ in found.values()])
    frame = frame.select(str(place) for place, _ in found.values())
    frame.columns = list(found)
    return str(path), frame, found, text.names


def _parquet(
    path: Path, theirs: Mapping[str, str], asked: Mapping[str, str]
) -> tuple[str, pl.DataFrame, Found, list[str]]:
    import polars as pl

    try:
        names = list(pl.read_parquet_schema(path))
        found = _found(str(path), DataFileError, names, theirs, asked)
        own = [names[place] for place, _ in found.values()]
        # Counted from the metadata.
        check_size(path, pl.scan_parquet(path).select(pl.len()).collect().item(), len(own))
        frame = pl.read_parquet(path, columns=own).select(own)
    except (OSError, pl.exceptions.PolarsError, pl.exceptions.PanicException) as error:
        raise _unreadable(path, error) from None
    for name, kind in frame.schema.items():
        # A long text that is stored once may stand in every row.
        long = int(frame[name].str.len_bytes().sum() or 0) if kind == pl.String else 0
        if long > MOST_BYTES:
            raise DataFileError(f"{path}: column {name}: more than {MOST_BYTES >> 20} MB of text")
    frame.columns = list(found)
    return str(path), frame, found, names


def _found(
    path: str,
    refused: type[InputError],
    names: Sequence[str],
    theirs: Mapping[str, str],
    asked: Mapping[str, str],
) -> Found:
    """Return where the wanted columns are."""
    found: Found = {}
    for name, label in theirs.items():
        places = [place for place, one in enumerate(names) if one == label]
        if not places:
            places = [place for place, one in enumerate(names) if bracketed(one)[0] == label]
        if len(places) > 1:
            raise refused(f"{path}: column {label} is there twice")
        taken = next((own for own, (place, _) in found.items() if [place] == places), "")
        if places and not taken:
            found[name] = (places[0], bracketed(names[places[0]])[1])
        elif name in asked:
            hint = "" if label == name else f" (given for {name})"
            hint = f" beside that for {taken}" if taken else hint
            raise refused(f"{path}: no column {label}{hint}: there are {listed(names)}")
    return found


def listed(names: Sequence[str]) -> str:
    """Return names for a message, the first 20 and none longer than 40 characters."""
    short = [name if len(name) <= 40 else f"{name[:37]}..." for name in names[:20]]
    more = f" and {len(names) - 20} more" if len(names) > 20 else ""
    return ", ".join(short) + more


def _finished(
    path: str,
    frame: pl.DataFrame,
    found: Found,
    names: Sequence[str],
    wanted: Wanted,
    refused: type[InputError],
    form: CsvForm,
    notices: list[str],
) -> Table:
    """Take off a row of units, settle the decimal character, and refuse a table without rows."""
    import polars as pl

    places = {place for place, _ in found.values()}
    labels = {name: names[place] for name, (place, _) in found.items()}
    units = {name: unit for name, (_, unit) in found.items() if unit}
    others = [name for place, name in enumerate(names) if place not in places]
    table = Table(path, frame, labels, others, wanted, units, notices, refused)
    text = [name for name in found if wanted[name] and frame[name].dtype == pl.String]
    if text and frame.height:
        for name in text:
            if unit := unit_in_cells(frame[name]):
                frame = frame.with_columns(without_unit(frame[name], unit))
                units[name] = unit
        below = units_row({name: frame[name] for name in text})
        if below:
            frame = frame.slice(1)
            units.update(below)
            told = ", ".join(f"{labels[name]} in {unit}" for name, unit in below.items())
            table.notices.append(f"{path}: a row below the names gives units: {told}")
        numbers = [name for name in text if name != "t" or not stamps.are_dates(frame["t"])]
        frame = _with_points(replace(table, frame=frame), numbers, form)
    if frame.height == 0:
        raise refused(f"{path}: no rows")
    return replace(table, frame=frame)


def unit_in_cells(column: pl.Series) -> str:
    """Return the unit that ends every text of a column, as in MATLAB's ``0.01 sec``; or nothing."""
    cells = (cell.strip() for cell in column if cell is not None)
    first = next((cell for cell in cells if cell.lower() not in csv_text.MISSING), "")
    found = _WITH_UNIT.fullmatch(first)
    if not found or not is_unit(found[1]):
        return ""
    text = column.str.strip_chars()
    without = text.str.to_lowercase().is_in(csv_text.MISSING) | text.str.ends_with(found[1])
    return found[1] if without.all() else ""


def without_unit(column: pl.Series, unit: str) -> pl.Series:
    """Return texts without the unit that ends them."""
    text = column.str.strip_chars()
    return text.str.strip_suffix(unit).str.strip_chars() if unit else text


def units_row(columns: Mapping[str, pl.Series]) -> dict[str, str]:
    """Return the units that the first row of texts gives; none if it is a row of values."""
    cells = {
        name: column[0].strip().strip("[]()").strip()
        for name, column in columns.items()
        if column.len() and isinstance(column[0], str)
    }
    given = {name: cell for name, cell in cells.items() if cell}
    values = (cell.lower() in csv_text.MISSING or cell[0] in "+-.,0123456789" for cell in
              given.values() if cell not in {"1", "-"})  # fmt: skip
    if not given or all(cell in {"1", "-"} for cell in given.values()) or any(values):
        return {}
    return given if all(is_unit(cell) for cell in given.values()) else {}


def _with_points(table: Table, names: Sequence[str], form: CsvForm) -> pl.DataFrame:
    """Return a frame whose decimal character is the point."""
    frame = table.frame
    commas = [name for name in names if frame[name].str.contains(",", literal=True).any()]
    if not commas:
        return frame
    if (form.decimal or _decimal(table, names, commas)) == "point":
        return _replaced(frame, commas, GROUPED, "")
    table.notices.append(f"{table.path}: read with decimal commas")
    for name in names:
        points = frame[name].str.contains(_POINT).arg_true()
        if len(points):
            raise table.refused(
                f"{_cell(table, name, points[0])} has a decimal point, others have commas"
            )
    return _replaced(frame, commas, _COMMA, ".")


def _replaced(frame: pl.DataFrame, names: Sequence[str], form: str, character: str) -> pl.DataFrame:
    """Put a character in place of the commas in texts of a form."""
    import polars as pl

    return frame.with_columns(
        pl.when(pl.col(name).str.contains(form))
        .then(pl.col(name).str.replace_all(",", character, literal=True))
        .otherwise(pl.col(name))
        .alias(name)
        for name in names
    )


def _decimal(table: Table, names: Sequence[str], commas: Sequence[str]) -> str:
    """Return the decimal character that commas show; refuse a table that leaves it open."""
    frame = table.frame
    if any(
        (frame[name].str.contains(_COMMA) & ~frame[name].str.contains(_GROUPS)).any()
        for name in commas
    ):
        return "comma"
    pointed = any(frame[name].str.contains(_POINT).any() for name in names)
    for name in commas:
        rows = frame[name].str.contains(GROUPED).arg_true()
        if not len(rows):
            continue
        where, text = _cell(table, name, rows[0]), frame[name][int(rows[0])].strip()
        if pointed or "." in text:
            raise table.refused(
                f"{where} is not a number: --decimal point takes its commas as groups of digits"
            )
        raise table.refused(
            f"{where} may be {text.replace(',', '.', 1)} or {text.replace(',', '')}: "
            "--decimal comma or --decimal point settles it"
        )
    return "point"


def _cell(table: Table, name: str, row: int) -> str:
    """Return place and text of a cell for a message."""
    text = table.frame[name][int(row)].strip()
    return f"{table.path}: row {int(row) + 1}, column {table.labels[name]}: {text!r}"
