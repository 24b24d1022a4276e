#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Packs a folder (mtfkit/, scripts/mtf) into a wheel for this Python and this glibc (PEP 427).
Usage: package_wheel.py FOLDER VERSION OUT     with SOURCE_DATE_EPOCH in the environment; called by apps/package
"""

import base64
import hashlib
import os
import platform
import sys
import time
import zipfile
from pathlib import Path


def main():
    folder, version, out = Path(sys.argv[1]), sys.argv[2], Path(sys.argv[3])
    python = f"cp{sys.version_info.major}{sys.version_info.minor}"
    tag = f"{python}-{python}-manylinux_{platform.libc_ver()[1].replace('.', '_')}_{platform.machine()}"
    about = f"mtfkit-{version}.dist-info"
    files = {path.relative_to(folder).as_posix(): path for path in sorted(folder.rglob("*")) if path.is_file()}
    contents = {name.replace("scripts/", f"mtfkit-{version}.data/scripts/", 1) if name.startswith("scripts/") else name:
                (path.read_bytes(), 0o755 if os.access(path, os.X_OK) else 0o644) for name, path in files.items()}
    contents[f"{about}/METADATA"] = (
        f"Metadata-Version: 2.1\nName: mtfkit\nVersion: {version}\nLicense: Apache-2.0; a binary that contains FFTW is passed on under the GPL\n"
        "Summary: OTF models of electro-optical and infrared sensors\nRequires-Dist: numpy\n".encode(), 0o644)
    contents[f"{about}/WHEEL"] = (
        f"Wheel-Version: 1.0\nGenerator: apps/package\nRoot-Is-Purelib: false\nTag: {tag}\n".encode(), 0o644)
    record = ""
    for name, (data, _) in contents.items():
        digest = base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b"=").decode()
        record += f"{name},sha256={digest},{len(data)}\n"
    contents[f"{about}/RECORD"] = (f"{record}{about}/RECORD,,\n".encode(), 0o644)
    when = time.gmtime(int(os.environ["SOURCE_DATE_EPOCH"]))[:6]
    with zipfile.ZipFile(out / f"mtfkit-{version}-{tag}.whl", "w", zipfile.ZIP_DEFLATED) as wheel:
        for name, (data, mode) in contents.items():
            entry = zipfile.ZipInfo(name, when)
            entry.external_attr = (0o100000 | mode) << 16
            wheel.writestr(entry, data, zipfile.ZIP_DEFLATED, 9)


if __name__ == "__main__":
    main()
