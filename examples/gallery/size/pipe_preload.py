"""
Pressing against the wall of a pipe
===================================

In a steep pipe, weight alone does not anchor a robot: something has to press its segments to the
wall. The least force that is enough, over the slope of the pipe and the friction of its wall.
"""

import matplotlib.pyplot as plt
import numpy as np

import locosweep as ls

# %%
# Four segments of 271 g of which one moves at a time. The wall holds the anchors by static
# friction; the moving segment slides with half of it.

mu = np.linspace(0.2, 1.0, 160)
slope = np.linspace(0, 90, 181)
rows = [
    ls.sweep("preload", mu_static=m, mu_coulomb=m / 2, slope_deg=slope, segments=4).values
    for m in mu
]

# %%
# Sliding friction follows static friction here, so the map is put together row by row. Below the
# white line, weight alone anchors the robot.

fig, ax = plt.subplots(layout="constrained")
image = ax.pcolormesh(slope, mu, np.array(rows), cmap="viridis", shading="nearest")
ax.contour(slope, mu, np.array(rows), levels=[1e-9], colors="white")
fig.colorbar(image, label="least preload of each segment [N]")
ax.set_xlabel("slope of the pipe [deg]")
ax.set_ylabel("static friction of the wall")
ax.set_title(
    "Preload so that four segments climb, sliding friction half of static\n"
    "left of the white line: none"
)
plt.show()
