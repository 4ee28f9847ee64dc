"""
A hundred thousand million points
=================================

A virtual grid stores nothing. It computes what is taken from it, so its size does not matter. Needs
``pip install locosweep[xarray]``.
"""

import matplotlib.pyplot as plt

import locosweep as ls
from locosweep.specs.span import Span

spec = ls.Spec(
    ("mean_velocity",),
    (
        ("mu_static", Span(0.2, 0.9, 10_000)),
        ("slope_deg", Span(0, 20, 10_000)),
        ("mass", Span(0.1, 1.0, 1000)),
    ),
    (("mu_coulomb", 0.3), ("segments", 4)),
)
grid = ls.open_grid(spec)
print(f"{grid['mean_velocity'].size:.0e} points")

# %%
# A coarse look at one plane computes 250 000 of them, a closer one where the robot just moves as
# many again.

plane = grid["mean_velocity"].sel(mass=0.27, method="nearest")
coarse = plane.isel(mu_static=slice(0, None, 20), slope_deg=slice(0, None, 20))
close = plane.sel(mu_static=slice(0.325, 0.36), slope_deg=slice(9.5, 10.5))

fig, (left, right) = plt.subplots(1, 2, figsize=(10, 4), layout="constrained")
(1e3 * coarse).plot(ax=left, cbar_kwargs={"label": "mean velocity [mm/s]"})
(1e3 * close).plot(ax=right, cbar_kwargs={"label": "mean velocity [mm/s]"})
for ax, title in ((left, "every 20th point"), (right, "every point of a part")):
    ax.set_title(f"{title}; white: no motion")
    ax.set_xlabel("slope [deg]")
    ax.set_ylabel("static friction of the anchors")
plt.show()
