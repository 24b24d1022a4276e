# SPDX-License-Identifier: Apache-2.0
"""Twelve cameras, nine of photons and three of blackbodies, and their twins: 95 of 100 comparisons of good twins are within
1.96 standard deviations, at least 93 have to be (the errors of the numbers, which come from finitely many frames, add)."""

import collections

import numpy as np
from twins import PhotonCamera, ThermalCamera, compared, twin_of


def test_twelve_cameras_and_their_twins():
    draw, z = np.random.default_rng(53), collections.defaultdict(list)
    for number in range(12):
        camera = (ThermalCamera if number % 4 == 3 else PhotonCamera)(draw)
        twin = twin_of(camera)
        assert twin.adequate, (number, twin.reason)
        for (_, name), value in compared(camera, twin, seed=9000 + number).items():
            z[name].append(value)
    within = {name: np.mean(np.abs(values) < 1.96) for name, values in z.items()}
    for name, values in z.items():
        print(f"{name:12s} {len(values)}  within 1.96: {within[name]:.3f}  mean {np.mean(values):+.2f}  rms {np.sqrt(np.mean(np.square(values))):.2f}")
    every = np.concatenate(list(z.values()))
    print(f"all {every.size}: {np.mean(np.abs(every) < 1.96):.3f}, greatest {np.abs(every).max():.2f}")
    assert every.size >= 500 and np.mean(np.abs(every) < 1.96) >= 0.93
    assert np.abs(every).max() < 5.0
