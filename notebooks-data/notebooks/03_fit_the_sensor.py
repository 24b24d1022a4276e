# SPDX-License-Identifier: Apache-2.0
# %% [markdown]
# # The sensor behind an edge, and what the data cannot tell
# A fit finds numbers of a sensor from the pixels of its images. What they do not determine is said in words, never hidden
# in a number.

# %%
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import mtfkit as mk

out = Path("notebook-output")
out.mkdir(exist_ok=True)

truth = mk.Sensor(frame=dict(focal_length="100 mm", pitch="15 um"), optics=dict(f_number=2.0),
                  presample=[mk.Defocus(wavelength="4 um", distance="20 um"), mk.Footprint(width="15 um"),
                             mk.Jitter(rms="30 urad")])


def image(sensor, angle, frame):
    clean = sensor.simulate(mk.targets.edge(angle=angle)).image[16:-16, 16:-16]
    return clean + mk.noise.gaussian(clean.shape, sd=0.03, seed=3, frame=frame)


edges = [image(truth, "5 deg", 0), image(truth, "95 deg", 1)]

# %% [markdown]
# ## Defocus and jitter from two edges

# %%
guess = truth.replace({"jitter.rms": "10 urad", "defocus.distance": "5 um"})
fit = guess.fit(edges=edges, free={"jitter.rms": ("0 urad", "80 urad"), "defocus.distance": ("0 um", "60 um")})
fit.table.to_csv(out / "03_fit.csv")
fit.table

# %%
print("correlation", np.round(fit.correlation, 3).tolist())
print("adequate", fit.adequate, "chi2 per degree of freedom", round(fit.chi2_per_dof, 3))
plt.plot(fit.frequency, fit.mtf)
plt.fill_between(fit.frequency, fit.mtf - 2 * fit.mtf_sd, fit.mtf + 2 * fit.mtf_sd, alpha=0.3)
plt.xlabel("cycles/pixel")
plt.ylabel("fitted MTF with two standard deviations")
np.savetxt(out / "03_mtf.csv", np.c_[fit.frequency, fit.mtf, fit.mtf_sd], delimiter=",", header="frequency_cy_px,mtf,sd",
           comments="")

# %% [markdown]
# ## Two blurs of the same shape
# A jitter and a Gaussian blur have one shape: their sum of squares is known, their shares are not. The fit says so.

# %%
twins = mk.Sensor(frame=dict(focal_length="100 mm", pitch="15 um"), optics=dict(f_number=2.0, wavelength="4 um"),
                  presample=["diffraction", mk.Footprint(width="15 um"), mk.Jitter(rms="20 urad"), mk.Gaussian(sigma="2 um")])
blind = twins.fit(edges=[image(twins, "5 deg", 2)], free=["jitter.rms", "gaussian.sigma"])
for parameter in blind.parameters:
    print(parameter.name, "-", parameter.verdict)

# %% [markdown]
# ## The loop closes
# The fitted sensor is a sensor file: simulated again, its edge has the MTF that was measured.

# %%
fit.sensor.save(out / "03_fitted.toml")
again = mk.measure(image(mk.Sensor.load(out / "03_fitted.toml"), "5 deg", 4))[0]
first = mk.measure(edges[0])[0]
print("MTF50", first.mtf50, "and", again.mtf50)

# %%
assert fit.adequate
for name, true in (("jitter.rms", 30.0), ("defocus.distance", 20.0)):
    assert abs(fit[name].value - true) < 4 * fit[name].sd
assert blind.report["not_separable"]
assert abs(first.mtf50.value - again.mtf50.value) < 5 * np.hypot(first.mtf50.sd, again.mtf50.sd)
