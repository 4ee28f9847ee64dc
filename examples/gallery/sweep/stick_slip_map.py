"""
Where a segment sticks
======================

A head that is driven by a sine moves, or rests for part of each cycle. The share of time at rest is
simulated with true sticking for 12 000 pairs of drive and static friction.
"""

import matplotlib.pyplot as plt
import numpy as np

import locosweep as ls

r = ls.sweep(
    ["stuck_time", "final_position"],
    law="stribeck",
    drive="sine",
    mu_static=np.linspace(0.3, 0.6, 100),
    mu_coulomb=0.25,
    drive_amplitude=np.linspace(0.5, 2.5, 120),
    duration=2.0,
)

# %%
# On the left, the drive never exceeds static friction: the head rests for all of the 2 s.

r.plot.heatmap(x="drive_amplitude", y="mu_static", value="stuck_time", levels=0)
plt.show()
