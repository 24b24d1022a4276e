# SPDX-License-Identifier: Apache-2.0
# %% [markdown]
# # Accuracy against time
# One number, the tolerance, chooses the method. What is promised is kept, and what it costs is measured: seven tolerances on
# one scene, each against the most exact image that float32 samples allow.

# %%
import time
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd

import mtfkit as mk

out = Path("notebook-output")
out.mkdir(exist_ok=True)

sensor = mk.Sensor(frame=dict(focal_length="100 mm", pitch="15 um"),
                   optics=dict(f_number=2.0),
                   presample=[mk.Defocus(wavelength="4 um", distance="20 um"), mk.Footprint(width="15 um"),
                              mk.Jitter(rms="20 urad")],
                   postsample=[mk.Fir(taps=[[0, -0.25, 0], [-0.25, 2.0, -0.25], [0, -0.25, 0]])])
numbers = np.random.default_rng(1)
scene = numbers.standard_normal((512, 640)).astype("float32")  # detail at all frequencies, no mean

# %%
reachable = None
try:
    sensor.compile(scene, sample="3.75 um", tolerance=1e-12)
except mk.ToleranceError as refused:
    reachable = refused.reachable
    print(refused)
exact = sensor.compile(scene, sample="3.75 um", tolerance=1.01 * reachable)
truth = exact(scene).astype("float64")

# %%
rows = []
for tolerance in (1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 3e-6, 2 * reachable):
    plan = sensor.compile(scene, sample="3.75 um", tolerance=tolerance)
    image = plan(scene, threads=1)
    times = []
    for _ in range(7):
        start = time.process_time()
        plan(scene, out=image, threads=1)
        times.append(1e3 * (time.process_time() - start))
    realised = np.sqrt(np.mean((image - truth) ** 2)) / scene.std()
    rows.append((tolerance, plan.promised, realised, min(times), np.median(times)))
table = pd.DataFrame(rows, columns=["tolerance", "promised", "realised", "ms_min", "ms_median"])
table.to_csv(out / "07_accuracy.csv", index=False)
table

# %%
plt.loglog(table.ms_median, table.promised, "o-", label="promised")
plt.loglog(table.ms_median, table.realised, "s-", label="realised")
plt.xlabel("processor time of a frame [ms]")
plt.ylabel("rms error / std of the scene")
plt.legend()

# %%
assert (table.promised <= table.tolerance * (1 + 1e-12)).all()
assert (table.realised <= table.promised + exact.promised).all()
