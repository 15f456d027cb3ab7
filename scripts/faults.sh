#!/usr/bin/env bash
# Makes docs/explanation/faults.md: every fault in every state, 20 seeds, and signals to live nodes.
#
#   scripts/faults.sh [--seeds N] [--live N]
#
# The exit code is 1 if a bound is broken; the page is made all the same.
set -euo pipefail
# shellcheck source=scripts/setup.sh
source "$(dirname "${BASH_SOURCE[0]}")/setup.sh"
out=$(mktemp -d "${TMPDIR:-/tmp}/forest-crane-faults.XXXXXX")
trap 'rm -rf -- "$out"' EXIT
code=0
"$venv/bin/forest-study" faults --live 3 "$@" --out "$out/faults" || code=$?
cp -- "$out/faults/faults.md" "$root/docs/explanation/faults.md"
exit "$code"
