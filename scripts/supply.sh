#!/usr/bin/env bash
# Tells what is installed: licences, known faults, and a bill of materials (CycloneDX) for who asks.
#
#   scripts/supply.sh [SBOM.json]    default: .venv/sbom.json
#
# The exit code is 1 if a licence is not known to fit, or a package has a known fault or could not be asked about.
set -euo pipefail
# shellcheck source=scripts/setup.sh
source "$(dirname "${BASH_SOURCE[0]}")/setup.sh"
cd "$root"
tool=$venv/supply lock=requirements-supply.lock sbom=${1:-$venv/sbom.json} code=0
if ! cmp --silent "$lock" "$tool/$lock"; then
    say "Installing CycloneDX and pip-audit into .venv/supply …"
    "$venv/bin/python" -m pip --disable-pip-version-check --no-input --quiet install --upgrade --no-deps \
        --target "$tool/lib" --require-hashes --only-binary=:all: -r "$lock" || die "They could not be installed."
    cp -- "$lock" "$tool/$lock"
fi
"$venv/bin/python" scripts/licences.py || code=1
PYTHONPATH=$tool/lib "$venv/bin/python" -m cyclonedx_py requirements --output-file "$sbom" requirements.lock || code=1
say "Bill of materials: $sbom"
PYTHONPATH=$tool/lib "$venv/bin/python" -m pip_audit --strict --require-hashes --disable-pip -r requirements.lock || code=1
exit "$code"
