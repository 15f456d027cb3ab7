#!/usr/bin/env bash
# Hashes what some twenty repeatable runs leave: a line for each topic and each result file (--help tells more).
# Two lists that `diff` finds equal mean that nothing of the behaviour changed:
#   scripts/golden.sh >before.txt; (change the code); scripts/golden.sh >after.txt; diff before.txt after.txt
# The lists hold for one machine: another processor or C library may round otherwise.
set -euo pipefail
# shellcheck source=scripts/setup.sh
source "$(dirname "${BASH_SOURCE[0]}")/setup.sh" run
exec "$venv/bin/python" "$root/scripts/golden.py" "$@"
