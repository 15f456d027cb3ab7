#!/usr/bin/env bash
# Makes docs/explanation/faults.md: every fault in every state, 20 seeds; then live, each 3 times (20 minutes).
#
#   scripts/faults.sh [--seeds N]
#
# The exit code is 1 if a bound is broken; the page is made all the same. With the right to it (root), the live
# graph comes before everything else that the computer does.
set -euo pipefail
# shellcheck source=scripts/setup.sh
source "$(dirname "${BASH_SOURCE[0]}")/setup.sh" test
export ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST OMP_NUM_THREADS=1
out=$(mktemp -d "${TMPDIR:-/tmp}/forest-crane-faults.XXXXXX")
trap 'rm -rf -- "$out"' EXIT
cd "$root"
code=0
"$venv/bin/forest-study" faults "$@" --out "$out/faults" || code=$?
[[ -e $out/faults/faults.md ]] || exit "$code" # wrong arguments, or only asked for help
first=()
if chrt --rr 1 true 2>/dev/null; then first=(chrt --rr 1); fi
LIVE_FAULTS=3 LIVE_FAULTS_OUT=$out/live.jsonl "${first[@]}" "$venv/bin/python" -m pytest -q \
    test/forest_study/faults/test_live_faults.py || code=1
{
    cat -- "$out/faults/faults.md"
    PYTHONPATH=test/helpers "$venv/bin/python" test/helpers/live_faults.py "$out/live.jsonl"
} >"$out/page.md"
cp -- "$out/page.md" docs/explanation/faults.md
exit "$code"
