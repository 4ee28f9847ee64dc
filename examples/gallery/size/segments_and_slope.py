"""
Speed over segments, on several slopes
======================================

The paper's robot on level ground and on slopes. On a slope, the anchors have to hold the weight of
the robot too, so more of them are needed before it moves at all.
"""

import matplotlib.pyplot as plt

import locosweep as ls

r = ls.sweep(
    "mean_velocity",
    mu_static=0.5,
    mu_coulomb=0.3,
    stroke=0.02,
    slope_deg=[0, 4, 8, 12],
    segments=range(2, 21),
)

# %%
# A star marks the fastest robot of each line. A line begins where the anchors hold.

r.plot.curves("segments", by="slope_deg", mark_optimum=True)
plt.show()
