# SPDX-License-Identifier: Apache-2.0
# %% [markdown]
# # From kelvin to counts: the NETD by budget, and from 200 frames
# The noise-equivalent temperature difference can be worked out, and it can be measured: frames of two flat scenes, their
# difference and their noise. Both ways have to agree within the scatter of the measurement, for a cooled photon detector
# and for an uncooled microbolometer.

# %%
import subprocess
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd

import mtfkit as mk

out = Path("notebook-output")
out.mkdir(exist_ok=True)
subprocess.run(["mtf", "demo", "-o", "mtf-demo", "--force"], check=True, capture_output=True)
cameras = {"cooled": (mk.Sensor.load("mtf-demo/camera.toml"), "dn"),
           "uncooled": (mk.Sensor.load("mtf-demo/uncooled.toml"), "dn")}
{name: camera.budget(temperature="300 K")["netd"] for name, (camera, _) in cameras.items()}

# %% [markdown]
# ## 200 frames
# The signal is the difference of the mean images of 299.5 K and 300.5 K, about the temperature of the budget, the noise the standard deviation over the frames of each
# pixel in both, so that what is fixed in the image does not count. Frames are numbered: the same number is the same noise.

# %%
frames, pixels = 200, 48


def measured(camera, stage, count=frames):
    """NETD of every pixel in mK, from flat scenes."""
    pitch = 4
    def stack(kelvin, first):
        scene = np.full((pitch * pixels, pitch * pixels), kelvin, "float32")
        plan = camera.compile(scene, sample="0.25 px", quantity="temperature", stage=stage, threads=1)
        return np.array([plan(scene, frame=first + i) for i in range(count)], "float64")
    cold, hot = stack(299.5, 0), stack(300.5, count)
    signal = hot.mean(axis=(0, 1, 2)) - cold.mean(axis=(0, 1, 2))
    noise = np.sqrt(0.5 * (cold.var(axis=0, ddof=1) + hot.var(axis=0, ddof=1)))
    return 1e3 * noise / signal


rows = []
for name, (camera, stage) in cameras.items():
    netd = measured(camera, stage)
    value = np.sqrt((netd ** 2).mean())
    # The variance of each of n pixels is estimated from N frames of either scene.
    scatter = value / np.sqrt(2 * 2 * (frames - 1) * netd.size)
    rows.append((name, camera.budget(temperature="300 K")["netd"].to("mK"), value, scatter))
    plt.hist(netd.ravel() / value, bins=40, histtype="step", density=True, label=name)
plt.xlabel("NETD of a pixel / mean")
plt.legend()
table = pd.DataFrame(rows, columns=["camera", "budget_mK", "measured_mK", "sd_mK"])
table["ratio"] = table.measured_mK / table.budget_mK
table.to_csv(out / "05_netd.csv", index=False)
table

# %%
for row in table.itertuples():
    # Four standard deviations of the estimate, and what a difference of 1 K is off as a slope: its third derivative, 1e-4.
    assert abs(row.measured_mK - row.budget_mK) < 4 * row.sd_mK + 1e-3 * row.budget_mK
