# SPDX-License-Identifier: Apache-2.0
# %% [markdown]
# # A camera from its frames, and its twin
# Stacks of flat frames give gain, noise and patterns of a camera, two edges its blur. The sensor file that holds both is a
# twin: it draws frames that tests of two samples do not tell from the camera's own.
#
# The frames here come from a camera that is made up, so that what is found can be compared with the truth. Frames of your
# own take its place: one array (frames, rows, columns) for each exposure.

# %%
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd

import mtfkit as mk

out = Path("notebook-output")
out.mkdir(exist_ok=True)

camera = mk.Sensor.parse("""schema = 2
[frame]
focal_length = "100 mm"
pitch = "15 um"
integration_time = "1 ms"
[scene]
quantity = "photon_radiance"
sample = "15 um"
[optics]
f_number = 2.0
[band]
wavelength = ["3.8 um", "4.2 um"]
[[presample]]
kind = "diffraction"
[[presample]]
kind = "footprint"
width = "14 um"
[[presample]]
kind = "jitter"
rms = "40 urad"
[detector]
quantum_efficiency = 0.6
full_well = "80 ke-"
read_noise = "30 e-"
[nonuniformity]
prnu = 0.01
dsnu = "25 e-"
[noise]
seed = 5
row = "8 e-"
fixed_column = "10 e-"
[adc]
bits = 14
electrons_per_count = "5 e-"
offset = 200.0
""")
radiances = [0.0, 5e16, 1e17, 2e17, 4e17, 7e17, 1e18]


def flat_frames(sensor, radiance, first, count=16):
    plan = sensor.compile(np.full((128, 128), radiance, "float32"), stage="dn")
    return np.array([plan(np.full((128, 128), radiance, "float32"), frame=first + i) for i in range(count)])


measured = {radiance: flat_frames(camera, radiance, 100 * (k + 1)) for k, radiance in enumerate(radiances)}
{radiance: round(float(cube.mean()), 2) for radiance, cube in measured.items()}

# %% [markdown]
# ## The radiometric half
# The light of a stack is stated in photons at a pixel. What frames cannot tell, as the f-number, is the nominal's: here a
# data sheet that is wrong about the detector.

# %%
etendue = np.pi / (4 * 2.0**2 + 1) * 15e-6**2  # pi sin^2 of the cone of f/2, times the area of a pixel: m^2 sr
photons = {radiance: radiance * etendue * 1e-3 for radiance in radiances}
nominal = camera.replace({"detector.quantum_efficiency": 0.5, "detector.read_noise": "50 e-", "nonuniformity.prnu": 0.03,
                          "adc.electrons_per_count": "4 e-", "jitter.rms": "10 urad"})
stacks = [mk.Stack(cube, photons=photons[radiance]) if radiance else mk.Stack(cube, light=False)
          for radiance, cube in measured.items()]
found = mk.characterize(stacks, nominal=nominal, trend=0)
found.table.to_csv(out / "10_camera.csv")
print(found.explain())

# %% [markdown]
# ## The blur
# The same camera looks at two edges. The fit starts from the sensor file that was just found, and its own noise is in the
# images.

# %%
def edge(angle, first):
    scene = mk.targets.edge(angle=angle, size=(512, 512), low=1e17, high=7e17)
    return camera.simulate(scene, stage="dn", frames=[first]).image[16:-16, 16:-16]


edges = [edge("5 deg", 9001), edge("95 deg", 9002)]
fit = found.sensor.fit(edges=edges, free={"jitter.rms": ("0 urad", "100 urad")})
twin = fit.sensor.replace({"noise.seed": 77})
twin.save(out / "10_twin.toml")
fit.table

# %% [markdown]
# ## The twin's frames
# New frames of the camera against frames of the twin, whose patterns are others of the same kind: the variance over time and
# that of the mean frame at each level, with what two samples of that size scatter by, and the values of single pixels.

# %%
rows = []
for k, radiance in enumerate(radiances):
    own, its = (flat_frames(sensor, radiance, 5000 + 100 * k).astype("float64") for sensor in (camera, twin))
    temporal = its.var(axis=0, ddof=1).mean() / own.var(axis=0, ddof=1).mean()
    spatial = its.mean(axis=0).var() / own.mean(axis=0).var()
    rows.append((radiance, own.mean(), its.mean() - own.mean(), temporal, spatial))
    if k == 3:
        bins = np.arange(own[0].min(), own[0].max() + 2, 2)
        plt.hist(own[0].ravel(), bins, histtype="step", label="camera")
        plt.hist(its[0].ravel(), bins, histtype="step", label="twin")
        plt.xlabel("counts of a pixel")
        plt.legend()
table = pd.DataFrame(rows, columns=["radiance", "mean", "difference", "temporal_ratio", "spatial_ratio"]).set_index("radiance")
table.to_csv(out / "10_twin.csv")
table.round(4)

# %%
frequency = np.linspace(0.0, 0.5, 51)
true, same = (sensor.mtf(frequency, unit="cy/px") for sensor in (camera, twin))
print("greatest difference of the MTF up to Nyquist", round(float(np.abs(true - same).max()), 4))

# %% [markdown]
# ## What is claimed
# Every number within four of its standard deviations of the truth; variances within four of theirs, which rows and columns that
# share noise raise; the MTF within its error.

# %%
assert found.adequate and fit.adequate
for name, truth in {"electrons_per_count": 5.0, "read_noise": 30.0, "prnu": 0.01, "dsnu": 25.0, "row_noise": 8.0, "fixed_column": 10.0}.items():
    assert abs(found[name].value - truth) < 4 * found[name].sd, name
assert abs(fit["jitter.rms"].value - 40.0) < 4 * fit["jitter.rms"].sd
assert (abs(table.difference) < 2e-3 * table["mean"]).all()
assert (abs(table.temporal_ratio - 1) < 0.03).all() and (abs(table.spatial_ratio - 1) < 0.1).all()
assert np.abs(true - same).max() < 0.01
