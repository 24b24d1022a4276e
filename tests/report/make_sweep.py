#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Writes a folder as `mtf sweep` leaves it, for tests of the report. Usage: make_sweep.py DIR [--kind K] [--points N]

Kinds: grid (aperture x pitch), sobol (aperture, pitch and integration time), levels (aperture x band, a discrete axis),
infeasible (a grid on which no design meets its constraints), one (a single design, without objectives). The figures of merit are closed forms of a thermal camera:
right enough to look like a study, and computed here so that no result of ours stands behind the tests.
"""

import argparse
import hashlib
import json
import math
import struct
from pathlib import Path

FOCAL_MM = 200.0
JITTER_UM = 1.5
BANDS = {'["3.4 um", "4.8 um"]': (4.1, 1.0), '["7.8 um", "10 um"]': (8.9, 1.6)}  # middle in um, relative signal

SENSOR = """schema = 1
name = "MWIR camera, F/{f_number:.4g}, {pitch:.4g} um"

[frame]
focal_length = "200 mm"
pitch = "{pitch!r} um"
integration_time = "{time!r} ms"

[scene]
quantity = "temperature"
emissivity = 0.95

[path]
transmission = 0.8
air_temperature = "285 K"

[optics]
aperture = "{aperture!r} mm"
transmission = 0.85
emissivity = 0.1
temperature = "293 K"
stop_temperature = "77 K"

[band]
wavelength = {band}

[[presample]]
kind = "diffraction"
[[presample]]
kind = "footprint"
width = "{pitch!r} um"
[[presample]]
kind = "jitter"
rms = "1.5 um"

[detector]
quantum_efficiency = 0.75
full_well = "60 Me-"
dark_current = "1 Me-/s"
read_noise = "150 e-"

[nonuniformity]
prnu = 0.002
dsnu = "200 e-"

[noise]
seed = 1

