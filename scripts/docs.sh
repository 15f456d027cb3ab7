#!/usr/bin/env bash
# Builds the pages into site/, without a warning or not at all; arguments go to `mkdocs build`.
set -euo pipefail
# shellcheck source=scripts/setup.sh
source "$(dirname "${BASH_SOURCE[0]}")/setup.sh" docs
cd "$root"
exec "$venv/bin/python" -m mkdocs build --quiet --strict "$@"
