#!/usr/bin/env bash
# Drives the crane from its page in a browser for ten minutes (or MINUTES) and tells whether memory grows,
# stops are missed, or the rate falls.
#
#   scripts/long.sh [MINUTES]
set -euo pipefail
# shellcheck source=scripts/setup.sh
source "$(dirname "${BASH_SOURCE[0]}")/setup.sh" test
export ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST
exec "$venv/bin/python" "$root/benchmarks/soak.py" "$@"
