"""
Which design holds, and what to measure first?
==============================================

Three things are known only roughly: both friction coefficients and the slope. How many segments
make at least 5 cm/s all the same, and which of the three is worth a measurement?
"""

import matplotlib.pyplot as plt

import locosweep as ls

# %%
# Each unknown is a distribution; sliding friction is given as a share of static friction. Every
# count of segments is tried at the same 16384 points.

unknown = {
    "mu_static": "0.4:0.6",
    "mu_coulomb/mu_static": "0.5:0.9",
    "slope_deg": "normal:8:2",
}
p = ls.propagate("mean_velocity", unknown, need=">= 0.05", segments=range(3, 21), stroke=0.02)
print(p)

# %%
# The share of points that meet the need is largest at five and six segments, although the median
# alone would not tell them from four.

p.plot()
plt.show()

# %%
# Static friction and the slope make nearly all of the variance: measure these two. Where the robot
# does not move, its speed counts as 0.

s = ls.sensitivity("mean_velocity", unknown, failed=0.0, segments=5, stroke=0.02)
print(s)
s.plot()
plt.show()
