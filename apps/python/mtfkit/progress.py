# SPDX-License-Identifier: Apache-2.0
"""Progress of long work: a function of the share done, or a line on standard error."""

from __future__ import annotations

import sys
from collections.abc import Callable
from typing import Union

from mtfkit.errors import UsageError

#: True for a line on standard error, a function of the share done (0 to 1), or nothing.
Progress = Union[bool, Callable[[float], None], None]


def function_of(progress: Progress, what: str) -> Callable[[float], None] | None:
    """The function that the work calls, or None."""
    if progress is None or progress is False:
        return None
    if progress is not True:
        if not callable(progress) or isinstance(progress, type):
            raise UsageError(f"progress: {progress!r} is neither True nor a function of the share done")
        return progress

    def line(share: float) -> None:
        end = "\n" if share >= 1.0 else ""
        print(f"\r{what} {100.0 * share:3.0f} %", end=end, file=sys.stderr, flush=True)

    return line
