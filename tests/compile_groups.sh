#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Compiles the sources as a newcomer's build does (MTFKIT_UNITY, apps/quickstart): in groups, where two functions of one
# name can meet, and with precompiled headers, where one of ours can meet one of the standard library; the suite's build
# has neither. Without the optimiser: 3 minutes on two cores. A warning is an error.
set -euo pipefail

root="$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)"
build=$(mktemp -d)
trap 'rm -rf "$build"' EXIT
cmake -S "$root" -B "$build" -G Ninja -DMTFKIT_UNITY=ON -DMTFKIT_WERROR=ON -DMTFKIT_BUILD_TESTS=OFF \
  -DMTFKIT_BUILD_BENCH=OFF -DCMAKE_BUILD_TYPE=Debug -DCMAKE_CXX_FLAGS_DEBUG=-O0 -DCMAKE_EXPORT_COMPILE_COMMANDS=ON
/usr/bin/python3 - "$build/compile_commands.json" >"$build/commands" <<'EOF'
import json, os, sys
for entry in json.load(open(sys.argv[1], encoding="utf-8")):
    if "/Unity/" in entry["file"] or "/cmake_pch.hxx " in entry["command"]:
        output = entry["command"].split(" -o ")[1].split()[0]
        print(f"mkdir -p {os.path.dirname(output)} && {entry['command']}")
EOF
count=$(wc -l <"$build/commands")
[ "$count" -gt 0 ] || { printf 'compile_groups: there are no groups\n' >&2; exit 1; }
ninja -C "$build" mtf/CMakeFiles/mtfkit_mtf.dir/cmake_pch.hxx.gch
(cd "$build" && xargs -d '\n' -P "$(nproc)" -I{} sh -c '{}' <commands)
printf 'compile_groups: %s sources and groups compile\n' "$count"
