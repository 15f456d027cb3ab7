#!/usr/bin/env bash
# Runs the whole test suite; arguments go to pytest, which then runs in one process.
set -euo pipefail
# shellcheck source=scripts/setup.sh
source "$(dirname "${BASH_SOURCE[0]}")/setup.sh" test
export ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST # tests talk to nobody outside this machine
export OMP_NUM_THREADS=1                       # threads of BLAS only disturb the timing of the nodes
cd "$root"
pytest=("$venv/bin/python" -m pytest)
[[ $# -eq 0 ]] || exec "${pytest[@]}" "$@"

alone=test/forest_station/live # judged in tenths of a second, beside a browser: after the other live tests
spread=(-p xdist --numprocesses auto --maxprocesses 8 --dist loadfile --no-loadscope-reorder --ignore="$alone")
# Tests of running nodes mostly wait, and are judged by the clock: what only computes runs behind them meanwhile.
computing=$(mktemp)
trap 'kill -INT "$pid" 2>/dev/null || true; rm -f "$computing"' EXIT
trap 'exit 130' INT
set -m # in a group of its own it hears SIGINT, and so does what it starts
nice -n 10 "${pytest[@]}" "${spread[@]}" -m "not live" >"$computing" 2>&1 &
pid=$!
set +m
failed=0
"${pytest[@]}" "${spread[@]}" -m live || failed=1
"${pytest[@]}" "$alone" || failed=1
wait "$pid" || failed=1
cat "$computing"
exit "$failed"
