# SPDX-License-Identifier: Apache-2.0
# %% [markdown]
# # The MTF from an edge: three definitions, and why they differ
# Programs disagree on the same edge. Here the sensor behind the edge is known, so that each definition can be held against
# the truth:
# 1. the e-SFR as ISO 12233:2000 wrote it: bins of a quarter pixel, differences, a window, a Fourier transform;
# 2. the same with the response of the difference divided out, as the edition of 2014 has it, and Imatest and MTF Mapper do;
# 3. regression on every pixel, without bins and differences, each value with its standard deviation.

# %%
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd

import mtfkit as mk

out = Path("notebook-output")
out.mkdir(exist_ok=True)

sensor = mk.Sensor(frame=dict(focal_length="100 mm", pitch="15 um"), optics=dict(f_number=2.0, wavelength="4 um"),
                   presample=["diffraction", mk.Footprint(width="15 um"), mk.Jitter(rms="20 urad")])
clean = sensor.simulate(mk.targets.edge(angle="5 deg")).image[16:-16, 16:-16]
image = clean + mk.noise.gaussian(clean.shape, sd=0.03, seed=1)
plt.imshow(image, cmap="gray")

# %% [markdown]
# ## The standard's method, in a few lines
# The edge is found by its centroids, pixels are sorted into bins of a quarter pixel along the normal, the bins are
# differentiated and transformed.

# %%
def esfr(image, corrected):
    """The e-SFR of a near-vertical edge, in cycles/pixel along its normal."""
    rows, columns = np.indices(image.shape)
    slopes = np.abs(np.diff(image, axis=1))
    slopes[slopes < 0.2 * slopes.max()] = 0.0
    centre = (slopes * (columns[:, 1:] - 0.5)).sum(axis=1) / slopes.sum(axis=1)
    slope, place = np.polyfit(np.arange(len(centre)), centre, 1)
    distance = (columns - place - slope * rows) * np.cos(np.arctan(slope))
    bins = np.round(4 * distance).astype(int)
    keep = np.abs(bins) <= 4 * 24
    index = bins[keep] - bins[keep].min()
    profile = np.bincount(index, image[keep]) / np.bincount(index)
    lsf = np.convolve(profile, [0.5, 0.0, -0.5], mode="valid") * np.hamming(len(profile) - 2)
    f = np.arange(len(lsf) // 2) * 4.0 / len(lsf)
    sfr = np.abs(np.fft.fft(lsf))[:len(f)]
    sfr /= sfr[0]
    if corrected:  # the difference over two bins of 1/4 pixel has the response sinc(f / 2)
        sfr = sfr / np.sinc(f / 2)
    return f[f <= 0.75], sfr[f <= 0.75]


edge = mk.measure(image)[0]
both = mk.measure(image, method="both")[0]
direction = np.radians(edge.angle_deg)


def truth(f):
    return sensor.mtf(f * np.cos(direction), f * np.sin(direction), unit="cy/px")


curves = {"ISO 12233:2000": esfr(image, False), "2014, corrected": esfr(image, True), "regression": (edge.frequency, edge.mtf)}
for name, (f, value) in curves.items():
    plt.plot(f, value - truth(f), label=name)
band = edge.frequency <= 0.75
plt.fill_between(edge.frequency[band], -2 * edge.mtf_sd[band], 2 * edge.mtf_sd[band], alpha=0.3)
plt.xlabel("cycles/pixel")
plt.ylabel("measured - true MTF")
plt.xlim(0, 0.75)
plt.legend()

# %%
at = np.linspace(0.05, 0.5, 10)
table = pd.DataFrame({"frequency_cy_px": at, "truth": truth(at)})
for name, (f, value) in curves.items():
    table[name] = np.interp(at, f, value)
table["sd"] = np.interp(at, edge.frequency, edge.mtf_sd)
table.to_csv(out / "02_definitions.csv", index=False)
table.round(4)

# %% [markdown]
# ## What is left, by its cause
# The toolkit's own ISO 12233 says of every bias where it comes from and how large it is.

# %%
both.iso12233

# %%
def bias(name):
    return np.abs(table[name] - table.truth).max()


print({name: round(bias(name), 4) for name in curves})
(f, raw), (_, corrected) = curves["ISO 12233:2000"], curves["2014, corrected"]
assert np.allclose(raw, corrected * np.sinc(f / 2), rtol=1e-12)  # the first two differ by a known response
assert bias("ISO 12233:2000") > 3 * bias("regression")  # and the first is biased by it
pull = (table["regression"] - table.truth) / table.sd
assert np.sqrt((pull ** 2).mean()) < 3
assert abs(edge.mtf50.value - np.interp(-0.5, -truth(edge.frequency), edge.frequency)) < 4 * edge.mtf50.sd
