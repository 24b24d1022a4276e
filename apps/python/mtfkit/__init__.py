# SPDX-License-Identifier: Apache-2.0
"""OTF models of electro-optical and infrared sensors: simulate, measure, fit, trade studies.

A Sensor is a value: load it, or build it of keywords. Results are numbers with their units and, where a method is
approximate, the error that it promises. Lengths, angles and times are texts with a unit, "15 um", or (15, "um").
The guide is apps/python/README.md; `help(mtfkit.Sensor)` and `mtfkit.kinds()` say what there is.
"""

from __future__ import annotations

import importlib.util
import platform
from typing import TYPE_CHECKING, Any

if importlib.util.find_spec("mtfkit._core") is None:
    raise ImportError(f"{__path__[0]} has no module _core for Python {platform.python_version()}; build it by `cmake --build build` in "
                      "the clone of mtfkit, and use the Python that it was built for, /usr/bin/python3 on Debian")
del importlib, platform

from mtfkit import air, components, light, noise, targets
from mtfkit._core import __version__
from mtfkit.budgets import Budget, Figure, Figures
from mtfkit.cameras import Camera, CameraNumber, Stack, characterize
from mtfkit.components import Component, kinds
from mtfkit.curves import Column, Curves
from mtfkit.custom import Custom, General, Sampled, custom
from mtfkit.edges import Edge, Edges, Estimate, measure
from mtfkit.errors import DataError, Error, ToleranceError, UsageError
from mtfkit.figures_of_merit import metrics
from mtfkit.fits import CurveData, Fit, Parameter, fit
from mtfkit.images import CountTemperatures, Image, read, write
from mtfkit.findings import Finding, Findings
from mtfkit.scenes import Heat, Picture, heat, render
from mtfkit.sensors import Sensor
from mtfkit.plans import Plan, devices
from mtfkit.runs import Run
from mtfkit.studies import Study
from mtfkit.study_results import Gradient, Optimum, StudyColumn
if TYPE_CHECKING:  # a class for each kind of component, made when one is asked for
    from mtfkit.components import *

__all__ = ["Budget", "Camera", "CameraNumber", "Column", "Component", "CountTemperatures", "CurveData", "Curves", "Custom", "DataError", "Edge", "Edges",
           "Error", "Estimate", "Figure", "Figures", "Finding", "Findings", "Fit", "General", "Gradient", "Heat", "Image", "Optimum",
           "Parameter", "Picture", "Plan", "Run", "Sampled", "Sensor", "Stack", "Study", "StudyColumn", "ToleranceError", "UsageError",
           "__version__", "air", "characterize", "components", "custom", "devices", "fit", "heat", "kinds", "light", "measure", "metrics", "noise", "read",
           "render", "targets", "write"]


def __getattr__(name: str) -> Any:
    # A class for each kind of component, made when the first one is asked for: Jitter, Diffraction, ...
    if name.startswith("_"):
        raise AttributeError(name)
    return getattr(components, name)


def __dir__() -> list[str]:
    return sorted({*__all__, *components.classes()})
