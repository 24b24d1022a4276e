# SPDX-License-Identifier: Apache-2.0
# %% [markdown]
# # A first sensor in five minutes
# A sensor is a product of OTFs. Here one is built of keywords, its curves are drawn, and a sine goes through it: the
# modulation of the image is the MTF, to one part in ten thousand.

# %%
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd

import mtfkit as mk

out = Path("notebook-output")
out.mkdir(exist_ok=True)

sensor = mk.Sensor(name="MWIR staring camera", frame=dict(focal_length="100 mm", pitch="15 um"),
                   scene=dict(sample="3.75 um", border="periodic"), optics=dict(f_number=2.0, wavelength="4 um"),
                   presample=["diffraction", mk.Footprint(width="15 um"), mk.Jitter(rms="20 urad")])
sensor.explain()

# %% [markdown]
# ## Its curves
# A column for each component, the last one for the whole. Frequencies are cycles/mm at the focal plane; `unit="cy/px"` and
# `"cy/mrad"` are others.

# %%
curves = sensor.curves(np.linspace(0, 80, 161))
table = curves.to_pandas()
table.to_csv(out / "01_curves.csv")
table.plot(ylim=(0, 1), ylabel="MTF", xlabel="cycles/mm")
plt.axvline(curves.nyquist, color="grey", linestyle=":")

# %% [markdown]
# ## A sine through it
# The scene has four samples a pixel and a whole number of cycles, so that its image repeats exactly.

# %%
samples, ratio = 512, 4
rows = []
for cycles in (4, 12, 24, 36, 48, 60):
    sine = mk.targets.sine(cycles=cycles, size=(64, samples), mean=5.0, amplitude=1.0)
    image = sensor.simulate(sine.values, tolerance=1e-5).image
    line = image.mean(axis=0)
    modulation = 2 * abs(np.fft.rfft(line)[cycles]) / len(line)
    frequency = cycles / (samples * 3.75e-3)
    rows.append((frequency, modulation, float(sensor.mtf(frequency))))
sines = pd.DataFrame(rows, columns=["frequency_cy_mm", "modulation", "mtf"])
sines["difference"] = sines.modulation - sines.mtf
sines.to_csv(out / "01_sines.csv", index=False)
sines

# %% [markdown]
# ## Another sensor
# A sensor never changes; `replace` makes another one, by the names that studies and sensor files use.

# %%
blurrier = sensor.replace({"jitter.rms": "60 urad"})
print(f"MTF at Nyquist {sensor.mtf(curves.nyquist):.4f}, with 60 urad of jitter {blurrier.mtf(curves.nyquist):.4f}")
blurrier.save(out / "01_blurrier.toml")

# %%
assert sines.difference.abs().max() < 1e-4
assert abs(sensor.mtf(1e3 / 30) - 0.3875) < 5e-5
assert mk.Sensor.load(out / "01_blurrier.toml") == blurrier
