"""
How likely is it that the robot climbs?
=======================================

Static and sliding friction of a pipe were measured with a spread of 15 %. The chance that a robot
moves at all, over slope and number of segments.
"""

import matplotlib.pyplot as plt
import numpy as np
from scipy.stats import norm

import locosweep as ls

# %%
# 200 equally likely values of each coefficient, the inverse of the normal distribution at evenly
# spaced shares. One sweep has all pairs: 60 slopes, 9 counts, 40 000 pairs.

shares = (np.arange(200) + 0.5) / 200
mu_static = norm.ppf(shares, 0.5, 0.075)
mu_coulomb = norm.ppf(shares, 0.3, 0.045)
slopes = np.linspace(0, 24, 60)

r = ls.sweep(
    "feasible",
    slope_deg=slopes,
    segments=range(3, 12),
    mu_static=mu_static,
    mu_coulomb=mu_coulomb,
    over="mu_coulomb",
    reduce="mean",
)
chance = r.values.mean(axis=r.values.ndim - 1)

# %%
# The closed form says "moves" or "does not". The chance is the share of pairs that move.

fig, ax = plt.subplots(layout="constrained")
image = ax.pcolormesh(slopes, r.axes["segments"], 100 * chance.T, cmap="cividis", shading="nearest")
lines = ax.contour(slopes, r.axes["segments"], 100 * chance.T, levels=[50, 90, 99], colors="white")
ax.clabel(lines, fmt="%d %%")
fig.colorbar(image, label="chance that the robot moves [%]")
ax.set_xlabel("slope [deg]")
ax.set_ylabel("segments")
plt.show()
