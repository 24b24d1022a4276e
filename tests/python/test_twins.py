# SPDX-License-Identifier: Apache-2.0
"""The twin of one camera of each kind, and that the comparisons see a twin that is wrong. Twelve cameras: test_twins_long.py."""

import numpy as np
import pytest
from twins import FaultyCamera, PhotonCamera, ThermalCamera, compared, faults, frames_of, twin_of


@pytest.mark.parametrize("kind", [PhotonCamera, ThermalCamera])
def test_frames_of_the_twin_are_as_the_camera_s_own(kind):
    camera = kind(np.random.default_rng(2026))
    twin = twin_of(camera)
    assert twin.adequate, twin.reason
    z = compared(camera, twin, seed=4711)
    # 5 % of good comparisons are beyond 1.96: of these 52 (39 of blackbodies) more than seven with a probability of 5e-3 (1e-3).
    assert sum(abs(value) > 1.96 for value in z.values()) <= 7, z
    assert max(abs(value) for value in z.values()) < 4.5, z


@pytest.mark.parametrize(("key", "factor", "test"), [
    ("detector.read_noise", 1.1, "tvh"), ("nonuniformity.dsnu", 1.1, "vh"), ("noise.row", 1.5, "tv"), ("adc.electrons_per_count", 0.97, "tvh"),
    ("readout[0].side", 0.0, "lag row")])
def test_a_wrong_twin_is_told(key, factor, test):
    camera = PhotonCamera(np.random.default_rng(2026))
    number, _, unit = str(camera.sensor[key]).partition(" ")
    changed = camera.sensor.replace({key: f"{float(number) * factor} {unit}".strip()})

    class Twin:
        sensor = changed

    assert max(abs(z) for (_, name), z in compared(camera, Twin, seed=4711).items() if name == test) > 4.5


def test_defects_and_slow_noise_are_in_the_twin():
    camera = FaultyCamera(np.random.default_rng(2027))
    twin = twin_of(camera)
    assert twin.adequate, twin.reason
    level = camera.levels[7]
    own = faults(frames_of(camera.sensor, camera.levels[0], 100_001), frames_of(camera.sensor, level, 100_101))
    its = faults(frames_of(twin.sensor, camera.levels[0], 1, 4711), frames_of(twin.sensor, level, 101, 4711))
    # The errors of the twin's numbers are as large as those of the comparison.
    z = {name: (its[name][0] - own[name][0]) / np.sqrt(2.0 * (own[name][1] ** 2 + its[name][1] ** 2)) for name in own}
    assert max(abs(value) for value in z.values()) < 4.0, z
    assert own["power of 8"][0] > 2.0 * own["power of 1"][0]
