#!/usr/bin/env bash
# Runs the whole test suite; arguments go to pytest.
set -euo pipefail
# shellcheck source=scripts/setup.sh
source "$(dirname "${BASH_SOURCE[0]}")/setup.sh" run
export ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST # tests talk to nobody outside this machine
export OMP_NUM_THREADS=1                       # threads of BLAS only disturb the timing of the nodes
cd "$root"
exec "$venv/bin/python" -m pytest "$@"
