#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""radiometry/atmosphere/tables/: coefficients of the band model and the model atmospheres, as initialisers of C++ arrays.

Input: tables of transmittance and optical depth that LOWTRAN7 rev 4.2 (Air Force Geophysics Laboratory, 1988/1992, a work
of the US Government) computes for one absorber at a time under known conditions, and the published model atmospheres
(AFGL-TR-86-0110). They are part of the data shared beside the repository: $MTFKIT_SHARED, else ../shared; --data names
another folder.

  coefficients.inc       lines by the band law of atmosphere_bands.py; water, nitrogen and oxygen continua; Rayleigh;
                         spectra and altitudes of aerosols. Conditions marked `check` are kept out of the fit; how far
                         both are met stands at the head of the file.
  model_atmospheres.inc  six model atmospheres, 0 to 100 km

numpy is all that it needs. Run again, it writes the same bytes (--folder DIR writes elsewhere).
"""

import argparse
import csv
import os
from pathlib import Path

import numpy as np

import atmosphere_bands

REPOSITORY = Path(__file__).resolve().parents[3]
P0_HPA, T0_K = atmosphere_bands.P0_HPA, atmosphere_bands.T0_K
GRID = np.concatenate([np.arange(650, 3501, 5), np.arange(3520, 25001, 20)]).astype(float)  # cm^-1
GASES = {"h2o": "water", "co2": "carbon_dioxide", "o3": "ozone", "n2o": "nitrous_oxide", "co": "carbon_monoxide",
         "ch4": "methane", "o2": "oxygen", "no": "nitric_oxide", "so2": "sulphur_dioxide", "no2": "nitrogen_dioxide",
         "nh3": "ammonia", "hno3": "nitric_acid"}
BEER = (1.0, 0.0, 0.0)  # a, n, m of absorption that goes exponentially with the amount
LEAST_ABSORPTION = 1e-9  # over the extinction at 0.55 um
# Wavelengths between which aerosol spectra are straight lines: those of Shettle and Fenn, AFGL-TR-79-0214 (1979), with
# the ends of the model.
NODES_UM = [0.4, 0.55, 0.6943, 1.06, 1.536, 2.0, 2.25, 2.5, 2.7, 3.0, 3.3923, 3.75, 4.5, 5.0, 5.5, 6.0, 6.2, 6.5, 7.2,
            7.9, 8.2, 8.7, 9.0, 9.2, 10.0, 10.591, 11.0, 11.5, 12.5, 14.8, 15.0, 1e4 / 650]
HUMIDITIES = (0, 70, 80, 99)  # percent, between which the logarithm of a spectrum is linear in ln(100 - RH)
# The runs took the mass of a water molecule as 2.989e-23 g where their conditions, as the model here, have 18.015 g/mol
# over 6.02214e23 / mol: the aerosol met this part of the humidity that the columns say. (Without it the humidities between
# the four are missed by 0.5 %.)
HUMIDITY_OF_RUNS = round(2.989e-23 * 6.02214076e23 / 18.015, 5)
HAZES = ("rural", "urban", "maritime", "tropospheric")
EXTINCTION_550 = {"23": 0.158, "5": 0.77, "1": 3.89, "0.2": 19.49}  # per km, by visibility in km


def index_of(wavenumbers):
    index = np.searchsorted(GRID, wavenumbers)
    assert np.array_equal(GRID[index], wavenumbers)
    return index


def read(data, name):
    with open(data / name, encoding="utf-8") as file:
        return list(csv.DictReader(file))


def number(text):
    return float(text) if text else np.nan


def columns(rows, prefix):
    names = [name for name in rows[0] if name.startswith(prefix)]
    return names, np.array([[number(row[name]) for name in names] for row in rows])


# --- lines ---


def fit_lines(data):
    """Bands (gas, a, n, m), ln C by band and grid index, and the worst |d tau| of fitted and of check conditions."""
    rows, conditions = read(data, "gas_transmittance.csv"), read(data, "gas_conditions.csv")
    bands, log_c, worst = [], [], {}
    for gas, name in GASES.items():
        own = [r for r in rows if r["gas"] == gas]
        nu = np.array([float(r["wavenumber_cm-1"]) for r in own])
        tau = columns(own, "t_c")[1]
        own_conditions = [c for c in conditions if c["gas"] == gas]
        state = np.array([[float(c[k]) for k in ("pressure_mb", "temperature_K", "column_molecules_cm-2")]
                          for c in own_conditions])
        fitted = np.array([c["use"] == "fit" for c in own_conditions])
        parts = {"hno3": [(nu > 0, BEER)], "o2": [(nu > 2000, None)],
                 "o3": [(nu < 12000, None), (nu > 12000, BEER)]}.get(gas, [(nu > 0, None)])
        worst[gas] = [0.0, 0.0]
        for part, law in parts:
            band, laws, c = atmosphere_bands.fit(state[fitted], tau[part][:, fitted], law)
            c = np.round(c, 5)
            known = np.isfinite(c)
            model = np.where(known[:, None], atmosphere_bands.transmittance(laws[band], np.nan_to_num(c), state), 1.0)
            miss = np.abs(model - tau[part])
            worst[gas] = [max(worst[gas][0], miss[:, fitted].max()), max(worst[gas][1], miss[:, ~fitted].max())]
            index = index_of(nu[part])
            for k, (a, n, m) in enumerate(laws):
                log_c.append({i: v for i, v, b in zip(index[known], c[known], band[known]) if b == k})
                bands.append((name, a, n, m))
    return bands, log_c, worst


def runs_of(log_c):
    """(band, first grid index, values) of every stretch without gaps."""
    runs = []
    for band, values in enumerate(log_c):
        for i in sorted(values):
            if runs and runs[-1][0] == band and runs[-1][1] + len(runs[-1][2]) == i:
                runs[-1][2].append(values[i])
            else:
                runs.append((band, i, [values[i]]))
    return runs


# --- continua ---


def fit_water(data):
    """foreign, self at 296 K, self at 260 K per grid index from 0 on, per km and (1e19 molecules/cm^3)^2."""
    conditions = read(data, "h2o_continuum_conditions.csv")
    rows = read(data, "h2o_continuum.csv")
    depth = columns(rows, "od_per_km")[1]
    assert np.array_equal([float(r["wavenumber_cm-1"]) for r in rows], GRID)
    h, air, t = (np.array([float(c[k]) for c in conditions])
                 for k in ("h2o_number_density_cm-3", "air_number_density_cm-3", "temperature_K"))
    h, air = h / 1e19, air / 1e19
    cold = np.clip((296.0 - t) / 36.0, 0.0, 1.0)
    x = np.stack([h * (air - h), h * h * (1 - cold), h * h * cold], 1)
    fitted = np.array([c["use"] == "fit" for c in conditions])
    result, worst, weak = np.zeros((len(GRID), 3)), [0.0, 0.0], 0.0
    for i, row in enumerate(depth):
        used = fitted & np.isfinite(row)
        if used.sum() < 3:
            weak = max(weak, np.nanmax(np.nan_to_num(row[fitted])))
            continue
        w = 1.0 / (3e-7 * row[used] + 1e-11)  # six digits; absolute error of a single-precision exponent
        free = np.ones(3, bool)
        for _ in range(3):
            s = np.zeros(3)
            s[free] = np.linalg.lstsq(x[used][:, free] * w[:, None], row[used] * w, rcond=None)[0]
            free &= s > 0
        result[i] = [float(f"{v:.6g}") for v in np.maximum(s, 0)]
        strong = np.isfinite(row) & (row > 1e-4)
        miss = np.abs(x @ result[i] / row - 1)
        worst = [max([w0] + list(miss[strong & kind])) for w0, kind in zip(worst, (fitted, ~fitted))]
    last = np.flatnonzero(result.any(1)).max() + 1
    return result[:last], worst, weak


def air_state(header):
    """Pressure and temperature of columns named like od_per_km_1013.25mb_296K."""
    parts = [name.split("_") for name in header]
    return np.array([[float(p[-2][:-2]), float(p[-1][:-1])] for p in parts])


def fit_nitrogen(data):
    rows = read(data, "n2_continuum.csv")
    names, depth = columns(rows, "od_per_km")
    p, t = air_state(names).T
    q = (p / P0_HPA) ** 2 * (T0_K / t) ** 1.5
    k = np.array([float(f"{v:.6g}") for v in (depth / q).mean(1)])
    return index_of([float(r["wavenumber_cm-1"]) for r in rows])[0], k, np.abs(k[:, None] * q / depth - 1)


def fit_rayleigh(data):
    rows = read(data, "rayleigh.csv")
    names, depth = columns(rows, "od_per_km")
    p, t = air_state(names).T
    q = p / P0_HPA * T0_K / t
    nu = np.array([float(r["wavenumber_cm-1"]) for r in rows])
    k = depth[:, 0] / q[0]
    w = k / nu**4
    a, b = np.linalg.lstsq(np.stack([np.ones_like(nu), -nu**2], 1) * w[:, None], np.ones_like(nu), rcond=None)[0]
    a, b = float(f"{a:.6g}"), float(f"{b:.6g}")
    return a, b, np.abs((nu**4 / (a - b * nu**2))[:, None] * q / depth - 1)


def fit_oxygen(data):
    """Three coefficients of the collision-induced band: powers 0, 1, 2 of (T - 250 K) / 100 K, per 1e20 molecules/cm^2."""
    rows = [r for r in read(data, "gas_transmittance.csv") if r["gas"] == "o2" and float(r["wavenumber_cm-1"]) < 2000]
    conditions = [c for c in read(data, "gas_conditions.csv") if c["gas"] == "o2"]
    p, t, w = (np.array([float(c[k]) for c in conditions])
               for k in ("pressure_mb", "temperature_K", "column_molecules_cm-2"))
    fitted = np.array([c["use"] == "fit" for c in conditions])
    u = (t - 250.0) / 100.0
    x = (w / 1e20 * p / P0_HPA)[:, None] * np.stack([np.ones_like(u), u, u * u], 1)
    result, worst = [], [0.0, 0.0]
    for row in columns(rows, "t_c")[1]:
        used = fitted & (row > 1e-4) & (row < 1 - 2e-6)
        s = np.linalg.lstsq(x[used] * row[used, None], -np.log(row[used]) * row[used], rcond=None)[0]
        s = np.array([float(f"{v:.6g}") for v in s])
        miss = np.abs(np.exp(-x @ s) - row)
        worst = [max(worst[0], miss[fitted].max()), max(worst[1], miss[~fitted].max())]
        result.append(s)
    return index_of([float(r["wavenumber_cm-1"]) for r in rows])[0], np.array(result).T, worst


# --- aerosols ---


def hats(wavelengths):
    """Values of the straight lines between NODES_UM that are 1 at one node."""
    return np.stack([np.interp(wavelengths, NODES_UM, unit) for unit in np.eye(len(NODES_UM))], 1)


def at_nodes(x, value, scale):
    """Values at the nodes for least squares of the differences over `scale`; what is absorbed may be nothing at all."""
    return np.maximum(np.linalg.lstsq(x / scale[:, None], value / scale, rcond=None)[0], LEAST_ABSORPTION)


def between_humidities(percent):
    """Weights of HUMIDITIES for logarithms that are linear in ln(100 - RH)."""
    dry = np.log(100.0 - np.array(HUMIDITIES))[::-1]
    return np.stack([np.interp(np.log(100.0 - percent), dry, unit[::-1]) for unit in np.eye(len(HUMIDITIES))], 1)


def fit_aerosol(data):
    rows, upper = read(data, "aerosol_transmittance.csv"), read(data, "aerosol_upper.csv")
    x = hats([1e4 / float(r["wavenumber_cm-1"]) for r in rows])
    x_upper = hats([1e4 / float(r["wavenumber_cm-1"]) for r in upper])

    def rounded(value):
        return np.vectorize(lambda v: float(f"{v:.5g}"))(value)

    def relative(source, name, scale):
        return np.array([float(r[name]) for r in source]) / scale

    labels = np.array([0, 50, 70, 80, 90, 95, 99])
    weights = between_humidities(HUMIDITY_OF_RUNS * labels)

    def spectra(part):
        """Haze by kind and humidity, fog, upper air: nodes of one part of the extinction; how far they miss, over it."""
        def fixed_of(which):
            values = [(x, relative(rows, f"{which}_fog{k}_vis1km", EXTINCTION_550["1"])) for k in (1, 2)]
            return values + [(x_upper, relative(upper, f"{which}_{region}_relative", 1.0))
                             for region in ("2_10km", "10_30km", "30_100km")]

        hazes, worst = [], 0.0
        for haze in HAZES:
            value, scale = ([relative(rows, f"{which}_{haze}_vis23km_rh{rh}", EXTINCTION_550["23"]) for rh in labels]
                            for which in (part, "ext"))
            logs = np.log([at_nodes(x, v, s) for v, s in zip(value, scale)])
            hazes.append(rounded(np.exp(np.linalg.lstsq(weights, logs, rcond=None)[0])))
            model = np.exp(weights @ np.log(hazes[-1])) @ x.T
            worst = max(worst, (np.abs(model - value) / scale).max())
        fixed, scales = fixed_of(part), [scale for _, scale in fixed_of("ext")]
        nodes = [rounded(at_nodes(lines, value, scale)) for (lines, value), scale in zip(fixed, scales)]
        worst_fixed = max((np.abs(lines @ s - value) / scale).max()
                          for s, (lines, value), scale in zip(nodes, fixed, scales))
        return hazes, nodes[:2], nodes[2:], worst_fixed, worst

    return spectra("ext"), spectra("abs")


def aerosol_altitudes(data):
    """Extinction at 0.55 um per km: boundary[visibility][0, 1, 2 km], troposphere[season][visibility 50, 23][3 ... 10],
    stratosphere[season][11 ... 30], upper[35 ... 100]."""
    rows = read(data, "aerosol_profile.csv")

    def value(season, visibility, altitude, region):
        return next(float(r[f"ext550_{region}_km-1"]) for r in rows if r["season"] == season and
                    r["visibility_km"] == str(visibility) and float(r["altitude_km"]) == altitude)

    seasons = ("spring_summer", "fall_winter")
    boundary = [[value("spring_summer", v, z, "boundary") for z in (0, 1, 2)] for v in (50, 23, 10, 5, 2)]
    assert boundary == [[value("fall_winter", v, z, "boundary") for z in (0, 1, 2)] for v in (50, 23, 10, 5, 2)]
    troposphere = [[[value(s, v, z, "troposphere") for z in range(3, 11)] for v in (50, 23)] for s in seasons]
    high = list(range(11, 26)) + [30]
    stratosphere = [[value(s, 23, z, "stratosphere") for z in high] for s in seasons]
    upper = [value("spring_summer", 23, z, "upper") for z in (35, 40, 45, 50, 70, 100)]
    return boundary, troposphere, stratosphere, upper


# --- writing ---


def initialiser(values, digits="{:.6g}"):
    """Nested braces; lines of up to 118 characters."""
    if np.ndim(values[0]) > 0:
        return "{\n" + ",\n".join(initialiser(v, digits) for v in values) + "}"
    lines, line = [], "    "
    for text in (digits.format(v) for v in values):
        if len(line) + len(text) > 116:
            lines.append(line.rstrip())
            line = "    "
        line += text + ", "
    return "{\n" + "\n".join(lines + [line.rstrip(", ")]) + "}"


def array(name, values, digits="{:.6g}", kind="double"):
    shape = "".join(f"[{n}]" for n in np.shape(values))
    return f"inline constexpr {kind} {name}{shape} = {initialiser(values, digits)};\n"


def write_coefficients(data, folder):
    bands, log_c, lines_worst = fit_lines(data)
    runs = runs_of(log_c)
    water, water_worst, water_weak = fit_water(data)
    nitrogen_first, nitrogen, nitrogen_miss = fit_nitrogen(data)
    rayleigh_a, rayleigh_b, rayleigh_miss = fit_rayleigh(data)
    oxygen_first, oxygen, oxygen_worst = fit_oxygen(data)
    extinction, absorption = fit_aerosol(data)
    (hazes, fogs, above, fixed_worst, haze_worst), absorbed = extinction, absorption[:3]
    boundary, troposphere, stratosphere, upper = aerosol_altitudes(data)
    gases = "\n".join(f"//   {name:18} {fit:.1e}  {check:.1e}" for (fit, check), name in
                      ((lines_worst[gas], name) for gas, name in GASES.items()))
    text = f"""// SPDX-License-Identifier: Apache-2.0
