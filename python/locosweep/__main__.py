"""The command line: of the script `locosweep`, and of `python -m locosweep`."""

from __future__ import annotations

import os
import signal
import sys
from typing import Any


def main() -> int:
    """Run the command; Ctrl-C ends it quietly from here on, while it is being imported, too."""
    ours = signal.getsignal(signal.SIGINT) is signal.default_int_handler
    if ours:
        # An exception within an import becomes whatever the import makes of it.
        signal.signal(signal.SIGINT, _end)
    from locosweep.cli import main as run

    if ours:
        signal.signal(signal.SIGINT, signal.default_int_handler)
    return run()


def _end(*_: Any) -> None:
    os.write(2, b"locosweep: interrupted\n")
    os._exit(128 + signal.SIGINT)


if __name__ == "__main__":
    sys.exit(main())
