#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Runs the fenced blocks of the READMEs, so that what they show works.

  --extract-cpp DIR               write each cpp block to DIR; print `README|has long blocks|snippet|...` for CMake
  --run README --mtf FILE --snippets DIR [--long]    run one README, block after block, in one scratch folder
  --setup [--done COMMAND]        run the `sh setup` blocks from the root of the checkout, but for lines done already

Blocks: `sh` runs under `set -eu` with `mtf` on PATH and notebooks-data beside it; `sh setup` only in --setup; `sh long`
only with --long; `text output` and `toml output` have to be what the `sh` or `python` block before them printed, a line `...` standing
for lines left out; `cpp` is compiled by CMake and run; `python` is a program of its own, with mtfkit of the build tree; `toml` that starts with `schema =` goes through
`mtf config check`, unless it is a scene file ([place]), which names meshes and weather that are not there; text, json,
csv, toml fragments, cmake and mermaid are shown, not run. Anything else fails.
"""

import argparse
import os
import re
import shutil
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
FOLDERS = ("mtf", "radiometry", "calib", "apps", "tests", "notebooks-data")
OUTPUT = {"text output", "toml output"}
KINDS = {"sh", "sh setup", "sh long", "cpp", "python", "toml", "text", "json", "csv", "cmake", "mermaid"} | OUTPUT
FENCE = re.compile(r"^(\s*)(`{3,}|~{3,})\s*(.*?)\s*$")
BLOCK_TIMEOUT_S = {"sh": 250, "sh long": 2800, "cpp": 60, "python": 120, "toml": 30}


class BadBlock(Exception):
    """A block that breaks the rules above."""


@dataclass(frozen=True)
class Block:
    kind: str
    line: int
    text: str


def parse(text, name):
    """The blocks of one README, in order. Raises BadBlock for an unknown or missing kind and for an open fence."""
    blocks, body, opened = [], [], None
    for number, line in enumerate(text.splitlines(), 1):
        fence = FENCE.match(line)
        if opened is None:
            if fence:
                opened, body = (number, *fence.groups()), []
            continue
        start, indent, mark, info = opened
        if fence and fence.group(2)[0] == mark[0] and len(fence.group(2)) >= len(mark) and not fence.group(3):
            kind = " ".join(info.split())
            if kind not in KINDS:
                what = f"`{kind}` is not known" if kind else "has no language"
                raise BadBlock(f"{name}:{start}: the block {what}; use one of: {', '.join(sorted(KINDS))}")
            blocks.append(Block(kind, start, "\n".join(body) + "\n"))
            opened = None
        else:
            body.append(line.removeprefix(indent))
    if opened:
        raise BadBlock(f"{name}:{opened[0]}: the block is never closed")
    return blocks


def readmes():
    found = [ROOT / "README.md"] if (ROOT / "README.md").exists() else []
    for folder in FOLDERS:
        found += sorted(p for p in (ROOT / folder).rglob("README.md") if "node_modules" not in p.parts)
    return [p.relative_to(ROOT).as_posix() for p in found]


def blocks_of(readme):
    return parse((ROOT / readme).read_text(encoding="utf-8"), readme)


def snippet_name(readme, index):
    folder = re.sub(r"\W", "_", os.path.dirname(readme)) or "top"
    return f"readme_{folder}_{index}"


def extract_cpp(folder):
    folder.mkdir(parents=True, exist_ok=True)
    for readme in readmes():
        blocks = blocks_of(readme)
        names = []
        for index, block in enumerate(b for b in blocks if b.kind == "cpp"):
            names.append(snippet_name(readme, index))
            source = folder / f"{names[-1]}.cpp"
            text = f'#line {block.line + 1} "{readme}"\n{block.text}'
            if not source.exists() or source.read_text(encoding="utf-8") != text:
                source.write_text(text, encoding="utf-8")
        has_long = "yes" if any(b.kind == "sh long" for b in blocks) else "no"
        print("|".join([readme, has_long, *names]))
    return 0


def command_for(block, scratch, mtf, snippet):
    """The argument list that runs a block, or None for one that is only shown."""
    if block.kind in ("sh", "sh long"):
        return ["bash", "-c", "set -eu\n" + block.text]
    if block.kind == "cpp":
        return [snippet]
    if block.kind == "python":
        return [sys.executable, "-B", "-c", block.text]
    code = [line for line in block.text.splitlines() if line.strip() and not line.lstrip().startswith("#")]
    if block.kind == "toml" and code and re.match(r"schema\s*=", code[0]) and "[place]" not in code:
        config = scratch / f"readme_line_{block.line}.toml"
        config.write_text(block.text, encoding="utf-8")
        return [mtf, "config", "check", config.name]
    return None


def missing_line(shown, printed):
    """The first shown line that `printed` has not: shown lines follow one another there too, but for `...` between."""
    printed = [line.rstrip() for line in printed.splitlines()]
    runs, at = [[]], 0
    for line in (line.rstrip() for line in shown.splitlines()):
        if line == "...":
            runs.append([])
        else:
            runs[-1].append(line)
    for run in runs:
        starts = range(at, len(printed) - len(run) + 1)
        start = next((i for i in starts if printed[i:i + len(run)] == run), None)
        if start is None:
            return next((line for line in run if line not in printed[at:]), run[0])
        at = start + len(run)
    return None


def run_blocks(blocks, readme, scratch, mtf, snippets, with_long):
    """Runs the blocks in `scratch`; returns 0, or 1 at the first that fails."""
    package = Path(mtf).parent.parent / "python"
    env = dict(os.environ, PATH=f"{Path(mtf).parent}{os.pathsep}{os.environ['PATH']}", PYTHONPATH=str(package))
    cpp_count = 0
    printed = ""
    for block in blocks:
        snippet = None
        if block.kind == "cpp":
            snippet = str(Path(snippets) / snippet_name(readme, cpp_count))
            cpp_count += 1
        if block.kind == "sh setup" or (block.kind == "sh long" and not with_long):
            continue
        if block.kind == "python" and not any(package.glob("mtfkit/_core*")):
            print(f"--- {readme}:{block.line} (python): not run, this build has no mtfkit for Python")
            printed = None
            continue
        if block.kind in OUTPUT and printed is None:
            continue
        if block.kind in OUTPUT:
            line = missing_line(block.text, printed)
            if line is not None:
                print(f"{readme}:{block.line}: the commands above did not print, or not in this order: {line}")
                return 1
            continue
        command = command_for(block, scratch, mtf, snippet)
        if command is None:
            continue
        print(f"--- {readme}:{block.line} ({block.kind})\n{block.text}", end="", flush=True)
        # A file and not a pipe: a process that outlives its block would keep a pipe open.
        with tempfile.TemporaryFile() as log:
            try:
                code = subprocess.run(command, cwd=scratch, env=env, stdin=subprocess.DEVNULL, stdout=log, stderr=log,
                                      timeout=BLOCK_TIMEOUT_S[block.kind], check=False).returncode
            except subprocess.TimeoutExpired:
                code = f"none within {BLOCK_TIMEOUT_S[block.kind]} s"
            log.seek(0)
            output = log.read().decode("utf-8", "replace")
        print(output, end="", flush=True)
        if block.kind in ("sh", "sh long", "python"):
            printed = output
        if code != 0:
            print(f"{readme}:{block.line}: the block failed, exit code {code}")
            return 1
    return 0


def run_readme(readme, mtf, snippets, with_long):
    blocks = blocks_of(readme)
    with tempfile.TemporaryDirectory(prefix="readme-") as folder:
        scratch = Path(folder)
        if (ROOT / "notebooks-data").is_dir():
            shutil.copytree(ROOT / "notebooks-data", scratch / "notebooks-data")
        return run_blocks(blocks, readme, scratch, os.path.abspath(mtf), os.path.abspath(snippets), with_long)


def run_setup(done):
    count = 0
    for readme in readmes():
        for block in (b for b in blocks_of(readme) if b.kind == "sh setup"):
            count += 1
            lines = []
            for line in block.text.splitlines():
                command = line.split("#")[0].strip()
                # How one gets to the checkout: we are there.
                skip = command in done or re.match(r"(git clone|cd) ", command)
                lines += [f"echo {('skipped: ' + command)!r}" if skip else line]
            print(f"--- {readme}:{block.line} (sh setup)\n{block.text}", end="", flush=True)
            code = subprocess.run(["bash", "-c", "set -eu\n" + "\n".join(lines)], cwd=ROOT,
                                  stdin=subprocess.DEVNULL, check=False).returncode
            if code != 0:
                print(f"{readme}:{block.line}: the set-up block failed, exit code {code}")
                return 1
    if count == 0:
        print("no README has a `sh setup` block: the two commands must be in README.md")
        return 1
    return 0


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    mode = parser.add_mutually_exclusive_group(required=True)
    mode.add_argument("--extract-cpp", type=Path, metavar="DIR")
    mode.add_argument("--run", metavar="README")
    mode.add_argument("--setup", action="store_true")
    parser.add_argument("--mtf", metavar="FILE")
    parser.add_argument("--snippets", metavar="DIR")
    parser.add_argument("--long", action="store_true")
    parser.add_argument("--done", action="append", default=[], metavar="COMMAND")
    args = parser.parse_args()
    if args.run and not (args.mtf and args.snippets):
        parser.error("--run needs --mtf and --snippets")
    try:
        if args.extract_cpp:
            return extract_cpp(args.extract_cpp)
        return run_setup(args.done) if args.setup else run_readme(args.run, args.mtf, args.snippets, args.long)
    except BadBlock as error:
        print(error, file=sys.stderr)
        return 1


if __name__ == "__main__":
    sys.exit(main())
