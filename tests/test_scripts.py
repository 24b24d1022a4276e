#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Tests of the checking scripts: each must refuse what it is there to refuse."""

import json
import tempfile
import unittest
from pathlib import Path

import layering
import readme_blocks

SPDX = "// SPDX-License-Identifier: Apache-2.0\n"


def found_in(path, text):
    return list(layering.problems_of_source(path, text))


class Layering(unittest.TestCase):
    def test_each_outside_library_has_its_place(self):
        cases = [
            ("<fftw3.h>", "mtf/engines/fftw.cpp", "mtf/plan.cpp"),
            ("<OpenEXR/ImfInputFile.h>", "mtf/io/exr_read.cpp", "apps/simulate.cpp"),
            ("<ImfHeader.h>", "mtf/io/exr_read.cpp", "mtf/image.h"),
            ("<opencv2/core.hpp>", "mtf/io/codecs_png.cpp", "mtf/io/image_io.cpp"),
            ("<opencv2/core.hpp>", "calib/edge_roi.cpp", "apps/main.cpp"),
            ("<toml++/toml.h>", "mtf/io/config.cpp", "calib/fit.cpp"),
            ("<ceres/jet.h>", "calib/system_jet.cpp", "mtf/system.h"),
            ("<CLI/CLI.hpp>", "apps/main.cpp", "apps/simulate.cpp"),
            ('"mtf/components/all.h"', "mtf/system_double.cpp", "mtf/plan.cpp"),
        ]
        for header, allowed, refused in cases:
            text = f"{SPDX}#include {header}\n"
            self.assertEqual(found_in(allowed, text), [], (header, allowed))
            self.assertEqual(len(found_in(refused, text)), 1, (header, refused))

    def test_dependencies_point_one_way(self):
        for path, header in [("mtf/plan.h", "mtf/io/image_io.h"), ("mtf/io/a.h", "calib/fit.h"),
                             ("calib/fit.cpp", "apps/run.h"), ("radiometry/adc.h", "calib/fit.h")]:
            self.assertEqual(len(found_in(path, f'{SPDX}#include "{header}"\n')), 1, path)
        self.assertEqual(found_in("calib/fit.cpp", f'{SPDX}#include "mtf/io/config.h"\n'), [])

    def test_length_and_licence_line(self):
        self.assertEqual(found_in("mtf/a.h", SPDX + "\n" * (layering.MAX_LINES - 1)), [])
        self.assertEqual(len(found_in("mtf/a.h", SPDX + "\n" * layering.MAX_LINES)), 1)
        self.assertEqual(len(found_in("mtf/a.h", "#pragma once\n")), 1)

    def test_an_empty_tree_is_not_a_pass(self):
        with tempfile.TemporaryDirectory() as folder:
            self.assertEqual(len(layering.check(Path(folder))), 1)


class ReadmeBlocks(unittest.TestCase):
    def run_text(self, text, with_long=False):
        with tempfile.TemporaryDirectory() as folder:
            blocks = readme_blocks.parse(text, "README.md")
            return readme_blocks.run_blocks(blocks, "README.md", Path(folder), "/bin/false", folder, with_long)

    def test_refuses_blocks_it_cannot_hold_to_account(self):
        for text in ("```\nls\n```\n", "```sh no-run\nls\n```\n", "```bash\nls\n```\n", "```sh\nls\n"):
            with self.assertRaises(readme_blocks.BadBlock):
                readme_blocks.parse(text, "README.md")

    def test_later_blocks_see_earlier_output(self):
        self.assertEqual(self.run_text("```sh\necho 1 > a\n```\ntext\n- item\n  ```sh\n  grep -q 1 a\n  ```\n"), 0)

    def test_any_failing_command_fails_the_block(self):
        self.assertEqual(self.run_text("```sh\nfalse\ntrue\n```\n"), 1)
        self.assertEqual(self.run_text('```sh\necho "$no_such_variable"\n```\n'), 1)

    def test_long_blocks_wait_for_long_runs(self):
        self.assertEqual(self.run_text("```sh long\nfalse\n```\n"), 0)
        self.assertEqual(self.run_text("```sh long\nfalse\n```\n", with_long=True), 1)

    def test_whole_configs_are_checked_and_fragments_shown(self):
        self.assertEqual(self.run_text("```toml\n# a sensor\nschema = 1\n```\n"), 1)
        self.assertEqual(self.run_text("```toml\n[frame]\n```\n"), 0)


class ReportPackages(unittest.TestCase):
    def test_the_lock_file_names_no_address_and_pins_every_package(self):
        lock = json.loads((readme_blocks.ROOT / "apps/report/package-lock.json").read_text(encoding="utf-8"))
        packages = {name: package for name, package in lock["packages"].items() if name}
        self.assertGreater(len(packages), 10)
        for name, package in packages.items():
            self.assertNotIn("resolved", package, name)
            self.assertTrue(package["integrity"].startswith("sha512-"), name)
        wanted = json.loads((readme_blocks.ROOT / "apps/report/package.json").read_text(encoding="utf-8"))
        for name, version in (wanted["dependencies"] | wanted["devDependencies"]).items():
            self.assertEqual(packages[f"node_modules/{name}"]["version"], version)


if __name__ == "__main__":
    unittest.main()
