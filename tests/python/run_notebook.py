# SPDX-License-Identifier: Apache-2.0
"""Runs a notebook that is kept as a .py file in percent format, in a fresh kernel; an exception in a cell fails.

Usage: run_notebook.py NOTEBOOK.py [OUT.ipynb]     the working folder is what the notebook sees
"""

import re
import sys
from pathlib import Path

import nbformat
from nbclient import NotebookClient


def notebook_of(text):
    """The cells of the text: `# %% [markdown]` starts one of prose, `# %%` one of code."""
    cells = []
    for kind, body in re.findall(r"(?ms)^# %%( \[markdown\])?[^\n]*\n(.*?)(?=^# %%|\Z)", text):
        if kind:
            cells.append(nbformat.v4.new_markdown_cell(re.sub(r"(?m)^# ?", "", body).strip()))
        else:
            cells.append(nbformat.v4.new_code_cell(body.strip()))
    return nbformat.v4.new_notebook(cells=cells)


if __name__ == "__main__":
    notebook = notebook_of(Path(sys.argv[1]).read_text(encoding="utf-8"))
    NotebookClient(notebook, timeout=600, kernel_name="python3").execute()
    if len(sys.argv) > 2:
        nbformat.write(notebook, sys.argv[2])
