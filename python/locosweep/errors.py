"""Everything that locosweep raises."""


class LocosweepError(Exception):
    """Base of all errors of this package."""


class InputError(LocosweepError, ValueError):
    """An argument is not allowed; the message names it, its value and what is."""


class DataFileError(InputError):
    """A file is not what it should be; the message names file, position and reason."""


class SolveError(LocosweepError, RuntimeError):
    """The motion asked for could not be computed: events too close, or without bounds."""


class Cancelled(LocosweepError):
    """A sweep was stopped through its token."""


class InternalError(LocosweepError):
    """A fault of locosweep itself, never of its input. Please report it."""
