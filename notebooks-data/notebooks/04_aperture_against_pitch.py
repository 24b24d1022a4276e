# SPDX-License-Identifier: Apache-2.0
# %% [markdown]
# # Aperture against pitch
# A satellite that sees half a metre on the ground: which aperture and which pitch give the best image, what forbids a
# better one, and what would a little more of each number gain? The derivatives are exact, through all of the OTF.

# %%
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import mtfkit as mk

out = Path("notebook-output")
out.mkdir(exist_ok=True)

study = mk.Study.load("notebooks-data/studies/aperture_against_pitch.toml")
table = study.run()
print(study, study.objectives, study.constraints)
print(int(table.feasible.sum()), "feasible")

# %%
data = study.to_xarray(table)
niirs = data["niirs_giqe5"]
niirs.plot.contourf(levels=20)
allowed = data["feasible"]
allowed.astype(float).plot.contour(levels=[0.5], colors="black")
niirs.to_dataframe().to_csv(out / "04_niirs.csv")

# %% [markdown]
# ## The Pareto front

# %%
front = study.pareto(table)
front.to_csv(out / "04_front.csv")
front[["optics.aperture", "frame.pitch", "niirs_giqe5"]].plot.scatter("optics.aperture", "niirs_giqe5", c="frame.pitch",
                                                                      cmap="viridis")
best = front.niirs_giqe5.idxmax()
front.loc[best]

# %% [markdown]
# ## The constraint that binds
# Between the designs of the grid the axes are continuous; the answer names its limits, and what relaxing each would gain.

# %%
optimum = study.optimum(objective=0)
optimum.explain()

# %% [markdown]
# ## The gradient
# Exact derivatives at the best design of the grid, against differences of neighbouring sensors.

# %%
gradient = study.gradient(best).to_pandas()
gradient.to_csv(out / "04_gradient.csv")
gradient.loc[["niirs_giqe5", "mtf_nyquist", "q"]]

# %%
names = [column.name for column in study.columns]
middle = 600
values = list(study.axes(middle).values())
step = 1e-4 * values[1]
near = [study._study.evaluate_at([values[0], values[1] + s])[names.index("niirs_giqe5")] for s in (-step, step)]
slope = (near[1] - near[0]) / (2 * step)
exact = study.gradient(middle).to_pandas().loc["niirs_giqe5", "frame.pitch"]
print(f"d NIIRS / d pitch: {exact:.6f} exact, {slope:.6f} by differences, per um")

# %%
assert best == 1204 and abs(front.niirs_giqe5[best] - 5.2258) < 5e-5
assert int(table.feasible.sum()) == 399 and len(front) == 31
assert optimum.status == "optimal" and study._study.evaluate_at(list(optimum.axes.values()))[
    names.index("niirs_giqe5")] >= front.niirs_giqe5[best] - 1e-6
assert abs(exact - slope) < 2e-3 * abs(slope)
