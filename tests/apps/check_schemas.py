#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The JSON Schemas of `mtf config schema`: every sensor, study and scene file of the project validates, files that the command
refuses for a key, a type, a unit or a word do not. Usage: check_schemas.py MTF [--study] [--scene]; exit code 77: no validator."""

import json
import subprocess
import sys
import tempfile
import tomllib
from pathlib import Path

try:
    import jsonschema
except ImportError:
    print("python3-jsonschema is not installed")
    sys.exit(77)

ROOT = Path(__file__).resolve().parent.parent.parent
MTF = sys.argv[1]

# What is wrong with a file: a text and what takes its place. The first of each kind is of the starter file.
BROKEN_SENSORS = [
    ("unknown key", 'focal_length = "100 mm"', 'focal_lenght = "100 mm"'),
    ("unknown table", "[optics]", "[optic]"),
    ("no unit", 'pitch = "15 um"', "pitch = 15"),
    ("unit of another dimension", 'pitch = "15 um"', 'pitch = "15 urad"'),
    ("unknown unit", 'pitch = "15 um"', 'pitch = "15 micron"'),
    ("unknown kind", 'kind = "jitter"', 'kind = "jiter"'),
    ("unknown key of a kind", 'kind = "jitter"', 'kind = "jitter"\nrsm = "1 um"'),
    ("a kind in a list where it does not belong", 'kind = "jitter"', 'kind = "fir"\ntaps = [[1.0]]\n[[presample]]\nkind = "jitter"'),
    ("a required key is missing", "schema = 2\n", ""),
    ("another version", "schema = 2\n", "schema = 3\n"),
    ("unknown word", 'quantity = "radiance"', 'quantity = "radiation"'),
    ("a word for a number", "f_number = 2.0", 'f_number = "2.0"'),
]
BROKEN_CAMERAS = [
    ("a number out of range", "quantum_efficiency = 0.75", "quantum_efficiency = 1.5"),
    ("a whole number is none", "bits = 14", "bits = 14.5"),
    ("a number out of range, whole", "bits = 14", "bits = 99"),
    ("a key of another table", "bits = 14", 'bits = 14\nread_noise = "3 e-"'),
]
BROKEN_STUDIES = [
    ("unknown key", "[[axis]]\n", "[[axis]]\nform = 1\n"),
    ("two ways of giving an axis", "count = 37", "count = 37\nvalues = [1, 2]"),
    ("unknown word", "count = 37", 'count = 37\nscale = "logarithmic"'),
    ("no list", "[metrics]\nlist = [", "[metrics]\nlist = 3\nother = ["),
    ("unknown table", "[metrics]", "[metric]"),
    ("tolerance out of range", "schema = 1\n", "schema = 1\ntolerance = 2\n"),
    ("condition without unit", "[conditions]\n", "[conditions]\neye_time = 5\n"),
]
BROKEN_SCENES = [
    ("unknown key", 'latitude = "', 'lattitude = "'),
    ("unknown table", "[place]", "[places]"),
    ("no unit", 'altitude = "2317 m"', "altitude = 2317"),
    ("a number without its unit", 'altitude = "2317 m"', 'altitude = "2317"'),
    ("unknown word", 'stamp = "instant"', 'stamp = "now"'),
    ("a share above 1", "solar_absorptance = 0.75", "solar_absorptance = 1.75"),
    ("unknown model", 'convection = "mcadams"', 'convection = "mcadam"'),
    ("unknown key of a layer", 'thickness = "20 mm"', 'thicknes = "20 mm"'),
    ("unknown kind of inside", 'inside = { kind = "adiabatic" }', 'inside = { kind = "adiabat" }'),
    ("a key of another inside", 'inside = { kind = "adiabatic" }', 'inside = { kind = "adiabatic", h = "3 W/m2/K" }'),
    ("a point of two numbers", 'look_at = ["0 m", ', "look_at = ["),
    ("a region without a mesh", 'mesh = "terrain"\n', ""),
    ("another version", "schema = 1\n", "schema = 2\n"),
]


def run(*words):
    return subprocess.run([MTF, *words], check=True, capture_output=True, text=True).stdout


def validator(kind):
    schema = json.loads(run("config", "schema", kind))
    jsonschema.Draft7Validator.check_schema(schema)
    return jsonschema.Draft7Validator(schema)


def problems_of(judge, text):
    return [error.message[:200] for error in judge.iter_errors(tomllib.loads(text))]


def refused(text, folder, command):
    """That the command refuses the file, too: a case that it accepts would prove nothing."""
    path = folder / "broken.toml"
    path.write_text(text)
    done = subprocess.run([MTF, command, "check", str(path)], capture_output=True, text=True)
    return done.returncode == 2


def check(judge, good, broken, folder, command="config"):
    bad = []
    for path in good:
        bad += [f"{path}: {text}" for text in problems_of(judge, Path(path).read_text())]
    base = Path(good[0]).read_text()
    for what, old, new in broken:
        if old not in base:
            bad.append(f"{good[0]} no longer holds {old!r}, which the case '{what}' changes")
            continue
        text = base.replace(old, new, 1)
        if not problems_of(judge, text):
            bad.append(f"{what}: validates")
        if not refused(text, folder, command):
            bad.append(f"{what}: mtf {command} check accepts it")
    print(f"{len(good)} files, {len(broken)} broken ones")
    return bad


def an_example(row):
    """A number within the range of a row that shows none."""
    inside = [row["max"] if row["max"] is not None and not row["max_open"] else 1e3]
    return int(inside[0]) if row["type"] == "whole" else float(inside[0])


def main():
    bad = []
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        starter = folder / "starter.toml"
        run("config", "init", "-o", str(starter))
        run("demo", "-o", str(folder / "demo"))
        shipped = [*(ROOT / "notebooks-data").rglob("*.toml")]
        studies, scenes, sensors = [], [], [starter, *(folder / "demo").glob("*.toml")]
        for path in shipped:
            keys = tomllib.loads(path.read_text())
            if "place" in keys:
                scenes.append(path)
                continue
            (studies if "axis" in keys else sensors).append(path)
        judge = validator("sensor")
        bad += check(judge, sensors, BROKEN_SENSORS, folder)
        bad += check(judge, [folder / "demo" / "camera.toml"], BROKEN_CAMERAS, folder)
        # Each kind of component as its own example, and each field by the example of its row.
        kinds = json.loads(run("config", "kinds", "--format", "json"))
        head = 'schema = 1\n[frame]\nfocal_length = "1 m"\npitch = "9 um"\n'
        for kind in kinds["components"]:
            bad += [f"{kind['kind']}: {text}" for text in problems_of(judge, head + kind["example"])]
            each = f"[[{kind['lists'][0]}]]\nkind = \"{kind['kind']}\"\n"
            rows = "".join(f"{row['name']} = {row['example']}\n" for row in kind["parameters"])
            bad += [f"{kind['kind']}, every field: {text}" for text in problems_of(judge, head + each + rows)]
        for table in kinds["tables"]:
            if table["name"] == "frame":
                continue
            rows = "".join(f"{row['name']} = {row['example'] or an_example(row)}\n" for row in table["parameters"])
            text = head + f"[{table['name']}]\n" + rows
            bad += [f"[{table['name']}] {table['condition']}: {text}" for text in problems_of(judge, text)]
        if "--study" in sys.argv:
            studies.sort(key=lambda path: path.name != "aperture_against_pitch.toml")
            (folder / "satellite.toml").write_text((studies[0].parent / "satellite.toml").read_text())
            bad += check(validator("study"), studies, BROKEN_STUDIES, folder)
        if "--scene" in sys.argv:
            run("scene", "demo", "-o", str(folder / "scene"))
            bad += check(validator("scene"), [folder / "scene" / "scene.toml", *scenes], BROKEN_SCENES, folder / "scene", "scene")
    print("\n".join(bad))
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
