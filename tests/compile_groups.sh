#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Compiles the groups of sources that a newcomer's build has (MTFKIT_UNITY, apps/quickstart), where two functions of one
# name can meet; the suite's build has none. Without the optimiser and without what is not in groups: 3 minutes on two
# cores. A warning is an error.
set -euo pipefail

root="$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)"
build=$(mktemp -d)
trap 'rm -rf "$build"' EXIT
cmake -S "$root" -B "$build" -G Ninja -DMTFKIT_UNITY=ON -DMTFKIT_WERROR=ON -DMTFKIT_BUILD_TESTS=OFF \
  -DMTFKIT_BUILD_BENCH=OFF -DCMAKE_BUILD_TYPE=Debug -DCMAKE_CXX_FLAGS_DEBUG=-O0 -DCMAKE_EXPORT_COMPILE_COMMANDS=ON
/usr/bin/python3 - "$build/compile_commands.json" >"$build/commands" <<'EOF'
import json, os, sys
for entry in json.load(open(sys.argv[1], encoding="utf-8")):
    if "/Unity/" in entry["file"]:
        output = entry["command"].split(" -o ")[1].split()[0]
        print(f"mkdir -p {os.path.dirname(output)} && {entry['command']}")
EOF
count=$(wc -l <"$build/commands")
[ "$count" -gt 0 ] || { printf 'compile_groups: there are no groups\n' >&2; exit 1; }
(cd "$build" && xargs -d '\n' -P "$(nproc)" -I{} sh -c '{}' <commands)
printf 'compile_groups: %s groups compile\n' "$count"
