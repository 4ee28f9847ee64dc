"""
Which friction law do measured forces follow?
=============================================

Friction forces of a seal that is pushed to and fro are fitted with several laws. Here the forces
are made, so the right answer is known: Stribeck friction.
"""

import matplotlib.pyplot as plt
import numpy as np

import locosweep as ls

rng = np.random.default_rng(1)
t = np.arange(0.0, 8.0, 0.005)
levels = [0.004, 0.02, 0.06, 0.12]

# %%
# Four runs to and fro at growing speeds; 2 N of Coulomb friction, 3 N at rest, 4 N s/m viscous.

columns: dict[str, list[np.ndarray]] = {name: [] for name in ("run", "t", "x", "force")}
for label, top in enumerate(levels):
    v = top * np.sin(2 * np.pi * t / 4)
    force = np.sign(v) * (2 + np.exp(-((v / 0.01) ** 2))) + 4 * v
    columns["run"].append(np.full(t.size, label))
    columns["t"].append(t)
    columns["x"].append(-top * 4 / (2 * np.pi) * np.cos(2 * np.pi * t / 4))
    columns["force"].append(force + rng.normal(0, 0.03, t.size))
data = {name: np.concatenate(parts) for name, parts in columns.items()}

fit = ls.fit_friction(data, holdout=["2"], laws=["coulomb", "coulomb_viscous", "stribeck"])
print(fit.summary)

# %%
# The laws stand in the order of their error on the run that was held out.

v = np.linspace(-0.13, 0.13, 800)
fig, ax = plt.subplots(layout="constrained")
measured = np.concatenate([np.gradient(x, t) for x in columns["x"]])
ax.plot(1e3 * measured, data["force"], ".", ms=2, color="0.6", label="samples")
for law, style in zip(fit.laws, ("-", "--", ":"), strict=True):
    ax.plot(1e3 * v, law.force(v), style, lw=2, zorder=4, label=law.law)
ax.set_xlabel("velocity [mm/s]")
ax.set_ylabel("friction force [N]")
ax.legend()
ax.grid(alpha=0.3)
plt.show()
