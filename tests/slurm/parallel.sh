#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# A sweep by GNU parallel, killed in the middle and called again; the merged tables have to equal those of a local run.
# Usage: tests/slurm/parallel.sh MTF     exit code 77: no GNU parallel here
set -euo pipefail

here="$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)"
# shellcheck source=tests/slurm/study.sh
. "$here/study.sh"
mtf="$(realpath "$1")"
# Everything that GNU parallel or a shell would replace; SweepShards holds the local engine to the same name.
plan="it's {} a {.} {#} {= \$_ =} \"\$HOME\" \`plan\`"
shards=12

command -v parallel >/dev/null || skip "no parallel on this machine"
parallel --version 2>/dev/null | grep -q 'GNU parallel' || skip "parallel is another program than GNU parallel"

work="$(mktemp -d "${TMPDIR:-/tmp}/mtfkit_parallel.XXXXXX")"
trap 'rm -rf "$work"' EXIT
cd "$work"
make_study "$mtf"
"$mtf" sweep study.toml -o local --progress none >/dev/null
"$mtf" sweep plan study.toml -o "$plan" --shards $shards >/dev/null

# In a process group of its own, so that all of it ends together.
setsid "$mtf" sweep submit "$plan" --engine parallel --submit --threads 1 >/dev/null 2>&1 &
group=$!
for _ in $(seq 600); do
  [ "$(finished "$plan")" -lt 2 ] || break
  sleep 0.1
done
kill -9 -- "-$group"
wait "$group" 2>/dev/null || true
before=$(finished "$plan")
printf 'killed with %s of %s shards finished\n' "$before" "$shards"
[ "$before" -ge 2 ] && [ "$before" -lt "$shards" ] || fail "not in the middle"

"$mtf" sweep submit "$plan" --engine parallel --submit --threads 1 >/dev/null
[ "$(finished "$plan")" = "$shards" ] || fail "shards are missing after the second call"
"$mtf" sweep merge "$plan" -o merged >/dev/null
same_tables local merged
