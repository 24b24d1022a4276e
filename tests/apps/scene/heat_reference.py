#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Surface temperatures of a scene by another route: the numbers of test_heat_reference.cpp.

  heat_reference.py FOLDER [TIME_S ...]      FOLDER has scene.toml, w.csv, m.obj as that test writes them

Facets that see the sky and the ground (black, as warm as the air) alone; weather as straight lines of w.csv. What it
shares with mtfkit are the equations of its READMEs. Own finite volumes, 80 and 160 cells a layer, extrapolated; Radau
IIA of order 5 (scipy), steps to 6e-7 K, restarted at every record, at sunrise and sunset, and where the
sun passes the plane of the facet; the sun by ERFA's apco13 and atioq (astropy's pyerfa); the start that repeats by
Newton's method with the product of the linearised steps of a day. Needs python3-scipy and python3-erfa.
"""
import functools
import math
import sys
import tomllib

import erfa
import numpy as np
from scipy.interpolate import CubicSpline
from scipy.integrate import solve_ivp
from scipy.sparse import csc_matrix

SIGMA, DAY = 5.670374419e-8, 86400.0
KEYS = ["air_temperature", "wind_speed", "longwave_down", "direct_normal", "diffuse_horizontal"]


def number(text):
    return float(str(text).split()[0])


def to_sun(utc, place):
    """East, north, up: apparent place without refraction, UT1 = UTC."""
    astrom, _ = erfa.apco13(2440587.5, utc / DAY, 0.0, *place, 0.0, 0.0, 0.0, 0.0, 0.0, 0.55)
    tt = erfa.taitt(*erfa.utctai(2440587.5, utc / DAY))
    helio, bary = erfa.epv00(*tt)
    natural = bary["p"] - helio["p"] - astrom["eb"]
    proper = erfa.ab(natural / np.linalg.norm(natural), astrom["v"], astrom["em"], astrom["bm1"])
    azimuth, zenith = erfa.atioq(*erfa.c2s(astrom["bpn"] @ proper), astrom)[:2]
    return np.array([math.sin(zenith) * math.sin(azimuth), math.sin(zenith) * math.cos(azimuth), math.cos(zenith)])


def zeros(f, end):
    found, t = [], np.arange(0.0, end + 60.0, 60.0).clip(max=end)
    for a, b in zip(t[:-1], t[1:]):
        if (f(a) > 0) == (f(b) > 0):
            continue
        for _ in range(60):
            middle = 0.5 * (a + b)
            a, b = (middle, b) if (f(middle) > 0) == (f(a) > 0) else (a, middle)
        found.append(0.5 * (a + b))
    return found


def grid(layers, cells):
    """Capacities of nodes, conductances between them; cells grow by 30 (100 below a day's depth) in the first layer."""
    mass, conductance = [0.0], []
    for i, (k, density, heat, thickness) in enumerate(layers):
        deep = thickness / math.sqrt(k / (density * heat) * 2000.0)
        n = 2 if thickness / k < 1e-4 else cells
        size = np.exp(np.linspace(0.0, math.log(30.0 * max(1.0, deep)) if deep > 0.4 and i == 0 else 0.0, n))
        for dx in size / size.sum() * thickness:
            mass[-1] += 0.5 * dx * density * heat
            mass.append(0.5 * dx * density * heat)
            conductance.append(k / dx)
    return np.array(mass), np.array(conductance)


def solve(scene, weather, sun, normal, material, times, cells):
    eps, a, convection, up = material["emissivity"], material["solar_absorptance"], material["convection"], normal[2]
    m, k = grid([[number(layer[key]) for key in ("conductivity", "density", "heat_capacity", "thickness")]
                 for layer in material["layers"]], cells)
    n, sky = len(m), 0.5 * (1.0 + up)
    aided, hindered = (9.482 / (7.283 - abs(up)), 1.810 / (1.382 + abs(up))) if up else (1.31, 1.31)
    warm, cold = (aided, hindered) if up >= 0 else (hindered, aided)
    tarp = convection == "tarp"

    def film(wind):
        if convection == "mcadams":
            return 5.7 + 3.8 * wind
        if convection == "none":
            return 0.0
        if tarp:
            return 2.537 * 1.67 * math.sqrt(max(0.0, 4.0 * wind))
        return number(convection["h0"]) + number(convection["h1"]) * wind

    end = max(DAY, scene["end"])
    facing = lambda t: float(sun(t) @ normal)
    stops = sorted({0.0, end, *[t for t in weather["t"] if t < end], *zeros(lambda t: sun(t)[2], end), *zeros(facing, end)})
    matrix = np.zeros((n, n))
    i = np.arange(n - 1)
    matrix[i, i] -= k
    matrix[i + 1, i + 1] -= k
    matrix[i, i + 1] += k
    matrix[i + 1, i] += k
    matrix /= m[:, None]
    sparse = csc_matrix(matrix)

    def part(t0, t1):
        at = [[np.interp(t, weather["t"], weather[key]) for key in KEYS] for t in (t0 + 1e-7, t1 - 1e-7)]
        lit = sun(0.5 * (t0 + t1))[2] > 0 and facing(0.5 * (t0 + t1)) > 0

        def front(t, x):
            u = (t - t0) / (t1 - t0)
            air, wind, longwave, direct, diffuse = ((1 - u) * p + u * q for p, q in zip(*at))
            excess, h = x - air, film(wind)
            c = (warm if excess > 0 else cold) * abs(excess) ** (1 / 3) if tarp else 0.0
            gain = a * (direct * max(0.0, facing(t)) * lit + sky * diffuse) + eps * (
                sky * longwave + (1 - sky) * SIGMA * air**4)
            return gain - eps * SIGMA * x**4 - (h + c) * excess, -4 * eps * SIGMA * x**3 - h - 4 / 3 * c

        def rate(t, x):
            change = sparse @ x
            change[0] += front(t, x[0])[0] / m[0]
            return change

        def slope(t, x):
            return sparse + csc_matrix(([front(t, x[0])[1] / m[0]], ([0], [0])), (n, n))

        return t0, t1, rate, slope

    parts = [part(t0, t1) for t0, t1 in zip(stops[:-1], stops[1:]) if t1 - t0 > 1e-6]

    def run(x, until, tolerance):
        out = {0.0: x[0]}
        for t0, t1, rate, slope in parts:
            if t0 >= until - 1e-6:
                break
            wanted = [t for t in times if t0 < t <= t1]
            asked = sorted({*wanted, t1})
            found = solve_ivp(rate, (t0, t1), x, "Radau", asked, jac=slope, rtol=tolerance, atol=tolerance * 300.0)
            out.update(zip(found.t, found.y[0]))
            x = found.y[:, -1]
        return x, out

    def monodromy(x):
        x, product, one = x.copy(), np.eye(n), np.eye(n)
        for t0, t1, rate, slope in parts:
            steps = max(1, int((t1 - t0) / 120.0))
            h = (t1 - t0) / steps
            for s in range(steps if t0 < DAY - 1e-6 else 0):
                jacobian = slope(t0 + (s + 0.5) * h, x).toarray()
                inverse = np.linalg.inv(one - h * jacobian)
                x = inverse @ (x + h * (rate(t0 + (s + 0.999) * h, x) - jacobian @ x))
                product = inverse @ product
        return product

    x = np.full(n, weather["air_temperature"].mean())
    for turn in range(30):
        after, _ = run(x, DAY, 1e-6 if turn < 3 else 1e-9)
        step = np.linalg.solve(np.eye(n) - monodromy(x), after - x)
        x = x + step
        if turn > 3 and np.abs(step).max() < 1e-5:
            break
    _, out = run(x, end, 1e-9)
    return np.array([out[t] for t in times])


def main():
    folder, times = sys.argv[1], [float(t) for t in sys.argv[2:]]
    with open(folder + "/scene.toml", "rb") as file:
        text = tomllib.load(file)
    start = text["time"]["start"]
    scene = {"end": (text["time"]["end"] - start).total_seconds()}
    rows = [line.strip().split(",") for line in open(folder + "/w.csv")]
    names = [cell.split()[0] for cell in rows[0]]
    values = np.array(rows[1:], dtype=float)
    weather = {"t": values[:, 0], **{key: values[:, names.index(key)] for key in KEYS}}
    place = (math.radians(number(text["place"]["longitude"])), math.radians(number(text["place"]["latitude"])),
             number(text["place"]["altitude"]))
    grid_s = np.arange(-60.0, max(DAY, scene["end"]) + 120.0, 20.0)
    spline = CubicSpline(grid_s, [to_sun(start.timestamp() + t, place) for t in grid_s])
    sun = functools.lru_cache(maxsize=64)(lambda t: (lambda v: v / np.linalg.norm(v))(spline(t)))
    materials = {material["name"]: material for material in text["material"]}
    vertices, group = [], ""
    for line in open(folder + "/m.obj"):
        kind, *cells = line.split()
        if kind == "v":
            vertices.append(np.array(cells, dtype=float))
        if kind == "g":
            group = cells[0]
        if kind != "f":
            continue
        p, q, r = (vertices[int(c) - 1] for c in cells[:3])
        normal = np.cross(q - p, r - p)
        coarse, fine = (solve(scene, weather, sun, normal / np.linalg.norm(normal), materials[group], times, cells)
                        for cells in (80, 160))
        exact = fine + (fine - coarse) / 3.0
        print(group, " ".join(f"{t:.5f}" for t in exact), f"(cells leave {np.abs(fine - coarse).max() / 3.0:.1e} K)")


if __name__ == "__main__":
    main()
