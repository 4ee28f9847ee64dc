"""
A sweep that is stored and resumed
==================================

A sweep of hours should survive the end of its process. In a run folder it is stored chunk by chunk,
and the same call goes on where it was ended. Needs ``pip install locosweep[runs]``.
"""

import tempfile
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import locosweep as ls

grid = ls.Grid(
    mu_static=np.linspace(0.2, 0.9, 300),
    mu_coulomb=0.3,
    slope_deg=np.linspace(0, 20, 200),
    segments=range(2, 22),
)
folder = Path(tempfile.mkdtemp()) / "run"

# %%
# Here its own progress ends the sweep, as Ctrl-C or a cluster would: a third of it is done.

token = ls.CancelToken()


def after_some(done: int, total: int, rate: float) -> None:
    """Stop after a third."""
    if 3 * done >= total:
        token.cancel()


try:
    ls.sweep("mean_velocity", grid, out=folder, chunk=100_000, token=token, progress=after_some)
except ls.Cancelled:
    print("ended early: ", end="")
print(f"{len(ls.open_run(folder, allow_missing=True).missing)} chunks are missing")

# %%
# The same call again computes what is missing and nothing else. Every chunk is held against its
# SHA-256 when it is read.

run = ls.sweep("mean_velocity", grid, out=folder, chunk=100_000)
print(f"{len(run.missing)} chunks are missing")

# %%
# Only the part that is looked at is read.

speed = run.to_xarray()["mean_velocity"]
fig, ax = plt.subplots(layout="constrained")
speed.sel(segments=6).plot(ax=ax, cmap="viridis", cbar_kwargs={"label": "mean velocity [m/s]"})
ax.set_title("six segments; white: the robot does not move")
ax.set_xlabel("slope [deg]")
ax.set_ylabel("static friction of the anchors")
plt.show()
