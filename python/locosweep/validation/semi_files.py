"""Semi-real cases as files: what a user would hand in, and what stays sealed."""

from __future__ import annotations

import json
import shutil
from typing import TYPE_CHECKING, Any

from locosweep.diagnosis.report.model_file import write_augmented
from locosweep.files.robot import load_robot
from locosweep.files.runs import load_runs
from locosweep.files.strict_json import plain
from locosweep.kept_work.processes import code_digest, over_processes
from locosweep.kept_work.records import digest, keep, kept
from locosweep.kept_work.staged import staged
from locosweep.validation.case_files import seal
from locosweep.validation.planting import NotPlantable, Rig
from locosweep.validation.semi_real import Source, controls, draw, names_of

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence
    from pathlib import Path

    import polars as pl

    from locosweep.files.runs import Run
    from locosweep.validation.semi_real import Case

_DRAWING = ("planting", "extra_friction", "rig_problem", "semi_real", "semi_files")
"""Modules that say what a case is: when others change, drawn cases stay."""


def frame_of(runs: Sequence[Run]) -> pl.DataFrame:
    """Return runs in the long form of files."""
    import polars as pl

    parts = []
    for run in runs:
        columns: dict[str, Any] = {
            "run": [run.label] * run.t.size, "t": run.t, "drive": run.drive, **run.channels
        }  # fmt: skip
        if run.slope_deg is not None:
            columns["slope_deg"] = [run.slope_deg] * run.t.size
        parts.append(pl.DataFrame(columns))
    return pl.concat(parts, how="diagonal")


def _write(case: Case, name: str, out: Path) -> list[Path]:
    open_, sealed = out / name, out / "sealed" / name
    open_.mkdir(parents=True, exist_ok=True)
    sealed.mkdir(parents=True, exist_ok=True)
    frame_of(case.rig.runs).write_parquet(open_ / "runs.parquet")
    write_augmented(case.rig.robot, open_ / "nominal.toml")
    text = json.dumps(plain({"case": name, **case.truth}), indent=1, allow_nan=False)
    (sealed / "truth.json").write_text(text)
    return [open_ / "runs.parquet", open_ / "nominal.toml", sealed / "truth.json"]


def _staged(case: Case, name: str, out: Path) -> list[Path]:
    with staged(out, name, f"sealed/{name}") as place:
        return [out / path.relative_to(place) for path in _write(case, name, place)]


def _draw(
    files: tuple[Path, Path], chosen: tuple[str, ...], name: str, size: float, seed: int,
    out: Path, key: str,
) -> tuple[str, str]:  # fmt: skip
    """Draw one case into its folder; return the folder, or why there is none."""
    folder = f"{name}_{size:g}"
    record = out / "sealed" / folder / "drawn.json"
    if (known := kept(record, key)) is not None:
        return folder, known["reason"]
    source = Source(rig_of(*files, chosen))
    reason, made = "", []
    try:
        # The same parameters at every size: only the strength differs.
        case = draw(source, name, size, [seed, names_of(source.rig).index(name)])
        made = _staged(case, folder, out)
    except NotPlantable as why:
        reason = str(why)
        # Another version may have drawn it.
        shutil.rmtree(out / folder, ignore_errors=True)
        (record.parent / "truth.json").unlink(missing_ok=True)
    keep(record, key, made, reason=reason)
    return folder, reason


def rig_of(runs: Path, nominal: Path, chosen: Sequence[str]) -> Rig:
    """Read a rig; `chosen` labels of runs, or all."""
    records, _ = load_runs(runs)
    kept = tuple(run for run in records if not chosen or run.label in chosen)
    return Rig(load_robot(nominal), kept)


def draw_semi_real(
    runs: Path,
    nominal: Path,
    out: Path,
    *,
    chosen: Sequence[str] = (),
    sizes: Sequence[float] = (3.0, 10.0, 30.0),
    seed: int = 0,
    processes: int = 1,
    progress: Callable[[int, int], object] | None = None,
    shard: tuple[int, int] | None = None,
) -> tuple[list[str], dict[str, str]]:
    """Draw and seal cases of a rig: each effect at each size, and controls.

    Parameters
    ----------
    runs, nominal : Path
        Measured runs, and the model calibrated on them.
    out : Path
        Folder of the cases.
    chosen : sequence of str
        Labels of the runs that are taken; all if empty.
    sizes : sequence of float
        Wanted errors, in that of the calibrated model.
    shard : (int, int), optional
        Which cases come first, as in `over_processes`.

    Returns
    -------
    names : list of str
        Folders of the cases.
    skipped : dict of str to str
        Why a case was not drawn.
    """
    rig = rig_of(runs, nominal, chosen)
    code = code_digest(*(f"validation/{name}.py" for name in _DRAWING), engine=False)
    key = f"{digest(runs)} {digest(nominal)} {','.join(chosen)} {seed} {code}"
    calls = [
        ((runs, nominal), tuple(chosen), name, size, seed, out, key)
        for name in names_of(rig)
        for size in sizes
    ]
    drawn = over_processes(_draw, calls, processes, progress, shard)
    names = [folder for folder, reason in drawn if not reason]
    for i, case in enumerate(controls(Source(rig))):
        names.append(f"control_{i}")
        _staged(case, names[-1], out)
    seal(out, names, ("truth.json",))
    return names, {folder: reason for folder, reason in drawn if reason}
