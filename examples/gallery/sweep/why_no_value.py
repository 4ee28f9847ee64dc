"""
Why a design does not move
==========================

A point without a value has a status that says why, so a map of failures is as good as one of
speeds.
"""

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.colors import BoundaryNorm
from matplotlib.patches import Patch

import locosweep as ls

r = ls.sweep(
    "mean_velocity",
    mu_static=np.linspace(0.1, 1.0, 300),
    mu_coulomb=0.3,
    slope_deg=np.linspace(-10, 45, 300),
    segments=4,
    drive_limit=1.6,
)
print(r.status_counts())

# %%
# Each status is a whole number; ``ls.Status`` has its sentence.

codes = np.unique(r.status)
ranks = np.searchsorted(codes, r.status)
cmap = plt.get_cmap("cividis", codes.size)

fig, ax = plt.subplots(figsize=(7.5, 5.5), layout="constrained")
norm = BoundaryNorm(np.arange(codes.size + 1) - 0.5, codes.size)
ax.pcolormesh(r.axes["slope_deg"], r.axes["mu_static"], ranks, cmap=cmap, norm=norm)
patches = [Patch(color=cmap(i), label=ls.Status(c).sentence) for i, c in enumerate(codes)]
fig.legend(handles=patches, loc="outside lower center", fontsize=9)
ax.set_xlabel("slope [deg]")
ax.set_ylabel("static friction of the anchors")
plt.show()
