# SPDX-License-Identifier: Apache-2.0
# %% [markdown]
# # Against pyBSM, prysm and GalSim
# Who is right where? The judge is none of the four: tables of 30 digits (notebooks-data/reference), made by exact geometry
# and arbitrary precision. What this toolkit gives is worked out here; the figures of the others were measured with the
# commits that `peers.csv` names, and are run again where they can be imported.

# %%
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd

import mtfkit as mk

out = Path("notebook-output")
out.mkdir(exist_ok=True)
reference = Path("notebooks-data/reference")
cutoff = 1000.0  # cycles/mm
lens = dict(f_number=1.0, wavelength="1 um")
frame = dict(focal_length="100 mm", pitch="15 um")
peers = pd.read_csv("notebooks-data/notebooks/peers.csv")
peers

# %% [markdown]
# ## The circular pupil at both ends
# The textbook form, 2/pi (acos x - x sqrt(1 - x^2)), loses all digits near the cutoff. Relative errors; nothing can be
# better there than what one rounding of the frequency x itself does, 3/2 x 1e-16 / (1 - x).

# %%
ends = pd.read_csv(reference / "circular_mtf_extremes.csv")
ends = ends[ends.end == "cutoff"]
nu = np.array([float.fromhex(text) for text in ends.nu_double_hex])
exact = ends.mtf_at_double.astype(float).to_numpy()
keep = nu < 1.0
nu, exact = nu[keep], exact[keep]
clear = mk.Sensor(frame=frame, optics=lens, presample=["diffraction"])
ours = clear.otf(nu * cutoff).real
textbook = 2 / np.pi * (np.arccos(nu) - nu * np.sqrt(1 - nu * nu))
circle = pd.DataFrame({"1 - x": 1 - nu, "mtfkit": np.abs(ours / exact - 1), "textbook": np.abs(textbook / exact - 1)})
circle["a rounding of x"] = 1.5 * 2.0 ** -53 / (1 - nu)
circle.to_csv(out / "06_circle.csv", index=False)
circle.plot(x="1 - x", loglog=True, style="o", ylabel="relative error", ylim=(1e-17, 10))

# %% [markdown]
# ## Annular pupils, and defocus
# The largest error over all of the tables.

# %%
def numbers(table, column):
    return np.array([float.fromhex(text) for text in table[column]])


def ours_at(table, rows, **fields):
    kind = mk.Defocus if "waves" in fields else mk.Diffraction
    sensor = mk.Sensor(frame=frame, optics=lens, presample=[kind(**fields)])
    return sensor.otf(numbers(table.loc[rows], "nu_hex") * cutoff).real


annular = pd.read_csv(reference / "annular_diffraction_mtf.csv")
errors = []
for hexadecimal, rows in annular.groupby("obscuration_hex").groups.items():
    error = np.abs(ours_at(annular, rows, obscuration=float.fromhex(hexadecimal)) - annular.loc[rows, "mtf"])
    errors.append(("annular", float.fromhex(hexadecimal), error.max()))
defocus = pd.read_csv(reference / "defocus_circular.csv")
for hexadecimal, rows in defocus.groupby("w020_hex").groups.items():
    error = np.abs(ours_at(defocus, rows, waves=float.fromhex(hexadecimal)) - defocus.loc[rows, "otf"])
    errors.append(("defocus", float.fromhex(hexadecimal), error.max()))
table = pd.DataFrame(errors, columns=["pupil", "parameter", "largest_error"])
table.to_csv(out / "06_pupils.csv", index=False)
worst = table.groupby("pupil").largest_error.max()
worst

# %%
beside = peers.copy()
beside["mtfkit"] = [worst["annular"] if "annular" in quantity else worst["defocus"] if "defocus" in quantity
                    else circle.mtfkit[circle["1 - x"] > 0.9e-8].max() if "circular pupil (relative)" in quantity else np.nan
                    for quantity in peers.quantity]
beside.to_csv(out / "06_beside.csv", index=False)
beside[["program", "quantity", "largest_error", "mtfkit"]]

# %% [markdown]
# ## The others, where they are installed
# The circular pupil once more, by their own functions.

# %%
theirs = {}
try:
    import galsim

    airy = galsim.Airy(lam_over_diam=1.0)
    theirs["GalSim"] = np.array([airy.kValue(2 * np.pi * x, 0.0).real for x in nu])
except ImportError:
    print("GalSim is not installed")
try:
    from prysm.otf import diffraction_limited_mtf

    theirs["prysm"] = diffraction_limited_mtf(fno=lens["f_number"], wavelength=1.0, frequencies=nu * cutoff)
except ImportError:
    print("prysm is not installed")
try:
    from pybsm.otf import circular_aperture_OTF

    theirs["pyBSM"] = circular_aperture_OTF(u=nu[:, None] * 1e6, v=np.zeros((len(nu), 1)), lambda0=1e-6, D=1.0, eta=0.0)[:, 0]
except ImportError:
    print("pyBSM is not installed")
{name: float(np.abs(np.asarray(value) / exact - 1).max()) for name, value in theirs.items()}

# %%
assert np.abs(ours - exact).max() < 4e-16
assert (circle.mtfkit <= 20 * circle["a rounding of x"] + 1e-14).all()
assert circle.textbook.max() > 0.1
assert (worst < 2e-12).all()
assert worst["defocus"] < 1e-6 * peers.largest_error[peers.quantity.str.contains("defocus")].min()
