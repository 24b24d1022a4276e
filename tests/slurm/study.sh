# SPDX-License-Identifier: Apache-2.0
# Sourced by the tests of this folder: a study whose shards take a second or more each, and what is compared in the end.

fail() {
  printf 'FAILED: %s\n' "$*" >&2
  exit 1
}

skip() {
  printf 'skipped: %s; ./tests/run --slurm installs what is missing\n' "$*"
  exit 77
}

# make_study MTF: sensor.toml and study.toml in the current folder.
make_study() {
  "$1" config init -o sensor.toml --quiet
  cat >study.toml <<'TOML'
schema = 1
name = "shards"
sensor = "sensor.toml"
seed = 3
constraints = ["mtf_nyquist > 0.3"]
objectives = ["maximize mtf_nyquist", "minimize frame.pitch"]
[[axis]]
parameter = "frame.pitch"
from = "8 um"
to = "20 um"
[[axis]]
parameter = "jitter.rms"
from = "0.1 um"
to = "4 um"
[[as_built]]
parameter = "jitter.rms"
sd = "10 %"
[sampling]
method = "sobol"
points = 8000
[yield]
draws = 100
TOML
}

# finished PLAN: how many shards there are.
finished() {
  find "$1/shards" -maxdepth 1 -type f -name 'part-*' ! -name '*.tmp.*' | wc -l
}

# same_tables A B
same_tables() {
  for table in designs.csv designs.npy; do
    cmp "$1/$table" "$2/$table" || fail "$table of $1 and $2 differ"
  done
  printf 'designs.csv and designs.npy are equal byte for byte\n'
}
