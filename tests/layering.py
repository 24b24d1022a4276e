#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Checks who includes what, the SPDX line and the length of every source, that no two types share a qualified name,
that folders stay small and are described, and that no member of a component is one that nothing calls.
Usage: layering.py [ROOT]

Dependencies point one way, between libraries (DIRECTIONS) and between the folders of one (FLOORS), and each outside
library is seen by the few files that wrap it (RULES). A folder holds at most 30 files (flat lists of components and of tests are exempt), no
two headers have the same name, and every folder has a README or a row in its parent's.
"""

import re
import sys
from collections import Counter
from pathlib import Path

import type_names

FOLDERS = ("mtf", "radiometry", "calib", "apps", "tests")
MAX_LINES = 600
LIBRARIES = ("mtf", "radiometry", "calib", "apps")
MAX_FILES = 30
FLAT_LISTS = {"mtf/components"}
INCLUDE = re.compile(r"^\s*#\s*include\s*[<\"]([^>\"]+)[>\"]", re.MULTILINE)
SCRIPT_NAMES = re.compile(r"(CMakeLists\.txt|packages\.txt|\.cmake(\.in)?|\.py|\.sh|/setup|/quickstart|apps/package|tests/run|"
                          r"site/(build|Doxyfile|site\.css)|help/(mtf\.(ba|fi)sh|_mtf))$")

# What is included, the files that may, the reason a reader needs.
RULES = [
    (r"fftw3\.h$", r"mtf/engines/fft/fftw\.cpp|tests/bench/", "FFTW is private to the FFT engine"),
    (r"(OpenEXR|Imath)/|Imf\w*\.h$|openexr\w*\.h$", r"mtf/io/|tests/mtf/io/", "OpenEXR is private to mtf/io"),
    (r"opencv2?/", r"mtf/io/codecs/opencv_filters\.cpp|tests/bench/", "OpenCV is private to its module"),
    (r"^(gdal|cpl_\w+)\.h$", r"mtf/io/raw/gdal_module\.cpp$", "GDAL is private to its module"),
    (r"^libraw/", r"mtf/io/raw/libraw_module\.cpp$", "LibRaw is private to its module"),
    (r"(png|tiff|tiffio|turbojpeg|charls)\.h$", r"mtf/io/codecs/codecs_|tests/mtf/io/", "image codecs are private to the codec module"),
    (r"vkFFT\.h$", r"mtf/device/vkfft\.h$", "VkFFT is private to the modules of devices"),
    (r"CL/|cuda\w*\.h$|nvrtc\.h$", r"mtf/device/(opencl|cuda)_module\.cpp$", "OpenCL and CUDA are private to their modules"),
    (r"toml\+\+|toml\.hpp$", r"mtf/io/", "toml++ is private to mtf/io"),
    (r"ceres/", r"calib/|tests/|apps/study/", "Ceres is private to calib and apps/study"),
    (r"nlohmann/", r"apps/text/json\.cpp|apps/scene/import/helper/|tests/", "nlohmann/json is private to apps/text/json.cpp"),
    (r"CLI/", r"apps/main\.cpp$", "CLI11 is private to apps/main.cpp"),
    (r"pybind11/", r"apps/python/", "pybind11 is private to apps/python"),
    (r"httplib\.h$", r"apps/live/server\.cpp$", "cpp-httplib is private to apps/live/server.cpp"),
    (r"embree3/", r"radiometry/scene/|tests/radiometry/scene/", "Embree is private to radiometry/scene"),
    (r"erfa\.h$", r"radiometry/weather/", "ERFA is private to radiometry/weather"),
    (r"draco/", r"apps/scene/import/", "Draco is private to the import process of apps/scene"),
    (r"(sundials|cvode|nvector|sunmatrix|sunlinsol)/", r"tests/", "SUNDIALS is the oracle of tests"),
    (r"(mtf/mtf|radiometry/radiometry|calib/calib|apps/apps|scene/scenes)\.h$", r"tests/consumer/", "umbrella headers are for users"),
    (r"mtf/components/all\.h$", r"mtf/components/component_impl\.h$|mtf/mtf\.h$|tests/", "all.h is for mtf/components/component_impl.h, mtf/mtf.h and tests"),
]

# Files, what they must not include.
DIRECTIONS = [
    (r"mtf/(?!io/)", r"(radiometry|calib|apps|tests)/"),
    (r"mtf/io/", r"(calib|apps|tests)/"),
    (r"radiometry/", r"(mtf/io|calib|apps|tests)/"),
    (r"calib/", r"(apps|tests)/"),
    (r"apps/", r"tests/"),
]

# The rooms of each library (its folders, with all below them), from the ground up: what is in a room includes its own room
# and those before it. "" is the library's own folder; its sources, unlike its headers, include what they like.
FLOORS = {
    "mtf": ["", "math", "work", "engines", "device", "components", "otf", "metrics", "field", "plan", "survey", "tiles", "io"],
    "radiometry": ["", "light", "stages", "atmosphere", "performance", "chain", "scene", "weather", "heat", "thermal", "render"],
    "calib": ["", "edge", "find", "measure", "iso12233", "fit", "series", "characterize"],
    "apps": ["text", "sensor", "simulate", "", "check", "study", "terminal", "import", "help", "figures", "page", "edges", "characterize", "bench", "range", "sweep",
             "scene", "schema", "modules", "demo", "report", "live", "image", "atmosphere", "python"],
}

# What each library shows its users is what its umbrella header names; all else is internal.
UMBRELLAS = ("mtf/mtf.h", "mtf/components/all.h", "radiometry/radiometry.h", "calib/calib.h", "apps/apps.h", "apps/scene/scenes.h")
MOST_PUBLIC = 130


def room(path):
    """("mtf", "engines") of mtf/engines/fft/axis.h, ("mtf", "") of mtf/image.h."""
    parts = path.split("/")
    return parts[0], parts[1] if len(parts) > 2 else ""


def climbs(path, header):
    """What an include that climbs is told, or None."""
    library, mine = room(path)
    other, its = room(header)
    if library != other or library not in FLOORS or its == mine or (mine == "" and path.endswith(".cpp")) or path in UMBRELLAS:
        return None
    floors = FLOORS[library]
    for folder in (mine, its):
        if folder not in floors:
            return f"{library}/{folder} has no place in FLOORS of tests/layering.py"
    if floors.index(its) < floors.index(mine):
        return None
    return f"{library}/{its} stands above {library}/{mine} (FLOORS of tests/layering.py)"


def problems_of_source(path, text):
    if not text.startswith("// SPDX-License-Identifier: Apache-2.0\n"):
        yield f"{path}:1: the first line must be `// SPDX-License-Identifier: Apache-2.0`"
    lines = text.count("\n")
    if lines > MAX_LINES:
        yield f"{path}: {lines} lines, at most {MAX_LINES}: split it by job"
    for match in INCLUDE.finditer(text):
        header = match.group(1)
        where = f"{path}:{text.count(chr(10), 0, match.start(1)) + 1}"
        for what, allowed, reason in RULES:
            if re.search(f"(^|/)({what})", header) and not re.match(allowed, path):
                yield f"{where}: includes {header}: {reason}"
        if climb := climbs(path, header):
            yield f"{where}: includes {header}: {climb}"
        for files, forbidden in DIRECTIONS:
            if re.match(files, path) and re.match(forbidden, header):
                yield f"{where}: includes {header}: dependencies point apps -> calib, radiometry, io -> mtf"


def problems_of_script(path, text):
    if not any("SPDX-License-Identifier: Apache-2.0" in line for line in text.splitlines()[:2]):
        yield f"{path}:1: no SPDX-License-Identifier in the first two lines"


def described(root, folder):
    """Whether the folder has a README or its name, as `name/`, stands in the README of a folder above it."""
    if (root / folder / "README.md").exists():
        return True
    for parent in folder.parents[:-1]:
        readme = root / parent / "README.md"
        if readme.exists() and f"`{folder.relative_to(parent).as_posix()}/`" in readme.read_text(encoding="utf-8"):
            return True
    return False


def problems_of_folders(root, paths):
    """`paths`: of all sources, relative to `root`."""
    folders = Counter(path.parent for path in paths if path.parts[0] in LIBRARIES)
    for folder, _ in sorted(folders.items()):
        files = sum(1 for file in (root / folder).iterdir() if file.is_file())
        if files > MAX_FILES and folder.as_posix() not in FLAT_LISTS:
            yield f"{folder}: {files} files, at most {MAX_FILES}: divide it by what the files are for"
        if not described(root, folder):
            yield f"{folder}: no README, and no row of it in the README of a folder above"
    headers = {}
    for path in paths:
        if path.suffix == ".h" and path.parts[0] in LIBRARIES:
            headers.setdefault(path.name, []).append(path.as_posix())
    for same in headers.values():
        if len(same) > 1:
            yield f"{same[0]}: a header of this name is also {', '.join(same[1:])}"


CPP_BLOCK = re.compile(r"^```cpp.*?^```", re.MULTILINE | re.DOTALL)


def problems_of_public_headers(root, sources):
    """What users are shown, in the examples of READMEs and in tests/consumer, is public; so is little else."""
    texts = dict(sources)
    public = {header for umbrella in UMBRELLAS for header in INCLUDE.findall(texts.get(umbrella, ""))} - set(UMBRELLAS)
    if len(public) > MOST_PUBLIC:
        yield f"{', '.join(UMBRELLAS)} name {len(public)} public headers, at most {MOST_PUBLIC}"
    shown = [(path, text) for path, text in sources if path.startswith("tests/consumer/")]
    readmes = [root / "README.md", *(file for folder in FOLDERS for file in sorted((root / folder).rglob("README.md")))]
    for readme in readmes:
        text = readme.read_text(encoding="utf-8") if readme.exists() and "node_modules" not in readme.parts else ""
        shown += [(readme.relative_to(root).as_posix(), block) for block in CPP_BLOCK.findall(text)]
    for path, text in shown:
        for header in INCLUDE.findall(text):
            if header in texts and header not in public and header not in UMBRELLAS:
                yield f"{path}: shows users {header}, which is internal: name it in the umbrella header of its library"


COMPONENT_MEMBER = re.compile(r"^  (?!//)[^\n/=]*?\b(\w+)\([^;{}]*?\bContext<\w+>&[^;{}]*?\) const", re.MULTILINE)


def problems_of_components(sources):
    """What a component may leave out (check, cutoff_cy_mm, kinks_cy_mm, evaluator) is asked for by name: under a
    misspelt one it would be left out in silence."""
    words = Counter(word for path, text in sources if not path.startswith("tests/") for word in re.findall(r"\w+", text))
    for path, text in sources:
        if not re.fullmatch(r"mtf/components/\w+\.h", path):
            continue
        for name in COMPONENT_MEMBER.findall(text):
            if words[name] == 1:
                yield f"{path}: nothing calls {name}, which takes a context: is it the name that a component is asked by?"


def check(root):
    found, sources = [], []
    for folder in FOLDERS:
        for file in sorted((root / folder).rglob("*")):
            path = file.relative_to(root).as_posix()
            if not file.is_file() or "node_modules/" in path:
                continue
            if file.suffix in (".h", ".cpp"):
                text = file.read_text(encoding="utf-8")
                sources.append((path, text))
                found += problems_of_source(path, text)
            elif SCRIPT_NAMES.search(path):
                found += problems_of_script(path, file.read_text(encoding="utf-8"))
    found += type_names.problems(sources)
    found += problems_of_components(sources)
    found += problems_of_public_headers(root, sources)
    found += problems_of_folders(root, [Path(path) for path, _ in sources])
    if not sources:
        found.append(f"{root}: no sources found, nothing was checked")
    return found


def main():
    root = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).resolve().parent.parent
    found = check(root)
    print("\n".join(found) if found else "layering: ok")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
