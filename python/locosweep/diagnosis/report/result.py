"""Result of a diagnosis: the report, its runs, the nominal and the augmented model."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from locosweep.files.strict_json import as_json

if TYPE_CHECKING:
    import os

    import numpy as np
    from numpy.typing import NDArray

    from locosweep.files.robot import Robot

    Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Trace:
    """One run, measured and replayed without looking back at the measurement.

    Attributes
    ----------
    label : str
        Name of the run in its file.
    t, drive : ndarray
        Times in s since the run's start, and commands, one a sample.
    slope_deg : float
        Slope of the ground.
    measured : dict of str to ndarray
        What was measured (x, v, force, x_rear, power), NaN where missing.
    nominal, augmented : dict of str to ndarray
        What the sensors would read under the nominal model, and with the effects
        that were found (equal where none was).
    regime : ndarray of int
        Index in `REGIMES` of every sample.
    held_out : bool
        Whether the run was kept from the fit.
    """

    label: str
    t: Floats
    drive: Floats
    slope_deg: float
    measured: dict[str, Floats]
    nominal: dict[str, Floats]
    augmented: dict[str, Floats]
    regime: NDArray[np.int64]
    held_out: bool


@dataclass(frozen=True, repr=False)
class Diagnosis:
    """Localization of the gap, its cause, and the reduction of the validation error.

    Everything in the report is an attribute too: `status`, `effects`,
    `probability`, `equivalent`, `alternatives`, `law_mismatch`, `summary`, `gap`,
    `where`, `candidates`, `not_visible`, `next_experiment`, `warnings`, `provenance`.

    Attributes
    ----------
    report : dict
        What report.json holds.
    traces : tuple of Trace
        The runs, in the order of their file.
    nominal, augmented : Robot
        The model as handed in, and with the effects that were found.
    details : dict
        Further tables for pictures: ``force_view`` maps a variable (v, x, t,
        drive, distance) to centres, residual force in N and half width of its
        95 % interval; ``noise`` a channel to its standard deviation; ``free_runs`` the error
        in x over the length of free runs, by model; ``stages`` the readings by cause, channel
        and run that the model predicts with the causes up to this one, the last one (the
        augmented model) left out; ``made`` the day of the diagnosis;
        ``nominal_text`` the text of the nominal file.
    """

    report: dict[str, Any]
    traces: tuple[Trace, ...]
    nominal: Robot
    augmented: Robot
    details: dict[str, Any] = field(default_factory=dict)

    @property
    def status(self) -> str:
        """``explained``, ``ambiguous``, ``partial``, ``none`` or ``unexplained``."""
        return str(self.report["verdict"]["status"])

    @property
    def effects(self) -> list[str]:
        """One effect for each cause, most important first."""
        return list(self.report["verdict"]["effects"])

    @property
    def probability(self) -> float:
        """Probability that the verdict is right."""
        return float(self.report["verdict"]["probability"])

    @property
    def equivalent(self) -> list[list[str]]:
        """For each effect those that these runs cannot tell from it, itself included."""
        return [list(names) for names in self.report["verdict"]["equivalent"]]

    @property
    def alternatives(self) -> list[list[str]]:
        """Other sets of effects that explain the runs as well."""
        return [list(names) for names in self.report["verdict"]["alternatives"]]

    @property
    def law_mismatch(self) -> bool:
        """True if the cause acts by another law than the effect's formula."""
        return bool(self.report["verdict"]["law_mismatch"])

    @property
    def contributions(self) -> list[dict[str, Any]]:
        """Causes in order: `effects` (a class), `share` of the gap on unseen data, `alone`."""
        return list(self.report["verdict"]["contributions"])

    @property
    def remaining(self) -> dict[str, Any]:
        """What nobody has explained: `share` of the gap, `rmse`, `noise_floors`, `shape`."""
        return dict(self.report["verdict"]["remaining"])

    @property
    def unlisted(self) -> dict[str, Any] | None:
        """What a cause that is in no list looks like, if one does better than any effect."""
        found = self.report["verdict"]["unlisted"]
        return None if found is None else dict(found)

    @property
    def laws(self) -> list[dict[str, Any]]:
        """Causes by another law than their formula: `effect`, `variable`, `formula`, `curve`."""
        return list(self.report["verdict"]["laws"])

    @property
    def summary(self) -> str:
        """The verdict in a sentence."""
        return str(self.report["verdict"]["summary"])

    @property
    def gap(self) -> dict[str, Any]:
        """Size of the gap, before and after, on runs kept from the fit."""
        return dict(self.report["gap"])

    @property
    def where(self) -> dict[str, Any]:
        """Channels, runs, windows and regimes that hold the gap, and its site."""
        return dict(self.report["where"])

    @property
    def candidates(self) -> list[dict[str, Any]]:
        """Sets of effects that were fitted: probability, error reduction, parameters."""
        return list(self.report["candidates"])

    @property
    def not_visible(self) -> list[dict[str, Any]]:
        """Effects that are not identifiable from these runs, and why."""
        return list(self.report["not_visible"])

    @property
    def next_experiment(self) -> dict[str, Any]:
        """The run that would separate what is left."""
        return dict(self.report["next_experiment"])

    @property
    def warnings(self) -> list[str]:
        """Limits of this diagnosis, one sentence each."""
        return list(self.report["warnings"])

    @property
    def provenance(self) -> dict[str, Any]:
        """Version, checksums of the files, seed."""
        return dict(self.report["provenance"])

    def save(
        self, out: str | os.PathLike[str], *, force: bool = False, command: str | None = None
    ) -> None:
        """Write report.json, augmented.toml, report.html, report.md and the pictures.

        Parameters
        ----------
        out : path-like
            The folder; made if missing. It is written as a whole or not at all.
        force : bool
            Allow a folder that is not empty; what else is in it stays.
        command : str, optional
            How the report was made, kept in the page and in the pictures.

        Raises
        ------
        InputError
            The folder cannot be written, or is not empty.
        """
        from locosweep.diagnosis.report.figures import FILES, pictures
        from locosweep.diagnosis.report.model_file import write_augmented
        from locosweep.diagnosis.report.page import page
        from locosweep.files.folder import filling
        from locosweep.plot.save import lay_out, save_figure

        names = ("report.json", "augmented.toml", "report.html", "report.md", *FILES)
        with filling(out, names, force=force) as folder:
            shown = {}
            for name, figure in pictures(self).items():
                lay_out(figure)
                save_figure(figure, folder / name, command=command)
                shown[name] = (folder / name).read_bytes()
            for name, text in (("report.json", report_text(self.report)),
                               ("report.html", page(self, shown, command)),
                               ("report.md", self.to_markdown())):  # fmt: skip
                (folder / name).write_text(text, encoding="utf-8", newline="\n")
            given = self.details.get("nominal_text")
            write_augmented(self.augmented, folder / "augmented.toml", given)

    def to_markdown(self) -> str:
        """Return the report in short as Markdown, for a pull request or an issue.

        The verdict, what to do, what each cause takes away, the gap before and after, warnings
        and where all comes from. ``save`` writes it as report.md.
        """
        from locosweep.diagnosis.report.markdown import markdown

        return markdown(self)

    def __repr__(self) -> str:
        from locosweep.diagnosis.report.sentences import advice

        lines = [
            f"Diagnosis: {self.status}, probability {self.probability:.2f}",
            f"  {self.summary}",
        ]
        if todo := advice(self.report):
            lines.append(f"  {todo}")
        shrink, gap = self.gap.get("shrink"), self.gap
        if shrink is not None:
            lines.append(
                f"  gap in {gap['channel']}: {gap['before']:.3g} -> {gap['after']:.3g} "
                f"{gap['unit']} on runs kept from the fit"
            )
        lines += [f"  note: {warning}" for warning in self.warnings]
        return "\n".join(lines)

    def _repr_html_(self) -> str:
        from locosweep.diagnosis.report.page import short

        return short(self)


def report_text(report: dict[str, Any]) -> str:
    r"""Return report.json: the same report gives the same bytes.

    Examples
    --------
    >>> from locosweep.diagnosis.report.result import report_text
    >>> report_text({"before": 0.1, "after": float("nan")})
    '{\n  "before": 0.1,\n  "after": null\n}\n'
    """
    return as_json(report) + "\n"
