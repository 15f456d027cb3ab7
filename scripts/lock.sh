#!/usr/bin/env bash
# Regenerates the nine lock files from pyproject.toml; arguments (such as --upgrade) go to `uv pip compile`.
set -euo pipefail

cd "$(dirname "${BASH_SOURCE[0]}")/.."
command -v uv >/dev/null || {
    echo "lock: error: uv was not found; install it (pip install uv)." >&2
    exit 1
}

# What the editable install needs: pip checks no hash of what it fetches into an isolated build.
# And what the tests' gymnasium needs in every Python, the run only below 3.13: the locks do not overlap.
build_requirement=$'setuptools>=77\ntyping-extensions'

compile() {
    uv pip compile --quiet --generate-hashes --no-emit-index-url --no-emit-find-links \
        --custom-compile-command scripts/lock.sh "$@"
}

# The tests' lock holds what the run's does not, and both resolve to the same versions.
compile_run_and_test() { # compile_run_and_test RUN_LOCK TEST_LOCK OPTIONS...
    local run=$1 test=$2 names=() name
    shift 2
    compile "$@" --output-file "$run" pyproject.toml - <<<"$build_requirement"
    while IFS= read -r name; do
        names+=(--no-emit-package "$name")
    done < <(sed -n 's/^\([a-z0-9][a-z0-9._-]*\)==.*/\1/p' "$run" | sort -u)
    # FMPy's lark would lie in the folder of ROS's lark-parser, which serves it as well.
    compile "$@" --extra test --constraint "$run" "${names[@]}" --no-emit-package lark --output-file "$test" pyproject.toml
}

# EmPy is published as source only and needed only where messages are generated, so never here.
compile_run_and_test requirements.lock requirements-test.lock \
    --universal --python-version 3.10 --extra ros --extra fast --no-emit-package empy "$@"

# The message extensions of Ubuntu 24.04's Jazzy were compiled for its own numpy, which must never be shadowed.
numpy_of_jazzy=$(mktemp)
trap 'rm -f -- "$numpy_of_jazzy"' EXIT
echo "numpy==1.26.4" >"$numpy_of_jazzy"
compile_run_and_test requirements-jazzy.lock requirements-jazzy-test.lock \
    --python-version 3.12 --python-platform x86_64-manylinux_2_28 --extra fast --no-emit-package numpy \
    --constraint "$numpy_of_jazzy" "$@"

# Extras cannot be constrained by a lock of their own, so the tools are listed here.
compile --universal --python-version 3.10 --constraint requirements.lock --constraint requirements-test.lock "$@" \
    --output-file requirements-dev.lock - <<'TOOLS'
ruff
mypy
types-pyyaml
import-linter
pre-commit
colcon-common-extensions
TOOLS

# One .venv may hold both sorts of tools.
compile --universal --python-version 3.10 --constraint requirements.lock --constraint requirements-test.lock \
    --constraint requirements-dev.lock "$@" --output-file requirements-docs.lock - <<'TOOLS'
mkdocs-material
mkdocstrings[python]
l2m4m
mermaidx
TOOLS

# What scripts/mutate.sh installs for itself, beside .venv's own packages. Yattag, for reports of HTML, is published
# as source only.
compile --universal --python-version 3.10 --no-emit-package yattag "$@" --output-file requirements-mutate.lock - \
    <<<"cosmic-ray"

# What scripts/supply.sh installs for itself, and what scripts/fuzz.sh does; Atheris begins with CPython 3.11.
compile --universal --python-version 3.10 "$@" --output-file requirements-supply.lock - <<<$'cyclonedx-bom\npip-audit'
compile --universal --python-version 3.11 "$@" --output-file requirements-fuzz.lock - <<<"atheris<3.1" # the last with wheels for Python 3.11
