# SPDX-License-Identifier: Apache-2.0
"""The Python blocks of the pages beside the README run, each as a program of its own."""

import re
import subprocess
import sys

import pytest
from conftest import ROOT

PAGES = ROOT / "apps" / "python"


def blocks():
    for page in sorted(PAGES.glob("*.md")):
        if page.name == "README.md":  # which tests/readme_blocks.py runs
            continue
        for number, text in enumerate(re.findall(r"(?ms)^```python\n(.*?)^```", page.read_text(encoding="utf-8")), 1):
            yield pytest.param(text, id=f"{page.stem}-{number}")


@pytest.mark.parametrize("text", blocks())
def test_block(text, tmp_path):
    (tmp_path / "notebooks-data").symlink_to(ROOT / "notebooks-data")
    result = subprocess.run([sys.executable, "-B", "-c", text], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert result.returncode == 0, result.stderr
