#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Writes what packages hold beside the toolkit: copyright, changelog, a list of all parts (SPDX).
Usage: package_papers.py ROOT BUILD VERSION [PACKAGE...]     with SOURCE_DATE_EPOCH in the environment; called by
apps/package with the Debian packages of the libraries that the command needs
"""

import base64
import datetime
import email.utils
import gzip
import json
import os
import re
import subprocess
import sys
from pathlib import Path

PACKAGES = ("mtfkit", "mtfkit-codecs", "mtfkit-gdal", "mtfkit-libraw", "libmtfkit-dev", "python3-mtfkit")

COPYRIGHT = """Format: https://www.debian.org/doc/packaging-manuals/copyright-format/1.0/
Upstream-Name: mtfkit

Files: *
Copyright: {year} the mtfkit authors
License: Apache-2.0
Comment:
 The programs and libraries of these packages that compute transforms link
 FFTW, which is free software under the GNU General Public License, version 2
 or any later version. As a whole such a program may be passed on under the
 GNU General Public License, version 3 or any later version, which the licence
 of mtfkit allows. The text of that licence is in
 /usr/share/common-licenses/GPL-3.
 .
 Letters in pictures are those of the Hershey Fonts, which were originally
 created by Dr. A. V. Hershey while working at the U. S. National Bureau of
 Standards; the format of the font data was originally created by James Hurt,
 Cognition, Inc., 900 Technology Park Drive, Billerica, MA 01821.
{pages}
License: Apache-2.0
 The text of the Apache License, version 2.0, is in
 /usr/share/common-licenses/Apache-2.0.
"""

# Of python3-mtfkit: byte code is made, and goes with the package.
SCRIPTS = {"postinst": '[ "$1" != configure ] || py3compile -p python3-mtfkit', "prerm": "py3clean -p python3-mtfkit"}


def run(*command):
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout.strip()


def as_paragraph(text):
    """Lines as a field of Debian's control files has them."""
    return "".join(f" {line.strip()}\n" if line.strip() else " .\n" for line in text.strip().splitlines())


def write_documents(build, version, maintainer, when):
    npm = build / "apps/report/page/npm"
    pages = " .\n Pages that the command writes hold these packages of npm:\n"
    for notices in (npm / "notices.txt", npm / "node_modules/uplot/LICENSE"):
        if notices.exists():
            pages += " .\n" + as_paragraph(notices.read_text(encoding="utf-8"))
    copyright_text = COPYRIGHT.format(year=when.year, pages=pages)
    for package in PACKAGES:
        folder = build / "papers" / package / "doc" / package
        folder.mkdir(parents=True, exist_ok=True)
        (folder / "copyright").write_text(copyright_text, encoding="utf-8")
        changes = (f"mtfkit ({version}) unstable; urgency=medium\n\n  * Built from the sources of {version}.\n\n"
                   f" -- {maintainer}  {email.utils.format_datetime(when)}\n")
        (folder / "changelog.gz").write_bytes(gzip.compress(changes.encode(), 9, mtime=0))
    for name, command in SCRIPTS.items():
        (build / "papers" / name).write_text(f"#!/bin/sh\nset -e\n{command}\n", encoding="utf-8")


def debian_parts(root, libraries):
    """Packages that are built with, those of the toolkit's list that are used when it runs, and the libraries."""
    wanted, section = dict.fromkeys(libraries, "run"), ""
    for line in (root / "apps/packages.txt").read_text(encoding="utf-8").splitlines():
        words = line.split("#")[0].split()
        if line.startswith("["):
            section = line.strip("[]")
        elif words and section in ("build", "all", "run"):
            wanted.setdefault(words[0], "run" if section == "run" else "build")
    for name, how in wanted.items():
        status = subprocess.run(["dpkg-query", "-W", "-f", "${Version} ${Architecture}", name], capture_output=True,
                                text=True, check=False).stdout.split()
        if len(status) == 2:
            yield {"name": name, "versionInfo": status[0], "licenseDeclared": "NOASSERTION",
                   "purl": f"pkg:deb/debian/{name}@{status[0]}?arch={status[1]}", "how": how}


def npm_parts(root):
    lock = json.loads((root / "apps/report/page/package-lock.json").read_text(encoding="utf-8"))
    for path, part in sorted(lock["packages"].items()):
        if path:
            name = path.split("node_modules/")[-1]
            yield {"name": name, "versionInfo": part["version"], "licenseDeclared": part.get("license", "NOASSERTION"),
                   "purl": f"pkg:npm/{name.replace('@', '%40')}@{part['version']}", "how": "dev" if part.get("dev") else "run",
                   "sha512": base64.b64decode(part["integrity"].removeprefix("sha512-")).hex()}


def spdx(root, version, when, commit, libraries=()):
    def package(name, identifier, more):
        return {"name": name, "SPDXID": identifier, "downloadLocation": "NOASSERTION", "filesAnalyzed": False, **more}

    packages = [package("mtfkit", "SPDXRef-mtfkit", {"versionInfo": version, "licenseDeclared": "Apache-2.0"})]
    relations = [("SPDXRef-DOCUMENT", "DESCRIBES", "SPDXRef-mtfkit")]
    for part in [*debian_parts(root, libraries), *npm_parts(root)]:
        identifier = "SPDXRef-" + re.sub(r"[^A-Za-z0-9.-]+", "-", part["purl"].removeprefix("pkg:").split("?")[0])
        more = {key: part[key] for key in ("versionInfo", "licenseDeclared")}
        more["externalRefs"] = [{"referenceCategory": "PACKAGE-MANAGER", "referenceType": "purl", "referenceLocator": part["purl"]}]
        if "sha512" in part:
            more["checksums"] = [{"algorithm": "SHA512", "checksumValue": part["sha512"]}]
        packages.append(package(part["name"], identifier, more))
        relations.append(("SPDXRef-mtfkit", "DEPENDS_ON", identifier) if part["how"] == "run" else
                         (identifier, "BUILD_DEPENDENCY_OF", "SPDXRef-mtfkit"))
    return {"spdxVersion": "SPDX-2.3", "dataLicense": "CC0-1.0", "SPDXID": "SPDXRef-DOCUMENT", "name": f"mtfkit-{version}",
            "documentNamespace": f"https://spdx.org/spdxdocs/mtfkit-{version}-{commit}",
            "creationInfo": {"created": when.strftime("%Y-%m-%dT%H:%M:%SZ"), "creators": ["Tool: apps/package"]},
            "packages": packages,
            "relationships": [{"spdxElementId": a, "relationshipType": how, "relatedSpdxElement": b} for a, how, b in relations]}


def main():
    root, build, version = Path(sys.argv[1]), Path(sys.argv[2]), sys.argv[3]
    when = datetime.datetime.fromtimestamp(int(os.environ["SOURCE_DATE_EPOCH"]), datetime.timezone.utc)
    maintainer = run("git", "-C", str(root), "log", "-1", "--format=%an <%ae>")
    write_documents(build, version, maintainer, when)
    text = json.dumps(spdx(root, version, when, run("git", "-C", str(root), "rev-parse", "HEAD"), sys.argv[4:]), indent=1) + "\n"
    (build / "packages" / f"mtfkit-{version}.spdx.json").write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
