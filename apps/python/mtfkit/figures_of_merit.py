# SPDX-License-Identifier: Apache-2.0
"""Figures of merit of one sensor: the metrics of studies, by their names."""

from __future__ import annotations

import json
import re
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

from mtfkit import quantities
from mtfkit.arguments import checked
from mtfkit.budgets import Figure, Figures
from mtfkit.errors import UsageError
from mtfkit.messages import reworded
from mtfkit.studies import Study

if TYPE_CHECKING:
    from mtfkit.sensors import Sensor


@checked
def metrics(sensor: Sensor, names: str | Iterable[str], *, tolerance: float = 1e-6,
            **conditions: quantities.Value) -> Figures:
    """Figures of merit of a sensor, by name: those of the metrics of a study, bit for bit.

    `names` as in apps/study/README.md: mtf_nyquist, mtf50_x, rer, fwhm, strehl, q, snr, netd, niirs_giqe5, mrtd,
    ttp_range_identify, ... `conditions` are the keys of [conditions]: range="500 km", contrast="2 K",
    temperature="300 K", ... A figure without a value is NaN and says why. Raises UsageError for unknown names.

    >>> import mtfkit as mk
    >>> sensor = mk.Sensor(frame=dict(focal_length="100 mm", pitch="15 um"), presample=[mk.Footprint(width="15 um")])
    >>> round(mk.metrics(sensor, ["mtf_nyquist_x"])["mtf_nyquist_x"].value, 6)
    0.63662
    """
    if sensor._functions:
        raise sensor._functions[0].refusal("metrics")
    asked = [names] if isinstance(names, str) else list(names)
    if not all(isinstance(name, str) for name in asked):
        raise UsageError(f"names: {quantities.shown(asked)} is no list of names of metrics")
    stated = sensor._file.stated("frame.focal_length")
    with reworded(lambda text: re.sub(r"(?m)^metrics\b", "names", re.sub(r"(?m)^conditions\.", "", text))):
        study = Study(sensor, axes={"frame.focal_length": [json.loads(stated) if stated.startswith('"') else float(stated)]},
                      metrics=asked, conditions=conditions, tolerance=tolerance)
        row = study.rows(0, 1)[0]
        gaps, refusal = study._study.gaps()
    made: dict[str, Figure] = {}
    for column, value, gap in zip(study.columns, row, gaps):
        if column.role == "metric" and column.name in asked:
            reason = "" if value == value else gap or refusal
            made[column.name] = Figure(column.name, float(value), column.unit, column.definition, reason)
    return Figures(made)
