"""
Fast or frugal
==============

A stronger drive makes a robot faster, and wastes more: the drive works against its brake, and a
segment that arrives fast loses its energy. Speed and cost of transport of 4000 designs at once.
"""

import matplotlib.pyplot as plt
import numpy as np

import locosweep as ls

# %%
# Two quantities of one grid come from one pass.

r = ls.sweep(
    ["mean_velocity", "cost_of_transport"],
    mu_static=0.6,
    mu_coulomb=0.3,
    stroke=0.02,
    drive_limit=np.linspace(0.8, 4, 400),
    segments=range(3, 13),
)
speed = 1e3 * r["mean_velocity"]
cost = r["cost_of_transport"]

# %%
# Each line is one robot with a drive that gets stronger from left to right.

fig, ax = plt.subplots(layout="constrained")
counts = r.axes["segments"]
colours = plt.get_cmap("viridis")(np.linspace(0, 0.95, counts.size))
for i, (count, colour) in enumerate(zip(counts, colours, strict=True)):
    ax.plot(speed[:, i], cost[:, i], color=colour, label=f"{count:.0f}")
ax.set_xlabel("mean velocity [mm/s]")
ax.set_ylabel("cost of transport")
ax.legend(title="segments", ncols=2)
ax.grid(alpha=0.3)
plt.show()
