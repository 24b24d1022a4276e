#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Tests of the checking scripts: each must refuse what it is there to refuse."""

import datetime
import json
import sys
import tempfile
import unittest
from pathlib import Path

import layering
import readme_blocks
import type_names

sys.path.append(str(Path(__file__).resolve().parent.parent / "mtf" / "cmake"))
import package_papers  # noqa: E402

SPDX = "// SPDX-License-Identifier: Apache-2.0\n"


def found_in(path, text):
    return list(layering.problems_of_source(path, text))


class Layering(unittest.TestCase):
    def test_each_outside_library_has_its_place(self):
        cases = [
            ("<fftw3.h>", "mtf/engines/fft/fftw.cpp", "mtf/plan/plan.cpp"),
            ("<OpenEXR/ImfInputFile.h>", "mtf/io/exr/exr_read.cpp", "apps/simulate/simulate.cpp"),
            ("<ImfHeader.h>", "mtf/io/exr/exr_read.cpp", "mtf/image.h"),
            ("<opencv2/core.hpp>", "mtf/io/codecs/opencv_filters.cpp", "mtf/io/image_io.cpp"),
            ("<png.h>", "mtf/io/codecs/codecs_png.cpp", "apps/main.cpp"),
            ("<toml++/toml.h>", "mtf/io/config/config.cpp", "calib/fit/fit.cpp"),
            ("<ceres/jet.h>", "calib/fit/system_jet.cpp", "mtf/system.h"),
            ("<CLI/CLI.hpp>", "apps/main.cpp", "apps/simulate/simulate.cpp"),
            ('"mtf/components/all.h"', "mtf/components/component_impl.h", "mtf/plan/plan.cpp"),
        ]
        for header, allowed, refused in cases:
            text = f"{SPDX}#include {header}\n"
            self.assertEqual(found_in(allowed, text), [], (header, allowed))
            self.assertEqual(len(found_in(refused, text)), 1, (header, refused))

    def test_dependencies_point_one_way(self):
        for path, header in [("mtf/plan/plan.h", "mtf/io/image_io.h"), ("mtf/io/a.h", "calib/fit/fit.h"),
                             ("calib/fit/fit.cpp", "apps/run.h"), ("radiometry/stages/detector/adc.h", "calib/fit/fit.h")]:
            self.assertEqual(len(found_in(path, f'{SPDX}#include "{header}"\n')), 1, path)
        self.assertEqual(found_in("calib/fit/fit.cpp", f'{SPDX}#include "mtf/io/config/config.h"\n'), [])

    def test_folders_of_a_library_include_only_those_below(self):
        for path, header in [("mtf/engines/fft/a.h", "mtf/plan/plan.h"), ("mtf/image.h", "mtf/math/special.h"),
                             ("calib/edge/a.cpp", "calib/measure/a.h"), ("mtf/nowhere/a.h", "mtf/image.h")]:
            self.assertEqual(len(found_in(path, f'{SPDX}#include "{header}"\n')), 1, path)
        for path, header in [("mtf/plan/plan.h", "mtf/engines/fft/a.h"), ("mtf/system.cpp", "mtf/otf/a.h"),
                             ("mtf/engines/a.cpp", "mtf/engines/fft/a.h")]:
            self.assertEqual(found_in(path, f'{SPDX}#include "{header}"\n'), [], path)

    def test_length_and_licence_line(self):
        self.assertEqual(found_in("mtf/a.h", SPDX + "\n" * (layering.MAX_LINES - 1)), [])
        self.assertEqual(len(found_in("mtf/a.h", SPDX + "\n" * layering.MAX_LINES)), 1)
        self.assertEqual(len(found_in("mtf/a.h", "#pragma once\n")), 1)

    def test_folders_are_described_and_small_and_headers_have_names_of_their_own(self):
        with tempfile.TemporaryDirectory() as name:
            root = Path(name)
            (root / "mtf/plan").mkdir(parents=True)
            (root / "mtf/README.md").write_text("| `plan/` | plans |\n", encoding="utf-8")
            (root / "mtf/plan/plan.h").write_text(SPDX, encoding="utf-8")
            self.assertEqual(layering.check(root), [])
            (root / "mtf/tiles").mkdir()
            (root / "mtf/tiles/plan.h").write_text(SPDX, encoding="utf-8")
            found = layering.check(root)
            self.assertEqual(len(found), 2, found)
            self.assertTrue(any("mtf/tiles: no README" in line for line in found), found)
            self.assertTrue(any("a header of this name" in line for line in found), found)
            for number in range(layering.MAX_FILES):
                (root / f"mtf/plan/part{number}.h").write_text(SPDX, encoding="utf-8")
            self.assertEqual(len(layering.check(root)), 3)

    def test_a_member_of_a_component_that_nothing_calls_is_misspelt(self):
        body = f"{SPDX}  std::vector<Problem> %s(const Context<S>& ctx) const {{\n"
        caller = ("mtf/components/field_access.h", SPDX + "return component.check(ctx);\n")
        for name, count in [("check", 0), ("chekc", 1)]:
            sources = [("mtf/components/jitter.h", body % name), caller]
            self.assertEqual(len(list(layering.problems_of_components(sources))), count, name)

    def test_what_users_are_shown_is_public(self):
        with tempfile.TemporaryDirectory() as name:
            root = Path(name)
            (root / "mtf").mkdir()
            (root / "mtf/README.md").write_text('# mtf\n```cpp\n#include "mtf/a.h"\n```\n', encoding="utf-8")
            (root / "mtf/a.h").write_text(SPDX, encoding="utf-8")
            (root / "mtf/mtf.h").write_text(SPDX, encoding="utf-8")
            self.assertEqual(len(layering.check(root)), 1)
            (root / "mtf/mtf.h").write_text(SPDX + '#include "mtf/a.h"\n', encoding="utf-8")
            self.assertEqual(layering.check(root), [])
            many = "".join(f'#include "mtf/b{number}.h"\n' for number in range(layering.MOST_PUBLIC))
            (root / "mtf/mtf.h").write_text(SPDX + '#include "mtf/a.h"\n' + many, encoding="utf-8")
            self.assertEqual(len(layering.check(root)), 1)

    def test_an_empty_tree_is_not_a_pass(self):
        with tempfile.TemporaryDirectory() as folder:
            self.assertEqual(len(layering.check(Path(folder))), 1)


