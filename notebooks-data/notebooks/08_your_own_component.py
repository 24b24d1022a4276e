# SPDX-License-Identifier: Apache-2.0
# %% [markdown]
# # Your own component
# A function of (fx, fy) becomes a component of a sensor, held to what every component is held to. Here a coating scatters a
# few percent of the light into a halo; the image is then held against numpy's own Fourier transform of the function.

# %%
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd

import mtfkit as mk

out = Path("notebook-output")
out.mkdir(exist_ok=True)


def coating(fx, fy, share=0.05, radius_mm=0.02):
    """Most of the light goes straight on, a share into a Gaussian halo of that radius."""
    return 1 - share + share * np.exp(-2 * (np.pi * radius_mm) ** 2 * (fx ** 2 + fy ** 2))


part = mk.custom(coating, cutoff="200 cy/mm", label="coating")
print(part.axis, f"tables of {len(part.frequency)} samples, off by at most {part.error:.1e}")

# %%
frame = dict(focal_length="100 mm", pitch="15 um")
sensor = mk.Sensor(frame=frame, optics=dict(f_number=2.0, wavelength="4 um"),
                   presample=["diffraction", mk.Footprint(width="15 um"), part])
table = sensor.curves(np.linspace(0, 80, 161)).to_pandas()
table.to_csv(out / "08_curves.csv")
table.plot(ylim=(0, 1), ylabel="MTF", xlabel="cycles/mm")

# %% [markdown]
# ## What is refused
# A function that no component may be is refused with the property that fails and the place.

# %%
for wrong in (lambda fx, fy: 0.95 * np.exp(-fx ** 2 - fy ** 2), lambda fx, fy: 1 + 0.1 * np.sin(np.hypot(fx, fy)),
              lambda fx, fy: np.exp(2j * np.pi * np.abs(fx) * 0.01)):
    try:
        mk.custom(wrong, cutoff="60 cy/mm")
    except mk.UsageError as refused:
        print(refused)

# %% [markdown]
# ## Against numpy
# The scene mirrored at its borders is periodic: its transform times the function, back, every fourth sample. Only the
# coating is in this sensor, so that nothing of the toolkit is on both sides.

# %%
alone = mk.Sensor(frame=frame, presample=[part])
scene = 5 + np.random.default_rng(2).standard_normal((256, 320)).astype("float32")
run = alone.simulate(scene, sample="3.75 um", tolerance=1e-4)
mirrored = np.block([[scene, scene[:, ::-1]], [scene[::-1], scene[::-1, ::-1]]]).astype("float64")
fy, fx = (np.fft.fftfreq(n, 3.75e-3) for n in mirrored.shape)
shift = np.exp(2j * np.pi * 1.5 * 3.75e-3 * (fx[None, :] + fy[:, None]))  # to the pixel centres
exact = np.fft.ifft2(np.fft.fft2(mirrored) * coating(fx[None, :], fy[:, None]) * shift).real[:256:4, :320:4]
realised = np.sqrt(np.mean((run.image - exact) ** 2)) / scene.std()
print(f"promised {run.promised:.2e}, realised {realised:.2e} of the scene's standard deviation")
pd.DataFrame({"promised": [run.promised], "realised": [realised]}).to_csv(out / "08_promise.csv", index=False)
plt.imshow(run.image, cmap="gray")

# %%
assert realised <= run.promised < 2e-4
assert abs(sensor.mtf(40.0) - sensor.curves([40.0])["diffraction"].mtf[0] * np.sinc(40 * 0.015) * coating(40.0, 0.0)) < 1e-6
assert np.abs(sensor.curves([40.0])["coating"].mtf - coating(40.0, 0.0)).max() < 1e-6
