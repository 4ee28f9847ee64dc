"""The command line as `python -m locosweep`, where its script is not on the path."""

import sys

from locosweep.cli import main

if __name__ == "__main__":
    sys.exit(main())
