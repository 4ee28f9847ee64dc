"""
A segment count for friction that is not known
==============================================

The friction of the ground is between 0.2 and 0.5, and nobody can say more. The segment count that
is best for one value may be poor for another. Which one is good in most cases?
"""

import matplotlib.pyplot as plt
import numpy as np

import locosweep as ls

# %%
# The unknown becomes an axis with equally likely values; a quantile folds it away. The 10 %
# quantile is the speed that the robot exceeds in nine of ten cases.

unknown = np.linspace(0.2, 0.5, 401)
grid = ls.Grid(mu_static=0.5, mu_coulomb=unknown, slope_deg=9, segments=range(3, 21))
given = {"over": "mu_coulomb", "reduce": "quantile"}
low, middle, high = (
    ls.sweep("mean_velocity", grid, stroke=0.02, q=q, **given) for q in (0.1, 0.5, 0.9)
)
segments = low.axes["segments"]
moving = ls.sweep("mean_velocity", grid, stroke=0.02, over="mu_coulomb", reduce="count").values

# %%
# A point that does not move has no speed and takes no part in a quantile. So only counts of
# segments that move in all cases are compared.

sure = moving == unknown.size
robust = segments[sure][np.argmax(low.values[sure])]
likely = segments[sure][np.argmax(middle.values[sure])]
print(f"best in nine of ten cases: {robust:.0f} segments; best for the median: {likely:.0f}")

fig, ax = plt.subplots(layout="constrained")
ax.fill_between(segments[sure], 1e3 * low.values[sure], 1e3 * high.values[sure], alpha=0.3,
                label="80 % of what friction may be")  # fmt: skip
ax.plot(segments[sure], 1e3 * middle.values[sure], label="median")
ax.set_xticks(range(4, 21, 2))
ax.axvline(robust, color="0.3", linestyle="--", label="best in nine of ten cases")
ax.set_xlabel("segments")
ax.set_ylabel("mean velocity [mm/s]")
ax.legend()
ax.grid(alpha=0.3)
plt.show()
