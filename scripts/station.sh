#!/usr/bin/env bash
# Runs the live graph with the operator's page until Ctrl-C, or opens the page of a running one (--help tells the options).
set -euo pipefail
# shellcheck source=scripts/setup.sh
source "$(dirname "${BASH_SOURCE[0]}")/setup.sh" run
# exec: signals reach the supervisor itself, which stops every node.
exec "$venv/bin/python" -m forest_station.station "$@"