// Made by notebooks-data/reference/generators/atmosphere.py: change that, not this.
//
// Fitted to transmittances and optical depths computed by LOWTRAN7 rev 4.2 (Air Force Geophysics Laboratory, 1988/1992; a
// work of the US Government, redistributed under the MIT licence) for one absorber at a time. The law of the fit is the
// program's own, so that the numbers are, within their errors, those of its tables.
// Grid: index 0 ... 570 is 650 ... 3500 cm^-1 by 5, index 571 ... 1645 is 3520 ... 25000 cm^-1 by 20.
//
// Worst |difference of transmittance|, at the conditions fitted and at those kept out of the fit:
{gases}
//   oxygen continuum   {oxygen_worst[0]:.1e}  {oxygen_worst[1]:.1e}
// Worst relative difference of optical depth:
//   water continuum    {water_worst[0]:.1e}  {water_worst[1]:.1e}   (where it is above 1e-4 per km)
//   nitrogen           {nitrogen_miss.max():.1e}
//   Rayleigh           {rayleigh_miss[:, 0].max():.1e}  {rayleigh_miss[100:, 1:].max():.1e}   (the second above 4000 cm^-1)
//   spectra of fog and of the upper air   {fixed_worst:.1e}
//   spectra of haze, seven humidities     {haze_worst:.1e}
//   the same of what is absorbed alone    {absorption[3]:.1e}, {absorption[4]:.1e}

