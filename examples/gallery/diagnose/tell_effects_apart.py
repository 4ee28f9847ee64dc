"""
Which effects could this experiment tell apart?
===============================================

Before anything is measured: would the planned runs show an effect, and could they tell it from the
others? Small distances between two effects mean that any diagnosis of such runs will name both.
"""

import matplotlib.pyplot as plt
import numpy as np

import locosweep as ls

# %%
# The head is pushed twice, with one force. Only its position is measured, to 0.1 mm.

robot = ls.Robot({"mass": 0.271, "segments": 4.0, "mu_coulomb": 0.15})
t = np.arange(0.0, 1.2, 0.01)
push = np.where((t % 0.6) < 0.35, 0.6, 0.0)
plan = ls.distinguish(robot, {"push": (t, push)}, noise={"x": 1e-4})
print("viscous friction could be mistaken for", ", ".join(plan.rivals("viscous_friction")))

# %%
# Every row is the effect that is really there, every column one that is fitted in its place.

fig, ax = plt.subplots(figsize=(9, 8), layout="constrained")
plan.plot(ax)
plt.show()
