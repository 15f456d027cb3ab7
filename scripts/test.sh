#!/usr/bin/env bash
# Runs the whole test suite; arguments go to pytest, which then runs in one process.
set -euo pipefail
# shellcheck source=scripts/setup.sh
source "$(dirname "${BASH_SOURCE[0]}")/setup.sh" test
waiting=$((($(nproc) * 3 + 1) / 2)) # live tests wait more than they compute; nproc heeds OMP_NUM_THREADS
export ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST # tests talk to nobody outside this machine
export OMP_NUM_THREADS=1                       # threads of BLAS only disturb the timing of the nodes
cd "$root"
suite() { "$venv/bin/python" -m pytest "$@"; }
live() { suite -m live "$@" || { [[ $? -eq 1 ]] && again=1; }; } # 1: tests failed
if [[ $# -gt 0 ]]; then
    suite "$@"
    exit
fi
parallel=(-p xdist --maxprocesses 8 --dist loadfile --no-loadscope-reorder --numprocesses)
alone=test/forest_station/live      # judged in tenths of a second, beside a browser
again=0
# Nodes keep time with the computer's clock: beside tests that compute they are late.
suite "${parallel[@]}" auto -m "not live"
live "${parallel[@]}" "$waiting" --ignore="$alone"
live "$alone"
if ((again)); then
    # A crane from which a shared computer is taken for 0.1 s stops, as it should: once more, one by one.
    suite -m live --verbose --last-failed --last-failed-no-failures none
fi
