#!/usr/bin/env bash
# Tells which lines and branches of the safety code its own tests run (some minutes).
#
#   scripts/coverage.sh [MODULE...]    modules of test/mutation/modules.yaml, by their stems
set -euo pipefail
"$(dirname "${BASH_SOURCE[0]}")/setup.sh" test
# shellcheck source=scripts/setup.sh
source "$(dirname "${BASH_SOURCE[0]}")/setup.sh" dev
export ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST OMP_NUM_THREADS=1
exec "$venv/bin/python" "$root/test/mutation/covered.py" "$@"
