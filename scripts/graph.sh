#!/usr/bin/env bash
# Runs the graph live until Ctrl-C (--help tells the options).
set -euo pipefail
# shellcheck source=scripts/setup.sh
source "$(dirname "${BASH_SOURCE[0]}")/setup.sh" run
# exec: signals reach the supervisor itself, which stops every node.
exec "$venv/bin/python" -m forest_bringup.graph "$@"
