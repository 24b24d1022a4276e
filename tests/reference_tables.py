#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Runs the generators of notebooks-data/reference again and compares byte for byte.
With --atmosphere that of the tables of radiometry/atmosphere, which takes its input from the shared data; else the
others, which need mpmath. Exit 77, skipped, without what is needed."""

import os
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
REFERENCE = ROOT / "notebooks-data" / "reference"
SCRIPTS = {
    "annular.py": ["annular_diffraction_mtf.csv"],
    "camera_counts.py": ["camera_counts.csv"],
    "defocus.py": ["defocus_circular.csv", "defocus_annular.csv"],
    "elementary.py": ["elementary.csv", "kolmogorov.csv"],
    "fresnel.py": ["fresnel_integrals.csv", "accelerated_motion.csv"],
    "golden_components.py": ["golden_components.csv"],
    "gradients.py": ["gradients.csv"],
    "performance.py": ["performance.csv"],
    "planck.py": ["planck.csv", "planck_bands.csv"],
}


def changed(script, tables, home):
    """The tables that are not what the script writes."""
    with tempfile.TemporaryDirectory() as folder:
        path = REFERENCE / "generators" / script
        subprocess.run([sys.executable, "-B", str(path), "--folder", folder], check=True, stdout=subprocess.DEVNULL)
        return [t for t in tables if (Path(folder) / t).read_bytes() != (home / t).read_bytes()]


def report(differing):
    for table in differing:
        print(f"{table} is not what its generator writes")
    return 1 if differing else 0


def atmosphere():
    shared = Path(os.environ.get("MTFKIT_SHARED", ROOT.parent / "shared"))
    if not (shared / "data" / "atmosphere").is_dir():
        print("no shared data")
        return 77
    tables = ["coefficients.inc", "model_atmospheres.inc"]
    return report(changed("atmosphere.py", tables, ROOT / "radiometry" / "atmosphere" / "tables"))


def main():
    if "--atmosphere" in sys.argv[1:]:
        return atmosphere()
    try:
        import mpmath  # noqa: F401
    except ImportError:
        print("skipped: no mpmath (Debian: python3-mpmath)")
        return 77
    differing = []
    for script, tables in SCRIPTS.items():
        differing += changed(script, tables, REFERENCE)
    return report(differing)


if __name__ == "__main__":
    sys.exit(main())
