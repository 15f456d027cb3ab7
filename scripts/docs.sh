#!/usr/bin/env bash
# Builds the pages into site/: without a warning, and so that they ask nothing of the network.
set -euo pipefail
# shellcheck source=scripts/setup.sh
source "$(dirname "${BASH_SOURCE[0]}")/setup.sh" docs
cd "$root"
export NO_MKDOCS_2_WARNING=1 # the theme's advertisement for its successor
"$venv/bin/python" -m mkdocs build --strict
if grep -rlE '<(script|img|link|iframe)[^>]* (src|srcset|href)="?(https?:)?//' --include='*.html' site; then
    printf 'docs: error: the pages above ask something of the network.\n' >&2
    exit 1
fi
printf 'docs: built site/index.html\n'
