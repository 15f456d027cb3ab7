#!/usr/bin/env bash
# Regenerates the three lock files from pyproject.toml; arguments (such as --upgrade) go to `uv pip compile`.
set -euo pipefail

cd "$(dirname "${BASH_SOURCE[0]}")/.."
command -v uv >/dev/null || {
    echo "lock: error: uv was not found; install it (pip install uv)." >&2
    exit 1
}

# What the editable install needs: pip checks no hash of what it fetches into an isolated build.
build_requirement="setuptools>=77"

compile() {
    uv pip compile --quiet --generate-hashes --no-emit-index-url --no-emit-find-links \
        --custom-compile-command scripts/lock.sh "$@"
}

# EmPy is published as source only and needed only where messages are generated, so never here.
compile --universal --python-version 3.10 --extra ros --extra fast --extra test --no-emit-package empy "$@" \
    --output-file requirements.lock pyproject.toml - <<<"$build_requirement"

# The message extensions of Ubuntu 24.04's Jazzy were compiled for its own numpy, which must never be shadowed.
compile --python-version 3.12 --python-platform x86_64-manylinux_2_28 --extra fast --extra test --no-emit-package numpy \
    --constraint <(printf 'numpy==1.26.4\n') "$@" \
    --output-file requirements-jazzy.lock pyproject.toml - <<<"$build_requirement"

# Extras cannot be constrained by a lock of their own, so the tools are listed here.
compile --universal --python-version 3.10 --constraint requirements.lock "$@" \
    --output-file requirements-dev.lock - <<'TOOLS'
ruff
mypy
types-pyyaml
import-linter
pre-commit
colcon-common-extensions
TOOLS

# What scripts/mutate.sh installs for itself, beside .venv's own packages. Yattag, for reports of HTML, is published
# as source only.
compile --universal --python-version 3.10 --no-emit-package yattag "$@" --output-file requirements-mutate.lock - \
    <<<"cosmic-ray"
