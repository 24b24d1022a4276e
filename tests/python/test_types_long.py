# SPDX-License-Identifier: Apache-2.0
"""The types of the package hold, and its stubs describe what is there."""

import os
import subprocess
import sys
from pathlib import Path

import mtfkit as mk

PACKAGE = Path(mk.__file__).parent


def run_tool(tmp_path, *words):
    result = subprocess.run([sys.executable, "-m", *words], capture_output=True, text=True, cwd=PACKAGE.parent, check=False,
                            env={**os.environ, "MYPY_CACHE_DIR": str(tmp_path)})
    assert result.returncode == 0, result.stdout + result.stderr


def test_types_hold(tmp_path):
    run_tool(tmp_path, "mypy", "--strict", "-p", "mtfkit")


def test_stubs_describe_what_is_there(tmp_path):
    run_tool(tmp_path, "mypy.stubtest", "mtfkit", "--allowlist", str(Path(__file__).with_name("stubtest_allowlist.txt")),
             "--ignore-unused-allowlist")
