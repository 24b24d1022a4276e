#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Lists the sources that clang-format would change; exits 1 when there are any. Usage: tests/format.sh [clang-format]
set -eu
cd "$(dirname "$0")/.."
formatter=${1:-clang-format}
sources() {
  find mtf radiometry calib apps tests \( -name '*.h' -o -name '*.cpp' \) -print 2>/dev/null | sort
}
# Nearly all of the time of one file is the start of the program: all files together take a tenth.
sources | xargs -r -d '\n' "$formatter" --dry-run -Werror >/dev/null 2>&1 && exit 0
offenders=$(sources |
  while IFS= read -r file; do
    "$formatter" --dry-run -Werror "$file" >/dev/null 2>&1 || printf '%s\n' "$file"
  done)
[ -z "$offenders" ] && exit 0
printf 'run clang-format -i on:\n%s\n' "$offenders"
exit 1
