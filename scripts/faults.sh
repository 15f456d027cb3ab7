#!/usr/bin/env bash
# Makes docs/explanation/faults.md: every fault in every state, 20 seeds.
#
#   scripts/faults.sh [--seeds N]
#
# The exit code is 1 if a bound is broken; the page is made all the same.
set -euo pipefail
# shellcheck source=scripts/setup.sh
source "$(dirname "${BASH_SOURCE[0]}")/setup.sh"
out=$(mktemp -d "${TMPDIR:-/tmp}/forest-crane-faults.XXXXXX")
trap 'rm -rf -- "$out"' EXIT
code=0
"$venv/bin/forest-study" faults "$@" --out "$out/faults" || code=$?
cp -- "$out/faults/faults.md" "$root/docs/explanation/faults.md"
exit "$code"
