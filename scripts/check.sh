#!/usr/bin/env bash
# Format, lint, types and architecture: the checks that CI runs. All of them run, then the failed ones are named.
set -euo pipefail
# shellcheck source=scripts/setup.sh
source "$(dirname "${BASH_SOURCE[0]}")/setup.sh" dev
cd "$root"
failed=()

check() { # check NAME COMMAND...
    local name=$1
    shift
    printf '== %s\n' "$name"
    "$@" || failed+=("$name")
}

check format .venv/bin/ruff format --check .
check lint .venv/bin/ruff check .
check types .venv/bin/python -m mypy
check imports .venv/bin/lint-imports
if command -v shellcheck >/dev/null; then
    check shell shellcheck scripts/*.sh .ci/run
fi

((${#failed[@]} == 0)) || {
    printf 'check: failed: %s\n' "${failed[*]}" >&2
    exit 1
}
printf 'check: all passed\n'
