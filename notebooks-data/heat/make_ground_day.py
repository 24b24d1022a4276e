#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Makes ground_weather.csv: a clear day by the weather model of `mtf scene demo`, and the long-wave radiation that comes
up from a ground of other numbers than the file's first guess, as `mtf heat` solves them, with noise.
Usage: make_ground_day.py [MTF]

L_up = epsilon sigma T^4 + (1 - epsilon) L_down. The noise of T is first-order autoregressive: 0.3 K, correlated for
30 min, as what a model of the ground leaves out is.
"""

import csv
import math
import pathlib
import random
import re
import subprocess
import sys
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
TRUTH = {"5 W/m2/K": "9 W/m2/K", "3 W/m2/K/(m/s)": "2.2 W/m2/K/(m/s)", "0.3 W/m/K": "0.55 W/m/K", "0 W/m2": "6 W/m2"}
SIGMA, EMISSIVITY, SD_K, STEP_MIN, CORRELATED_MIN = 5.670374419e-8, 0.95, 0.3, 10.0, 30.0


def main():
    mtf = sys.argv[1] if len(sys.argv) > 1 else "mtf"
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        subprocess.run([mtf, "scene", "demo", "-o", str(folder / "demo")], check=True, stdout=subprocess.DEVNULL)
        lines = (folder / "demo/weather.csv").read_text().splitlines()
        head = next(line for line in lines if line.startswith("time,"))
        rows = [line for line in lines if re.match(r"\d", line)]
        first = next(i for i, row in enumerate(rows) if row[11:16] == "07:00")
        rows = rows[first:first + int(24 * 60 / STEP_MIN)]
        (folder / "ground_weather.csv").write_text("\n".join([head, *rows]) + "\n")
        text = (HERE / "ground.toml").read_text()
        for guess, true in TRUTH.items():
            text = text.replace(f'value = "{guess}"', f'value = "{true}"')
        (folder / "ground.toml").write_text(text)
        subprocess.run([mtf, "heat", str(folder / "ground.toml"), "-o", str(folder / "out"), "--tolerance", "0.01 K"],
                       check=True, stdout=subprocess.DEVNULL)
        with open(folder / "out/regions.csv") as file:
            kelvin = [float(row["mean_K"]) for row in csv.DictReader(file)]
    longwave = next(i for i, name in enumerate(head.split(",")) if name.startswith("longwave_down"))
    random.seed(1)
    phi = math.exp(-STEP_MIN / CORRELATED_MIN)
    noise = random.gauss(0.0, 1.0)
    out = ["# A clear day by a model, not measured: Bird and Hulstrom's clear sky, a daily wave of temperature and wind,",
           "# constant vapour, Brutsaert's long wave. longwave_up: of a ground solved by mtf heat (make_ground_day.py).",
           head + ",longwave_up (W/m2)"]
    for row, t in zip(rows, kelvin):
        measured = t + SD_K * noise
        noise = phi * noise + math.sqrt(1.0 - phi * phi) * random.gauss(0.0, 1.0)
        down = float(row.split(",")[longwave])
        out.append(f"{row},{EMISSIVITY * SIGMA * measured ** 4 + (1.0 - EMISSIVITY) * down:.2f}")
    (HERE / "ground_weather.csv").write_text("\n".join(out) + "\n")


if __name__ == "__main__":
    main()
