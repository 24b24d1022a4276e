# SPDX-License-Identifier: Apache-2.0
"""What `mtf config check` finds in a sensor file."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Finding:
    """What `mtf config check` says: severity "error", "warning" or "note", where, and about what."""

    severity: str
    line: int
    column: int
    path: str
    text: str

    def __str__(self) -> str:
        place = f"{self.line}:{self.column}: " if self.line else ""  # what is absent has none
        return f"{place}{self.severity}: {self.path}: {self.text}"


class Findings(tuple[Finding, ...]):
    """All findings; true when none of them is an error, so that `assert sensor.check()` reads well."""

    __slots__ = ()

    def __bool__(self) -> bool:
        return not any(finding.severity == "error" for finding in self)

    def __str__(self) -> str:
        return "\n".join(str(finding) for finding in self) or "nothing to remark"