class TypeNames(unittest.TestCase):
    def names(self, text):
        return [name for name, _ in type_names.types_of(text)]

    def test_two_types_of_one_name_are_refused_whatever_they_are(self):
        one = "namespace study {\nstruct Limit {\n  bool less = true;\n};\n}\n"
        for other in ("namespace study { class Limit final : public Base<int> { }; }",
                      "namespace study {\ntemplate <class S, class = X<Y<S>>>\nstruct Limit { S s; };\n}",
                      "namespace study { enum class Limit : int { a, b }; }",
                      "namespace study { union [[nodiscard]] Limit { int a; }; }",
                      "namespace study { using Limit = int; }",
                      "namespace study { void f() { if (a < b) { g(); } }\nstruct Limit { }; }",
                      "namespace study { inline namespace { } const auto brace = '{', quote = '\\''; struct Limit { }; }",
                      'namespace study { const char* text = R"x(}" { )x"; int million = 1\'000\'000; struct Limit { }; }',
                      "namespace study::inner { }\nstruct study::Limit { };"):
            found = list(type_names.problems([("a.h", one), ("b.cpp", other)]))
            self.assertEqual(len(found), 1, other)
            self.assertTrue(found[0].startswith("study::Limit: defined in a.h and in b.cpp"), found)
            with tempfile.TemporaryDirectory() as folder:
                (Path(folder) / "mtf").mkdir()
                (Path(folder) / "mtf/README.md").write_text("# mtf\n", encoding="utf-8")
                (Path(folder) / "mtf/a.h").write_text(SPDX + one, encoding="utf-8")
                (Path(folder) / "mtf/b.cpp").write_text(SPDX + other, encoding="utf-8")
                self.assertEqual(len(layering.check(Path(folder))), 1, other)

    def test_what_is_no_second_type_is_left_alone(self):
        one = "namespace study { struct Limit { struct Part { }; }; using Rows = std::vector<double>; }"
        for other in ("namespace study { struct Limit; enum Limit : int; template <class Limit> void f(); }",
                      "namespace study { namespace { struct Limit { }; using Rows = int; } }",
                      "namespace study { namespace inner { struct Limit { }; } }",
                      "namespace study { void f() { struct Limit { } limit; using Rows = int; } }",
                      "namespace study { struct Other { struct Limit { }; using Rows = int; }; }",
                      "namespace study { using Rows = std::vector<double>; using Base::Limit; }",
                      "namespace study { template <> struct Limit<int> { }; struct Limit limit{}; }",
                      "// namespace study { struct Limit { }; }\n/* struct study::Limit { }; */",
                      "#define LIMIT struct study::Limit { \\\n  int x; }\n",
                      'const char* text = "namespace study { struct Limit { }; }";'):
            self.assertEqual(list(type_names.problems([("a.h", one), ("b.cpp", other)])), [], other)

    def test_names_carry_their_namespaces_and_classes(self):
        self.assertEqual(self.names("namespace a::b { class C { public: enum class D { x }; struct E; }; struct C::E { "
                                    "union { int i; }; }; extern \"C\" int f(); }\nusing T = a::b::C;"),
                         ["a::b::C", "a::b::C::D", "a::b::C::E", "T"])

    def test_a_source_that_cannot_be_read_is_reported(self):
        for text in ("namespace a { struct B { };", "}", "typedef int Number;"):
            self.assertEqual(len(list(type_names.problems([("a.h", text)]))), 1, text)


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

    def test_shown_output_has_to_be_what_was_printed(self):
        printed = "```sh\nprintf 'one\\ntwo\\nthree\\nfour\\n'\n```\n"
        for shown, status in [("one\ntwo\n", 0), ("one\n...\nfour\n", 0), ("...\nthree\n", 0), ("one\nthree\n", 1),
                              ("four\n...\none\n", 1), ("one\n...\none\n", 1), ("five\n", 1), ("tw\n", 1)]:
            self.assertEqual(self.run_text(f"{printed}```text output\n{shown}```\n"), status, shown)
            self.assertEqual(self.run_text(f"{printed}```sh\ntrue\n```\n```text output\n{shown}```\n"), 1, shown)

    def test_whole_configs_are_checked_and_fragments_shown(self):
        self.assertEqual(self.run_text("```toml\n# a sensor\nschema = 1\n```\n"), 1)
        self.assertEqual(self.run_text("```toml\n[frame]\n```\n"), 0)


