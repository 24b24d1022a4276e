#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Runs the generators of notebooks-data/reference again and compares byte for byte. Exit 77, skipped, without mpmath."""

import subprocess
import sys
import tempfile
from pathlib import Path

REFERENCE = Path(__file__).resolve().parent.parent / "notebooks-data" / "reference"
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


def main():
    try:
        import mpmath  # noqa: F401
    except ImportError:
        print("skipped: no mpmath (Debian: python3-mpmath)")
        return 77
    differing = []
    for script, tables in SCRIPTS.items():
        with tempfile.TemporaryDirectory() as folder:
            path = REFERENCE / "generators" / script
            subprocess.run([sys.executable, "-B", str(path), "--folder", folder], check=True)
            differing += [t for t in tables if (Path(folder) / t).read_bytes() != (REFERENCE / t).read_bytes()]
    for table in differing:
        print(f"{table} is not what its generator writes")
    return 1 if differing else 0


if __name__ == "__main__":
    sys.exit(main())
