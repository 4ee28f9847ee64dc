"""
Friction laws side by side
==========================

Four of the 29 friction laws with the same levels. They agree at speed and differ where robots
crawl: close to rest.
"""

import matplotlib.pyplot as plt

import locosweep as ls
from locosweep.plot import characteristic
from locosweep.simulation.law_data import characteristic_of

print(len(ls.laws()), "laws")

values = {"mu_static": 0.5, "mu_coulomb": 0.3, "viscous": 2.0}
names = ["coulomb", "stribeck", "mixed", "lugre"]

# %%
# A bar at rest: friction takes any value up to it, so the head sticks. A dotted line: bristles give
# way before the head slides.

characteristic(*(characteristic_of(name, **values) for name in names))
plt.show()
