#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Constants of test_emva1288.cpp: a small set of frames by whole numbers alone, and the numbers of EMVA 1288 R4.0 Linear
of it from the frames themselves, by the standard's definitions, in numpy. They do not go through mean squares."""

import itertools

import numpy as np

ROWS, COLUMNS = 12, 16


class Bytes:
    """The upper byte of a linear congruential generator (Knuth, TAOCP 2, 3.3.4: MMIX)."""

    def __init__(self):
        self.state = 1288

    def next(self):
        self.state = (6364136223846793005 * self.state + 1442695040888963407) % 2**64
        return self.state >> 56

    def noise(self):
        """About normal, sd 256."""
        return sum(self.next() for _ in range(12)) - 1530


def frame(source, mean, sd_256, pattern, clip):
    """Counts: mean and pattern in 1/256."""
    return np.array([[min((256 * mean + mean * pattern[r, c] + (sd_256 * source.noise()) // 256 + 128) // 256, clip)
                      for c in range(COLUMNS)] for r in range(ROWS)])


def make():
    """(exposure in ms, photons, frames); levels 11 and 12 are clipped."""
    source = Bytes()
    pattern = np.array([[source.next() % 9 - 4 for _ in range(COLUMNS)] for _ in range(ROWS)])
    stacks = []
    for k in range(1, 13):
        signal = 100 * k - k * k
        for light, count in ((400 * k, 2), (0, 2)) + (((400 * k, 5), (0, 5)) if k == 5 else ()):
            mean, variance = (80 + k + signal, 12 + signal / 2) if light else (80 + k, 10 + k)
            sd = int(256 * variance**0.5)
            stacks.append((k, light, [frame(source, mean, sd, pattern, 1040) for _ in range(count)]))
    return stacks


def line(x, y, weight):
    a = np.stack([x, np.ones_like(x)], 1) * np.sqrt(weight)[:, None]
    return np.linalg.lstsq(a, y * np.sqrt(weight), rcond=None)[0]


def spatial(frames):
    """Whole, row, column, pixel."""
    L = len(frames)
    stack = np.var(frames, axis=0, ddof=1).mean()
    y = np.mean(frames, axis=0)
    whole = y.var(ddof=1) - stack / L
    columns, rows = y.mean(axis=0).var() - stack / (L * ROWS), y.mean(axis=1).var() - stack / (L * COLUMNS)
    equations = [[1, 1, 1], [0, 1, 1 / ROWS], [1, 0, 1 / COLUMNS]]
    return np.array([whole, *np.linalg.solve(equations, [whole, columns, rows])])


def numbers(stacks):
    def moments(f):
        a, b = (np.asarray(x, float) for x in f)
        return (a.mean() + b.mean()) / 2, ((a - b) ** 2).mean() / 2 - (a.mean() - b.mean()) ** 2 / 2

    pairs = {(t, p): moments(f) for t, p, f in stacks if len(f) == 2}
    large = {p > 0: f for t, p, f in stacks if len(f) > 2}
    bright = sorted(key for key in pairs if key[1] > 0)
    t = np.array([key[0] * 1e-3 for key in bright])
    p = np.array([float(key[1]) for key in bright])
    dark = np.array([pairs[key[0], 0] for key in bright])
    y = np.array([pairs[key][0] for key in bright]) - dark[:, 0]
    v = np.array([pairs[key][1] for key in bright])
    top = int(np.argmax(v))
    low = slice(0, np.flatnonzero(y <= 0.7 * y[top]).max() + 1)
    K = (y[low] * (v - dark[:, 1])[low]).sum() / (y[low] ** 2).sum()
    R = (y[low] * p[low]).sum() / (p[low] ** 2).sum()
    by_time = line(t, dark[:, 1], np.ones_like(t))
    noise = max(0.24, by_time[1]) ** 0.5
    part = slice(np.flatnonzero(y >= 0.05 * y[top]).min(), np.flatnonzero(y <= 0.95 * y[top]).max() + 1)
    slope, offset = line(p[part], y[part], y[part] ** -2.0)
    error = 100 * (y[part] / (slope * p[part] + offset) - 1)
    full = R / K * p[top]
    values = {"K": K, "R": R, "eta": 100 * R / K, "sigma_y.dark": noise, "sigma_d": (noise**2 - 1 / 12) ** 0.5 / K,
              "mu_e.min": noise / K + 0.5, "mu_p.min": (noise / K + 0.5) * K / R, "mu_p.sat": p[top], "mu_e.sat": full,
              "DR": full / (noise / K + 0.5), "SNR_max": full**0.5, "LE_min": error.min(), "LE_max": error.max(),
              "mu_I.mean": line(t, dark[:, 0], np.ones_like(t))[0] / K, "mu_I.var": by_time[0] / K**2}
    lit, unlit = spatial(large[True]), spatial(large[False])
    signal = np.mean(large[True]) - np.mean(large[False])
    for k, name in enumerate(("", "_row", "_column", "_pixel")):
        values["DSNU" + name] = unlit[k] ** 0.5 / K if unlit[k] > 0 else None
        squares = lit[k] - unlit[k]
        values["PRNU" + name] = 100 * squares**0.5 / signal if squares > 0 else None
    return values


if __name__ == "__main__":
    made = make()
    print("sum of all counts", sum(int(np.sum(f)) for f in itertools.chain(*(s[2] for s in made))))
    for key, value in numbers(made).items():
        print(f'{{"{key}", {"kNone" if value is None else repr(float(value))}}},')