// Bands: tau = exp(-(C W)^a), W = column / (1e20 molecules/cm^2) (P / 1013.25 hPa)^n (296 K / T)^m.
inline constexpr BandLaw kBands[{len(bands)}] = {{
"""
    text += ",\n".join(f"    {{Gas::{name}, {a:.6g}, {n:.6g}, {m:.6g}}}" for name, a, n, m in bands) + "};\n\n"
    text += f"// Stretches of the grid in which a band absorbs: band, first grid index, number of values in kLogC.\n"
    text += f"inline constexpr BandRun kRuns[{len(runs)}] = {{\n"
    text += ",\n".join("    " + ", ".join(f"{{{b}, {i}, {len(v)}}}" for b, i, v in runs[k:k + 6])
                       for k in range(0, len(runs), 6)) + "};\n\n"
    text += "// ln C in units of 1e-5, run after run.\n"
    text += array("kLogC", [round(v * 1e5) for _, _, values in runs for v in values], "{:d}", "int")
    text += "\n// Water continuum from index 0 on, per km for densities in 1e19 molecules/cm^3: foreign h (N - h), self h^2\n"
    text += "// at 296 K, self h^2 at 260 K.\n"
    text += array("kWaterForeign", water[:, 0]) + array("kWaterSelf296", water[:, 1])
    text += array("kWaterSelf260", water[:, 2])
    text += "\n// Nitrogen, per km at 1013.25 hPa and 296 K; it goes as P^2 T^-1.5.\n"
    text += f"inline constexpr int kNitrogenFirst = {nitrogen_first};\n" + array("kNitrogen", nitrogen)
    text += "\n// Oxygen, collision-induced: optical depth per (1e20 molecules/cm^2) (P / 1013.25 hPa), coefficients of the\n"
    text += "// powers 0, 1 and 2 of (T - 250 K) / 100 K.\n"
    text += f"inline constexpr int kOxygenFirst = {oxygen_first};\n" + array("kOxygen", oxygen)
    text += "\n// Rayleigh: optical depth per km at 1013.25 hPa and 296 K = nu^4 / (A - B nu^2).\n"
    text += f"inline constexpr double kRayleighA = {rayleigh_a:.6g}, kRayleighB = {rayleigh_b:.6g};\n"
    text += "\n// Aerosol spectra, extinction over that at 0.55 um, straight lines between these wavelengths (um).\n"
    text += array("kAerosolWavelength_um", NODES_UM, "{:.7g}")
    text += "// The program's humidity at the conditions of its runs, as part of the model's; that of the spectra.\n"
    text += f"inline constexpr double kHazeHumidityShare = {HUMIDITY_OF_RUNS};\n"
    text += "// rural, urban, maritime, tropospheric; each at a relative humidity of 0, 70, 80 and 99 %.\n"
    text += array("kHazeSpectra", hazes, "{:.5g}")
    text += "// Advection and radiation fog.\n" + array("kFogSpectra", fogs, "{:.5g}")
    text += "// 2 to 10 km, 10 to 30 km, 30 to 100 km.\n" + array("kUpperSpectra", above, "{:.5g}")
    text += "// The same of what is absorbed alone, over the extinction at 0.55 um.\n"
    for name, part in zip(("kHazeAbsorption", "kFogAbsorption", "kUpperAbsorption"), absorbed):
        text += array(name, part, "{:.5g}")
    text += "\n// Extinction at 0.55 um per km. Boundary: visibility 50, 23, 10, 5, 2 km; at 0, 1, 2 km.\n"
    text += array("kBoundaryAerosol", boundary)
    text += "// Troposphere: spring and summer, autumn and winter; visibility 50, 23 km; at 3, 4 ... 10 km.\n"
    text += array("kTroposphericAerosol", troposphere)
    text += "// Stratosphere: spring and summer, autumn and winter; at 11, 12 ... 25, 30 km.\n"
    text += array("kStratosphericAerosol", stratosphere)
    text += "// At 35, 40, 45, 50, 70, 100 km.\n" + array("kUpperAerosol", upper)
    (folder / "coefficients.inc").write_text(text, encoding="utf-8")
    print(text[:text.index("// Bands:")])


MODELS = ("tropical", "mid_latitude_summer", "mid_latitude_winter", "subarctic_summer", "subarctic_winter",
          "us_standard_1976")
# Where the data differ from the report: model, altitude in km, column, figure of the report.
CORRECTIONS = [("mid_latitude_summer", 27.5, "pressure_mb", 19.1), ("subarctic_winter", 8, "temperature_K", 220.9),
               ("us_standard_1976", 19, "ch4_ppmv", 1.46)]


def write_model_atmospheres(data, folder):
    rows = read(data, "profiles.csv")
    for model, altitude, column, figure in CORRECTIONS:
        row = next(r for r in rows if r["model"] == model and float(r["altitude_km"]) == altitude)
        row[column] = str(figure)
    altitudes = [float(r["altitude_km"]) for r in rows if r["model"] == MODELS[0]]

    def column(model, name):
        return [float(r[name]) for r in rows if r["model"] == model]

    text = """// SPDX-License-Identifier: Apache-2.0
// Made by notebooks-data/reference/generators/atmosphere.py: change that, not this.
//
// The model atmospheres of G. P. Anderson et al., AFGL Atmospheric Constituent Profiles (0-120 km), AFGL-TR-86-0110
// (1986), up to 100 km: published figures. Models in the order tropical, mid-latitude summer, mid-latitude winter,
// sub-arctic summer, sub-arctic winter, US standard 1976. Mixing ratios by volume in ppm.

"""
    text += array("kAltitude_km", altitudes, "{:g}")
    text += "// Of each model:\n"
    for name, source in (("kPressure_hpa", "pressure_mb"), ("kTemperature_k", "temperature_K"), ("kWater_ppm", "h2o_ppmv"),
                         ("kOzone_ppm", "o3_ppmv"), ("kNitrousOxide_ppm", "n2o_ppmv"), ("kCarbonMonoxide_ppm", "co_ppmv"),
                         ("kMethane_ppm", "ch4_ppmv")):
        text += array(name, [column(m, source) for m in MODELS])
    text += "// Of all models:\n"
    for name, source in (("kCarbonDioxide330_ppm", "co2_ppmv"), ("kOxygen_ppm", "o2_ppmv"),
                         ("kNitricOxide_ppm", "no_ppmv"), ("kSulphurDioxide_ppm", "so2_ppmv"),
                         ("kNitrogenDioxide_ppm", "no2_ppmv"), ("kAmmonia_ppm", "nh3_ppmv"),
                         ("kNitricAcid_ppm", "hno3_ppmv")):
        values = [column(m, source) for m in MODELS]
        assert all(v == values[0] for v in values)
        text += array(name, values[0])
    (folder / "model_atmospheres.inc").write_text(text, encoding="utf-8")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    shared = Path(os.environ.get("MTFKIT_SHARED", REPOSITORY.parent / "shared"))
    parser.add_argument("--data", type=Path, default=shared / "data" / "atmosphere")
    parser.add_argument("--folder", type=Path, default=REPOSITORY / "radiometry" / "atmosphere" / "tables")
    options = parser.parse_args()
    write_coefficients(options.data, options.folder)
    write_model_atmospheres(options.data, options.folder)


if __name__ == "__main__":
    main()
