"""What every kind of blind check is asked, and the steps that all of them share."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import click

from locosweep.cli.options import meter, show

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence
    from pathlib import Path

    from locosweep.progress import JsonLines, Meter
    from locosweep.validation.check import Outcome


@dataclass(frozen=True)
class Asked:
    """Options of a blind check of any cases, and the command as it was typed."""

    seed: int
    out: Path
    draw_only: bool
    force: bool
    quiet: bool
    threads: int | None
    json_: bool
    command: str
    shard: tuple[int, int] | None = None

    @cached_property
    def processes(self) -> int:
        """How many processes draw and diagnose."""
        from locosweep import _core

        return _core.threads_to_use(self.threads)

    def make_folder(self, **cases: object) -> None:
        """Make the folder of the check, or go on in one with the same seed and kind of cases."""
        from locosweep.kept_work.begun import begin
        from locosweep.kept_work.staged import sweep_staged

        begin(self.out, {"seed": self.seed, **cases}, force=self.force)
        sweep_staged(self.out / "diagnoses")

    def meter(self, doing: str) -> Meter | JsonLines | None:
        """Return the progress of one step, None where nobody looks at it."""
        return meter(doing, "cases", quiet=self.quiet)

    def diagnosed(self, names: Sequence[str], **drawn: object) -> list[Outcome] | None:
        """Say how the truths are sealed, and diagnose the cases; None if they are only drawn.

        `drawn` is shown beside their number where they are only drawn.
        """
        from locosweep.validation.check import diagnose_cases

        if not self.quiet:
            click.echo(f"truths sealed: {self._seal}, sha256 {self._sealed}", err=True)
        if self.draw_only:
            show(self.json_, {"cases": len(names), **drawn, "sealed": self._sealed}, self.out)
            return None
        return diagnose_cases(
            self.out, names, seed=self.seed, processes=self.processes,
            progress=self.meter("diagnosing"), shard=self.shard,
        )  # fmt: skip

    @property
    def about(self) -> dict[str, Any]:
        """Where the figures come from."""
        from locosweep import _core

        return {
            "command": self.command,
            "locosweep": _core.version(),
            "seed": self.seed,
            "sealed_sha256": self._sealed,
        }

    def write(self, found: Mapping[str, Any], text: str, *more: str) -> None:
        """Write figures and table, and show them; `more` lines are only shown."""
        from locosweep.files.atomic import write_text
        from locosweep.files.strict_json import as_json

        write_text(self.out / "metrics.json", as_json(found) + "\n")
        write_text(self.out / "table.txt", text)
        show(self.json_, dict(found), text, *more)

    @property
    def _seal(self) -> Path:
        from locosweep.validation.case_files import SEAL

        return self.out / SEAL

    @property
    def _sealed(self) -> str:
        from locosweep.kept_work.records import digest

        return digest(self._seal)
