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
alone=test/forest_station/live # judged in tenths of a second, beside a browser
again=0

has_idle_cores() { # whether for a second nobody else uses this computer: what is idle starves beside others
    local ticks=() before
    read -r -a ticks </proc/stat # cpu, user, nice, system, idle …
    before=${ticks[4]}
    sleep 1
    read -r -a ticks </proc/stat
    ((10 * (ticks[4] - before) > 9 * $(nproc --all) * $(getconf CLK_TCK)))
}

# Live tests leave half of a computer idle. What only computes takes that and no more, for nodes keep time with
# the computer's clock: it gives way to them at once, and has a cache of its own. Its report comes last.
computing=("${parallel[@]}" auto -m "not live" --override-ini cache_dir=.pytest_cache/computing)
beside=""
if has_idle_cores; then
    report=$(mktemp "${TMPDIR:-/tmp}/forest-crane-test.XXXXXX")
    setsid chrt --idle 0 "$venv/bin/python" -m pytest "${computing[@]}" >"$report" 2>&1 &
    beside=$!
    trap 'kill -- "-$beside" 2>/dev/null || true; cat -- "$report"; rm -f -- "$report"' EXIT
else
    suite "${computing[@]}"
fi
live "${parallel[@]}" "$waiting" --ignore="$alone"
live "$alone"
if [[ -n $beside ]]; then
    for process in $(pgrep --session "$beside"); do # which only root may; but then nobody else is here
        chrt --all-tasks --other --pid 0 "$process" 2>/dev/null || true
    done
    wait "$beside"
fi
if ((again)); then
    # A crane from which a shared computer is taken for 0.1 s stops, as it should: once more, one by one.
    suite -m live --verbose --last-failed --last-failed-no-failures none
fi