[adc]
bits = 14
"""

STUDY = """schema = 1
name = "{name}"
sensor = "camera.toml"
constraints = ["mtf_nyquist > {limit}", "netd < {netd} mK"]
objectives = ["minimize netd", "maximize mtf50", "minimize aperture ^ 2.5"]
[metrics]
list = ["mtf_nyquist", "mtf50", "netd", "ifov", "niirs_giqe5"]
# axes as in sweep.json
"""


def diffraction(v):
    return 0.0 if v >= 1.0 else 2.0 / math.pi * (math.acos(v) - v * math.sqrt(1.0 - v * v))


def sinc(x):
    return 1.0 if x == 0.0 else math.sin(math.pi * x) / (math.pi * x)


def metrics(aperture_mm, pitch_um, time_ms, band):
    """mtf_nyquist, mtf50 in cy/mrad, netd in mK, ifov in urad."""
    wavelength, signal = BANDS[band]
    f_number = FOCAL_MM / aperture_mm
    def mtf(f):
        return (diffraction(f * wavelength * f_number / 1e3) * abs(sinc(f * pitch_um / 1e3)) *
                math.exp(-2.0 * (math.pi * JITTER_UM * f / 1e3) ** 2))
    low, high = 0.0, min(1e3 / pitch_um, 1e3 / (wavelength * f_number))
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if mtf(middle) > 0.5 else (low, middle)
    electrons = min(7e4 * signal * pitch_um ** 2 * time_ms / (1.0 + 4.0 * f_number ** 2) / 10.0, 8e6)
    noise = math.sqrt(electrons + 1e3 * time_ms + 150.0 ** 2)
    return mtf(500.0 / pitch_um), low * FOCAL_MM / 1e3, 1e3 * noise / (0.035 * electrons), 1e3 * pitch_um / FOCAL_MM


def radical_inverse(index, base):
    value, scale = 0.0, 1.0 / base
    while index:
        value += scale * (index % base)
        index //= base
        scale /= base
    return value


def column(name, unit, role, definition="", source="", **more):
    return {"name": name, "unit": unit, "role": role, "definition": definition, "source": source, **more}


def axes_and_points(kind, points):
    count = 1 if kind == "one" else max(2, round(math.sqrt(points)))
    apertures = [40.0 + 100.0 * i / max(1, count - 1) for i in range(count)]
    mwir = list(BANDS)[0]
    if kind == "levels":
        return ([{"column": "optics.aperture", "scale": "linear", "values": apertures},
                 {"column": "band.wavelength", "scale": "linear", "values": list(BANDS)}],
                [(a, 15.0, 8.0, b) for a in apertures for b in BANDS], "grid")
    if kind == "sobol":
        def sample(i):
            u, v, w = (radical_inverse(i + 1, base) for base in (2, 3, 5))
            return 40.0 + 100.0 * u, 8.0 + 17.0 * v, math.exp(math.log(1.0) + math.log(16.0) * w), mwir
        return ([{"column": "optics.aperture", "scale": "linear"}, {"column": "frame.pitch", "scale": "linear"},
                 {"column": "frame.integration_time", "scale": "log"}], [sample(i) for i in range(points)], "sobol")
    pitches = [8.0 + 17.0 * i / max(1, count - 1) for i in range(count)]
    return ([{"column": "optics.aperture", "scale": "linear", "values": apertures},
             {"column": "frame.pitch", "scale": "linear", "values": pitches}],
            [(a, p, 8.0, mwir) for a in apertures for p in pitches], "grid")


def pareto_of(rows, candidates):
    """Indices not dominated; every figure is to be small."""
    front = []
    for i in sorted(candidates, key=lambda k: rows[k]):
        if not any(all(b <= a for a, b in zip(rows[i], rows[k])) for k in front):
            front.append(i)
    return sorted(front)


def field(value):
    if value is None:
        return ""
    if isinstance(value, str):
        return '"' + value.replace('"', '""') + '"' if any(c in value for c in ',"\n') else value
    return repr(value) if isinstance(value, float) and value != int(value) else str(int(value))


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("folder", type=Path)
    parser.add_argument("--kind", default="grid", choices=["grid", "sobol", "levels", "infeasible", "one"])
    parser.add_argument("--points", type=int, default=400)
    parser.add_argument("--name", default="MWIR search camera: aperture against pitch")
    options = parser.parse_args()
    folder, kind = options.folder, options.kind
    (folder / "chosen").mkdir(parents=True, exist_ok=True)
    limit, netd_limit = (0.9, 1.0) if kind == "infeasible" else (0.15, 40.0)

    axes, points, method = axes_and_points(kind, options.points)
    names = [axis["column"] for axis in axes]
    where = {"optics.aperture": 0, "frame.pitch": 1, "frame.integration_time": 2, "band.wavelength": 3}
    units = {"optics.aperture": "mm", "frame.pitch": "um", "frame.integration_time": "ms", "band.wavelength": ""}
    columns = [column(n, units[n], "axis", **({"levels": list(BANDS)} if n == "band.wavelength" else {})) for n in names]
    columns += [
        column("optics.f_number", "", "link", "focal_length / aperture"),
        column("mtf_nyquist", "", "metric", "MTF of the system at the Nyquist frequency of the pitch", "ISO 15529"),
        column("mtf50", "cy/mrad", "metric", "Frequency at which the system MTF falls to one half", "Boreman, ch. 1"),
        column("netd", "mK", "metric", "Temperature difference of a large target that gives SNR 1 in one frame",
               "Lloyd, Thermal Imaging Systems, ch. 5"),
        column("ifov", "urad", "metric", "Pitch over focal length", "Holst, ch. 2"),
        column("niirs_giqe5", "", "metric", "Image quality on the NIIRS by the GIQE, version 5", "NGA, 2015",
               gap="it needs [conditions] gsd, which this study does not state", missing=len(points)),
        column("aperture ^ 2.5", "mm^2.5", "objective", "Cost of the optics"),
        column("feasible", "", "feasible", "1 where every constraint holds"),
        column("yield", "", "yield", "Share of the as-built draws that meet every constraint"),
        column("error", "", "error", "Largest error bound of the metrics")]
    rows, facts = [], []
    for index, point in enumerate(points):
        nyquist, mtf50, netd, ifov = metrics(*point)
        feasible = nyquist > limit and netd < netd_limit
        share = max(0.0, min(1.0, 0.5 + (nyquist - limit) * 8.0)) if feasible else None
        cost = point[0] ** 2.5
        rows.append([point[where[n]] for n in names] +
                    [FOCAL_MM / point[0], nyquist, mtf50, netd, ifov, None, cost, int(feasible),
                     share, 1e-6 * (1.0 + index % 7)])
        facts.append((netd, -mtf50, cost, nyquist))
    columns[-2]["missing"] = sum(row[-2] is None for row in rows)
    for c in columns:
        c.setdefault("missing", 0)

    good = [i for i, row in enumerate(rows) if row[-3]]
    # On the grid NETD is a constraint only, so that the front is a line in the plane of the two objectives.
    wanted = (("netd", False, 0), ("mtf50", True, 1), ("aperture ^ 2.5", False, 2))[{"sobol": 0, "one": 3}.get(kind, 1):]
    front = pareto_of([tuple(f[k] for _, _, k in wanted) for f in facts], good)
    constraints = [
        {"text": f"mtf_nyquist > {limit}", "met": sum(f[3] > limit for f in facts), "columns": ["mtf_nyquist"],
         "limit": limit, "relation": ">"},
        {"text": f"netd < {netd_limit} mK", "met": sum(f[0] < netd_limit for f in facts), "columns": ["netd"],
         "limit": netd_limit, "relation": "<"}]
    best = []
    for text, maximize, k in wanted:
        if good:
            design = min(good, key=lambda i: facts[i][k])
            near = [t for t, x in ((constraints[0]["text"], facts[design][3] / limit),
                                   (constraints[1]["text"], netd_limit / facts[design][0])) if x < 1.05]
            best.append({"objective": text, "design": design,
                         "value": -facts[design][k] if maximize else facts[design][k], "active": near,
                         "limits": [{"text": t, "kind": "constraint", "state": "the next step of the grid breaks it"} for t in near]})
    chosen = {b["design"]: f"best {b['objective']}" for b in reversed(best)}
    for k in range(1, 5):
        if front:
            chosen.setdefault(front[k * len(front) // 5], "on the Pareto front")
    if not good or kind == "one":
        chosen = {0: "nearest to the constraints" if not good else "the only design"}
    sensors = {}
    for design in chosen:
        aperture, pitch, time, band = points[design]
        sensors[f"chosen/design_{design}.toml"] = SENSOR.format(
            f_number=FOCAL_MM / aperture, pitch=pitch, time=time, aperture=aperture, band=band)
    base = SENSOR.format(f_number=2.0, pitch=15.0, time=8.0, aperture=100.0, band=list(BANDS)[0])
    study = STUDY.format(name=options.name.replace('"', '\\"'), limit=limit, netd=netd_limit)

    on_front = set(front)
    columns.append(column("pareto", "", "pareto", "1 for a design of the Pareto front", missing=0))
    table = [row + [int(i in on_front)] for i, row in enumerate(rows)]
    header = ",".join(["design"] + [field(c["name"]) for c in columns])
    (folder / "designs.csv").write_text(
        "\n".join([header] + [",".join([str(i)] + [field(v) for v in row]) for i, row in enumerate(table)]) + "\n")
    with open(folder / "designs.npy", "wb") as out:
        head = f"{{'descr': '<f8', 'fortran_order': False, 'shape': ({len(rows)}, {len(columns)}), }}"
        head += " " * (-(10 + len(head) + 1) % 64) + "\n"
        out.write(b"\x93NUMPY\x01\x00" + struct.pack("<H", len(head)) + head.encode())
        for row in table:
            numbers = [float("nan") if v is None else float(list(BANDS).index(v)) if isinstance(v, str) else float(v)
                       for v in row]
            out.write(struct.pack(f"<{len(numbers)}d", *numbers))
    (folder / "study.toml").write_text(study)
    (folder / "camera.toml").write_text(base)
    for name, text in sensors.items():
        (folder / name).write_text(text)

    def sha(text):
        return hashlib.sha256(text.encode()).hexdigest()
    reference = best[0]["design"] if best else 0
    parameters = [n for n in names if n != "band.wavelength"]
    sweep = {
        "schema": 1, "kind": "sweep", "version": "0.1.0", "commit": "fixture", "date": "2026-02-28",
        "conditions": {"temperature_k": 300.0, "lines": ["scene: surface of 300 K"]}, "machine": "2 cores, x86-64",
        "study": {"name": options.name, "file": "study.toml", "sha256": sha(study)},
        "sensors": [{"file": "camera.toml", "sha256": sha(base)}],
        "designs": len(rows), "evaluated": len(rows), "method": method, "seed": 1, "tolerance": 1e-4,
        "worst_error": max(row[-1] for row in rows), "columns": columns, "axes": axes,
        "constraints": constraints,
        "objectives": [{"text": text, "column": text, "maximize": maximize} for text, maximize, _ in wanted],
        "feasible": len(good), "best": best, "pareto": front[:10000], "pareto_size": len(front),
        "chosen": [{"design": d, "file": f"chosen/design_{d}.toml", "why": why} for d, why in sorted(chosen.items())],
        "sensitivities": {
            "design": reference,
            "derivatives": [{"column": c, "parameter": p, "value": (-0.8) ** j * s, "unit": f"{u} per {units[p]}"}
                            for c, u, s in (("mtf_nyquist", "1", 0.004), ("netd", "mK", -0.6))
                            for j, p in enumerate(parameters)],
            "samples": 4096,
            "indices": [{"column": c, "parameter": p, "first": a / (j + 1), "first_sd": 0.01, "total": a / (j + 1) + 0.08,
                         "total_sd": 0.012} for c, a in (("mtf_nyquist", 0.55), ("netd", 0.62), ("mtf50", 0.48))
                        for j, p in enumerate(parameters)]},
        "yield": {"draws": 200, "best": [{"design": b["design"], "yield": rows[b["design"]][-2]} for b in best]},
        "accuracy": [{"tolerance": 10.0 ** -k, "promised": 0.7 * 10.0 ** -k, "realised": 0.02 * 10.0 ** -k,
                      "us_per_design": 9.0 + 2.3 * k * k} for k in range(2, 10)],
        "timing": {"seconds": 0.8, "designs_per_second": len(rows) / 0.8, "threads": 2, "resumed_designs": 0},
        "skipped": ["niirs_giqe5: no design has it, it needs [conditions] gsd",
                    "diffraction of 380 designs: shared with the design before, whose aperture is the same"]}
    if not good:
        sweep["nearest"] = {"design": 0, "violated": [c["text"] for c in sweep["constraints"]]}
    (folder / "sweep.json").write_text(json.dumps(sweep, indent=1))


if __name__ == "__main__":
    main()
