"""
The best number of segments
===========================

More segments anchor a snake robot better, but a gait with more segments takes longer. The best
count depends on the slope and on the friction of the anchors. Here it is found for 40 000 pairs.
"""

import matplotlib.pyplot as plt
import numpy as np

import locosweep as ls

# %%
# The axis ``segments`` is folded away while the sweep runs: of each column of 63 speeds only
# the segment count of the largest one is kept.

best = ls.sweep(
    "mean_velocity",
    mu_static=np.linspace(0.1, 1.0, 200),
    mu_coulomb=0.3,
    slope_deg=np.linspace(0, 25, 200),
    segments=range(2, 65),
    over="segments",
    reduce="argmax",
)
print(best)

# %%
# Hatched cells have no best count. The legend says why.

best.plot.heatmap(x="slope_deg", y="mu_static")
plt.show()
