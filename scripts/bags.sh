#!/usr/bin/env bash
# Makes the reference bags in bags/ anew (--help tells the options).
set -euo pipefail
# shellcheck source=scripts/setup.sh
source "$(dirname "${BASH_SOURCE[0]}")/setup.sh" run
cd "$(dirname "${BASH_SOURCE[0]}")/.."
exec "$venv/bin/python" -m forest_study.demo.reference_bags "$@"
