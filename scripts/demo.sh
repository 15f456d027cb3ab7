#!/usr/bin/env bash
# Drives one session through the whole graph and leaves its bag, summary and pictures (--help tells the options).
set -euo pipefail
# shellcheck source=scripts/setup.sh
source "$(dirname "${BASH_SOURCE[0]}")/setup.sh" run
# exec: signals reach the supervisor itself, which stops every node.
exec "$venv/bin/python" -m forest_study.demo.demo "$@"
