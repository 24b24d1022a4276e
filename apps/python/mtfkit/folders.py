# SPDX-License-Identifier: Apache-2.0
"""Folders for as long as an object needs them."""

from __future__ import annotations

import weakref


class KeptFolder:
    """A new folder, which goes with the object, at the latest with the process."""

    def __init__(self, prefix: str) -> None:
        import shutil
        import tempfile

        self.name = tempfile.mkdtemp(prefix=prefix)
        weakref.finalize(self, shutil.rmtree, self.name, ignore_errors=True)
