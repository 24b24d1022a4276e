#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Builds the command as a newcomer's build does (MTFKIT_UNITY, apps/quickstart all): in groups, where two functions of one
# name can meet, and with precompiled headers, where one of ours can meet one of the standard library; the suite's build
# has neither. Six minutes on two cores. A warning is an error.
set -euo pipefail

root="$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)"
build=$(mktemp -d)
trap 'rm -rf "$build"' EXIT
cmake -S "$root" -B "$build" -G Ninja -DCMAKE_BUILD_TYPE=Release -DMTFKIT_UNITY=ON -DMTFKIT_WERROR=ON \
  -DMTFKIT_BUILD_TESTS=OFF -DMTFKIT_BUILD_BENCH=OFF
cmake --build "$build" --target mtfkit_cli --parallel "$(nproc)"
