"""
What an effect does to a run
============================

A model replays the drive of a measured run. With an effect added it shows what that effect would
have done, which is what a diagnosis compares.
"""

import matplotlib.pyplot as plt
import numpy as np

import locosweep as ls
from locosweep.files.runs import Run
from locosweep.replay import replay_runs

# %%
# Three pushes, of which the last is the strongest.

t = np.arange(0.0, 1.9, 0.005)
drive = np.select([(t >= s) & (t < s + 0.35) for s in (0.1, 0.7, 1.3)], [0.7, 0.85, 1.3], 0.0)
rest = np.zeros(t.size)
run = Run("pushes", t, drive, {"x": rest, "v": rest})

nominal = {"mass": 0.271, "mu_coulomb": 0.2}
effects = {
    "nominal model": {},
    "actuator gives 0.9 N at most": {"drive_saturation": {"F_max": 0.9}},
    "lubricant piles up, 6 N/m": {"lubricant_buildup": {"k_b": 6.0}},
    "drive acts 30 ms late": {"drive_delay": {"T": 0.03}},
    "head 50 g heavier": {"payload_mass": {"dm": 0.05}},
}

# %%
# Above the motion, below the difference to the nominal model: each effect has a shape of its own.

found = {
    words: replay_runs(ls.Robot(nominal, effects=added), [run])["x"].to_numpy()
    for words, added in effects.items()
}
fig, (above, below) = plt.subplots(2, 1, sharex=True, figsize=(7.5, 6), layout="constrained")
lines = ("-", "--", "-.", ":", (0, (5, 1, 1, 1, 1, 1)))
for (words, x), style in zip(found.items(), lines, strict=True):
    above.plot(t, 1e3 * x, linestyle=style, label=words)
    below.plot(t, 1e3 * (x - found["nominal model"]), linestyle=style)
above.set_ylabel("position [mm]")
above.legend(fontsize=9)
below.set_ylabel("less the nominal position [mm]")
below.set_xlabel("time [s]")
for ax in (above, below):
    ax.grid(alpha=0.3)
plt.show()
