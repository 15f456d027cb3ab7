#!/usr/bin/env bash
# Runs the whole test suite; arguments go to pytest, which then runs in one process.
set -euo pipefail
# shellcheck source=scripts/setup.sh
source "$(dirname "${BASH_SOURCE[0]}")/setup.sh" test
export ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST # tests talk to nobody outside this machine
export OMP_NUM_THREADS=1                       # threads of BLAS only disturb the timing of the nodes
cd "$root"
if [[ $# -eq 0 ]]; then
    parallel=(-p xdist --numprocesses auto --maxprocesses 8 --dist loadfile --no-loadscope-reorder)
    repeats=(-p rerunfailures -rR)   # of live tests; the summary names them
    alone=test/forest_station/live # judged in tenths of a second, beside a browser
    # Nodes keep time with the computer's clock: beside tests that compute they are late.
    "$venv/bin/python" -m pytest "${parallel[@]}" -m "not live"
    "$venv/bin/python" -m pytest "${parallel[@]}" "${repeats[@]}" -m live --ignore="$alone"
    set -- "${repeats[@]}" "$alone"
fi
exec "$venv/bin/python" -m pytest "$@"
