"""How much a search tries: all numbers that trade time for thoroughness.

Set by `benches/search.py`, which counts the single effects and pairs whose best fit a search
misses, on cases of the blind check, and what it replays for that.
"""

from __future__ import annotations

STRONGEST_SCALING = 4.0
"""Factor on a start up to which an effect is taken to act in proportion."""
LEAST_ERROR = 10.0
"""Mean square of the equation error, in that of noise, from which it alone says where to
start."""
ROWS_REFINED = 2
"""Starts of an effect that are refined by equation error, those that promise most."""
PAIRS_REFINED = 24
"""Pairs of effects that are refined by equation error."""
PAIRS_FOLLOWED = 8
"""Pairs of these that are fitted by replays."""
ROWS_REPLAYED = 8
"""Starts of an effect that are replayed beside these; three times as many of one that the
equation error does not see."""
FOLLOWED = 2
"""Starts of such an effect that are fitted."""
INFORMATIVE_RUNS = 2
"""Runs that starts are replayed on: those that hold most of what a fit leaves."""
PARTNERS = 8
"""Further effects that are fitted beside those found, after their starts are replayed."""
SHARE = 0.5
"""Share of the best one's gain in chi2 that others have to promise, and after a few steps to
show, to be followed."""
SEEDS = 4
"""Sets that a further effect is added to."""
HINT = 5.0
"""Gain in chi2 that a start has to promise beside a model that leaves only noise."""
SLACK = 200.0
"""Scores further behind the best one than this, by what derivatives promise, are out of reach
of it also along a valley that bends."""