class ReportPackages(unittest.TestCase):
    def test_the_lock_file_names_no_address_and_pins_every_package(self):
        lock = json.loads((readme_blocks.ROOT / "apps/report/page/package-lock.json").read_text(encoding="utf-8"))
        packages = {name: package for name, package in lock["packages"].items() if name}
        self.assertGreater(len(packages), 10)
        for name, package in packages.items():
            self.assertNotIn("resolved", package, name)
            self.assertTrue(package["integrity"].startswith("sha512-"), name)
        wanted = json.loads((readme_blocks.ROOT / "apps/report/page/package.json").read_text(encoding="utf-8"))
        for name, version in (wanted["dependencies"] | wanted["devDependencies"]).items():
            self.assertEqual(packages[f"node_modules/{name}"]["version"], version)


class PackagePapers(unittest.TestCase):
    root = Path(__file__).resolve().parent.parent

    def test_every_part_is_listed_once(self):
        when = datetime.datetime(2026, 1, 2, tzinfo=datetime.timezone.utc)
        said = package_papers.spdx(self.root, "1.2.3", when, "0123abcd")
        packages = {entry["SPDXID"]: entry for entry in said["packages"]}
        self.assertEqual(len(packages), len(said["packages"]))
        lock = json.loads((self.root / "apps/report/page/package-lock.json").read_text(encoding="utf-8"))["packages"]
        for path, part in lock.items():
            name = path.split("node_modules/")[-1]
            found = [entry for entry in packages.values() if (entry["name"], entry["versionInfo"]) == (name, part.get("version"))]
            self.assertEqual(len(found), 1 if path else 0, path)
            if found:
                self.assertEqual(len(found[0]["checksums"][0]["checksumValue"]), 128)
        related = {one for relation in said["relationships"] for one in (relation["spdxElementId"], relation["relatedSpdxElement"])}
        self.assertEqual(related, {*packages, "SPDXRef-DOCUMENT"})
        self.assertEqual(said["creationInfo"]["created"], "2026-01-02T00:00:00Z")

    def test_papers_are_those_of_debian_policy(self):
        when = datetime.datetime(2026, 1, 2, tzinfo=datetime.timezone.utc)
        with tempfile.TemporaryDirectory() as folder:
            build = Path(folder)
            notices = build / "apps/report/page/npm/notices.txt"
            notices.parent.mkdir(parents=True)
            notices.write_text("ISC\nsome-part 1.0\n\nPermission is granted", encoding="utf-8")
            package_papers.write_documents(build, "1.2.3", "A B <a@b.c>", when)
            text = (build / "papers/mtfkit/doc/mtfkit/copyright").read_text(encoding="utf-8")
            self.assertIn(" some-part 1.0\n .\n Permission is granted\n", text)
            self.assertIn("GNU General Public License", text)
            for line in text.splitlines():  # a blank line ends a paragraph: the next begins with a field
                self.assertRegex(line, r"^( \S.*| \.|[A-Z][A-Za-z-]+:.*|)$")


if __name__ == "__main__":
    unittest.main()
