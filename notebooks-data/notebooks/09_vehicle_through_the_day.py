# SPDX-License-Identifier: Apache-2.0
# %% [markdown]
# # A vehicle through the day: MWIR against LWIR through the air
# The demo scene of the toolkit: a tracked vehicle on soil in a high valley, with weather and a schedule of its engine. Its
# surface temperatures are solved over a day, two cameras see it from nine hundred metres, and twice a day the vehicle
# disappears in the soil.

# %%
import re
import subprocess
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd

import mtfkit as mk

out = Path("notebook-output")
out.mkdir(exist_ok=True)
subprocess.run(["mtf", "scene", "demo", "-o", "vehicle", "--force"], check=True, capture_output=True)
text = Path("vehicle/scene.toml").read_text()
text = re.sub(r"(?m)^end = .*", "end = 2026-06-22T00:00:00Z", text)
text = re.sub(r"(?m)^step = .*", 'step = "3 h"', text)
Path("vehicle/day.toml").write_text(text)

# %% [markdown]
# ## Temperatures
# A coarse run, promised to 2 K: enough to see the day. The times are UTC, local noon is at 19.

# %%
heat = mk.heat("vehicle/day.toml", tolerance="2 K", rays=16)
regions = heat.regions().mean_K.unstack()
regions.to_csv(out / "09_regions.csv")
regions.plot(ylabel="mean temperature [K]")
heat

# %% [markdown]
# ## Pictures
# Each camera from the same place, through the same air; the layer of materials says which pixels are vehicle.

# %%
where = dict(position=(700, -600, 60), look_at=(0, 0, 1.2), plain=True, points=1, samples_per_pitch=1.0)
cameras = {name: mk.Sensor.load(f"vehicle/{name}.toml").replace({"frame.focal_length": "400 mm"})
           for name in ("mwir", "lwir")}
bands = {"mwir": ("3.7 um", "4.8 um"), "lwir": ("8 um", "13 um")}
soil = 4  # the place of the material in the scene file
rows, pictures = [], {}
for time in heat.times[:-1]:
    for name, camera in cameras.items():
        picture = mk.render("vehicle/day.toml", camera, temperatures=heat, at=time, layers=["material"], **where)
        material, radiance = picture.layers["material"], picture.plane()
        vehicle, ground = ((radiance[mask].astype(float).mean()) for mask in ((material >= 0) & (material != soil),
                                                                             material == soil))
        seen = mk.light.band_temperature(bands[name], [vehicle, ground])
        rows.append((time, name, vehicle, ground, seen[0] - seen[1]))
        pictures[time, name] = radiance
contrast = pd.DataFrame(rows, columns=["time", "camera", "vehicle", "soil", "contrast_K"])
contrast.to_csv(out / "09_contrast.csv", index=False)
wide = contrast.pivot(index="time", columns="camera", values="contrast_K")
wide.plot(ylabel="vehicle - soil, brightness temperature [K]", rot=45)
plt.axhline(0, color="grey")
wide.round(2)

# %%
figure, axes = plt.subplots(2, 2, figsize=(10, 6))
for row, time in zip(axes, (heat.times[4], heat.times[6])):
    for axis, name in zip(row, cameras):
        axis.imshow(pictures[time, name][80:240, 100:412], cmap="inferno")
        axis.set_title(f"{name} {time[11:16]}")
        axis.axis("off")

# %% [markdown]
# ## Through more air
# The contrast that arrives, over the noise of each camera. The detectors differ (cooled, uncooled), the air takes a
# different share of either band.

# %%
ranges = np.array([0.5, 1, 2, 4, 8])
netd = {name: camera.budget(temperature="290 K")["netd"].to("mK") * 1e-3 for name, camera in cameras.items()}
air = {name: [mk.air.line(model="mid_latitude_summer", haze="rural", sensor_altitude="2.4 km", range=(km, "km"),
                          zenith_angle="90 deg", bands=[bands[name]]).bands[0].contrast_transmission for km in ranges]
       for name in bands}
table = pd.DataFrame({"range_km": ranges, **{f"transmission_{name}": air[name] for name in bands},
                      **{f"snr_1K_{name}": np.array(air[name]) / netd[name] for name in bands}})
table.to_csv(out / "09_air.csv", index=False)
table.round(3)

# %%
for name in cameras:
    series = wide[name].to_numpy()
    assert series.min() < -1 and series.max() > 1  # the vehicle is warmer by night, colder by day: it crosses the soil
    assert (np.diff(np.sign(series)) != 0).sum() >= 2  # twice
slope = {name: mk.light.band_derivative(bands[name], 290.0) / mk.light.band_radiance(bands[name], 290.0) for name in bands}
assert slope["mwir"] > 2 * slope["lwir"]  # a kelvin is a larger share of the light in the MWIR
for name in bands:
    assert (np.diff(air[name]) < 0).all() and 0 < min(air[name]) < max(air[name]) < 1
assert heat.promised <= 2.0
