"""
The gap of the paper's robot, explained
=======================================

Runs of a robot whose actuator is weaker than its commands, and which pushes lubricant up in front
of it. The nominal model knows of neither. A diagnosis finds both effects, fits them, and checks
them on runs that were kept from the fit.
"""

import tempfile

import matplotlib.pyplot as plt

import locosweep as ls
from locosweep.diagnosis.report.figures_motion import channel_over_time, residual_over_time
from locosweep.paper.gap import paper_gap

# %%
# The two files that you would bring: ``runs.csv`` and ``nominal.toml``.

runs, nominal = paper_gap(tempfile.mkdtemp())
found = ls.diagnose(runs, nominal)
print(found.summary)
print(f"error before {1e3 * found.gap['before']:.2f} mm, after {1e3 * found.gap['after']:.4f} mm")

# %%
# One run that was kept from the fit: the motion, and what each of the two models leaves of it.

kept = next(trace for trace in found.traces if trace.held_out)
fig, axes = plt.subplots(3, 1, sharex=True, figsize=(7.5, 7), layout="constrained")
channel_over_time(found, kept, "x", axes[0])
residual_over_time(found, kept, axes[1], after=False)
residual_over_time(found, kept, axes[2], after=True)
axes[0].legend(fontsize=9)
axes[0].set_title("a run that no model has seen before")
axes[2].set_xlabel("time [s]")
plt.show()
