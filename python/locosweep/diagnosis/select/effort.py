"""How much a search tries: all numbers that trade time for thoroughness.

They were set by hand on the cases of `locosweep blind-check --cases 60 --gap-free 20 --seed 3101`
and `benches/diagnosis.py`: at these values the first of them had as many right verdicts as the
search before, in less processor time. None was varied alone.
"""

from __future__ import annotations

STRONGEST_SCALING = 4.0
"""Factor on a start up to which an effect is taken to act in proportion. A start that promises
most as weak as one part in so many, or weaker, is evaluated again at that strength."""
LEAST_ERROR = 10.0
"""Mean square of the equation error, in that of noise, from which few starts besides its own
are replayed; above which the best pair says that none makes the forces of the measured motion; and
what a law of some variables leaves over what laws of all leave, above which it is none."""
STARTS = 2
"""Starts of an effect that are refined by equation error."""
ROWS_REPLAYED = 6
"""Starts of an effect that are replayed beside these; as many for each of its parameters where
the equation error says little."""
INFORMATIVE_RUNS = 2
"""Runs that starts are replayed on, more of many: those that hold most of what a fit leaves."""
PARTNERS = 8
"""Further effects that are fitted beside those found; pairs that are fitted at first, of those that
the equation error and of those that replays propose; rounds in which a fit is tried again from
around its end."""
SHARE = 0.5
"""Share of the best one's gain in chi2 that others have to promise, and after a few steps to
show, to be followed."""
SLACK = 200.0
"""Scores further behind the best one than this, by what derivatives promise, are out of reach
of it also along a valley that bends."""
FEW = 3
"""Steps after which starts that lie far behind are left; starts of an effect that are followed by
replays where the equation error is not sure; fits that go first; effects whose bent or further
valleys or thresholds are looked into, and values that a threshold is fitted again from."""
LEVEL_WORK = 5e3
"""Work, in replays of all runs through the nominal model, after which no further set of a level
is extended, nor exchanged."""
