"""
A whole robot through its gait
==============================

Closed forms say how fast a robot is. The simulation also says who slides while it gets there: here
anchors that do not hold the drive slip back.
"""

import matplotlib.pyplot as plt

import locosweep as ls
from locosweep.plot.gait import space_time

run = ls.run_gait(
    "single",
    segments=4,
    mu_static=0.32,
    mu_coulomb=0.28,
    drive_limit=2.4,
    stroke=0.02,
    cycles=2,
)
print(run)

# %%
# Every band is a segment, from the head at the top. Colours tell how it slides.

space_time(run)
plt.show()
