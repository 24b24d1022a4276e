# SPDX-License-Identifier: Apache-2.0
"""Figures of merit of one sensor: the metrics of studies, by their names."""

from __future__ import annotations

import os
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

from mtfkit import quantities
from mtfkit.budgets import Figure
from mtfkit.studies import Study

if TYPE_CHECKING:
    from mtfkit.sensors import Sensor


def metrics(sensor: Sensor, names: Iterable[str], *, tolerance: float = 1e-6,
            **conditions: quantities.Value) -> dict[str, Figure]:
    """Figures of merit of a sensor, by name: those of the metrics of a study, bit for bit.

    `names` as in apps/study/README.md: mtf_nyquist, mtf50_x, rer, fwhm, strehl, q, snr, netd, niirs_giqe5, mrtd,
    ttp_range_identify, ... `conditions` are the keys of [conditions]: range="500 km", contrast="2 K",
    temperature="300 K", ... A figure without a value is NaN and says why. Raises UsageError for unknown names.

    >>> import mtfkit as mk
    >>> sensor = mk.Sensor(frame=dict(focal_length="100 mm", pitch="15 um"), presample=[mk.Footprint(width="15 um")])
    >>> round(mk.metrics(sensor, ["mtf_nyquist_x"])["mtf_nyquist_x"].value, 6)
    0.63662
    """
    import tempfile

    if sensor._functions:
        raise sensor._functions[0].refusal("metrics")
    asked = [names] if isinstance(names, str) else list(names)
    lines = ["schema = 1", 'sensor = "sensor.toml"', f"tolerance = {tolerance!r}", "[[axis]]",
             'parameter = "frame.focal_length"', f"values = [{sensor._file.stated('frame.focal_length')}]", "[metrics]",
             f"list = {quantities.toml(asked, 'names')}"]
    if conditions:
        lines += ["[conditions]", *(f"{key} = {quantities.toml(value, key)}" for key, value in conditions.items())]
    with tempfile.TemporaryDirectory(prefix="mtfkit-metrics-") as folder:
        sensor.save(os.path.join(folder, "sensor.toml"))
        path = os.path.join(folder, "study.toml")
        with open(path, "w", encoding="utf-8") as file:
            file.write("\n".join(lines) + "\n")
        study = Study.load(path)
        row = study.rows(0, 1)[0]
        gaps, refusal = study._study.gaps()
    made: dict[str, Any] = {}
    for column, value, gap in zip(study.columns, row, gaps):
        if column.role == "metric" and column.name in asked:
            reason = "" if value == value else gap or refusal
            made[column.name] = Figure(column.name, float(value), column.unit, column.definition, reason)
    return made
