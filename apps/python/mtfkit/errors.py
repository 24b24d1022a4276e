# SPDX-License-Identifier: Apache-2.0
"""Exceptions of mtfkit. Their messages say where, what, and what to write instead."""

from __future__ import annotations

__all__ = ["DataError", "Error", "ToleranceError", "UsageError"]


class Error(Exception):
    """Base of every exception of mtfkit."""


class UsageError(Error, ValueError):
    """A wrong argument, parameter, sensor file or study: the caller has to change the request."""


class ToleranceError(UsageError):
    """A tolerance below what can be kept for this scene and sensor.

    `reachable` is a tolerance that is accepted, relative to the standard deviation of the scene; infinite when there is
    none below 1.
    """

    reachable: float

    def __init__(self, message: str, reachable: float = float("inf")) -> None:
        super().__init__(message)
        self.reachable = reachable

    def __reduce__(self) -> tuple[type[ToleranceError], tuple[str, float]]:
        return type(self), (str(self), self.reachable)


class DataError(Error, RuntimeError):
    """The data or the machine failed: an unreadable file, NaN pixels, a full disk."""
