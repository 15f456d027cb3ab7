#!/usr/bin/env bash
# Breaks the safety code in one place at a time, in a copy, and tells which faults no test notices.
#
#   scripts/mutate.sh              every module of test/mutation/modules.yaml
#   scripts/mutate.sh MODULE...    some, by their stems: scripts/mutate.sh velocity_scaling workspace
#   scripts/mutate.sh --sample N [--seed SEED] [GROUP...]
#                                  N mutants of each group of test/mutation/sampled.yaml, drawn at random
#
# The exit code is 1 if a survivor is not explained in test/mutation/survivors.yaml; of a sample, if the
# tests notice less than 90 % of a group's.
set -euo pipefail
# shellcheck source=scripts/setup.sh
source "$(dirname "${BASH_SOURCE[0]}")/setup.sh" test
export ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST OMP_NUM_THREADS=1
unset PYTHONDONTWRITEBYTECODE # the copy's first run compiles for all others
cd "$root"

tool=$venv/mutation
lock=requirements-mutate.lock
if ! cmp --silent "$lock" "$tool/$lock"; then
    say "Installing Cosmic Ray into .venv/mutation …"
    "$venv/bin/python" -m venv --clear "$tool"
    "$tool/bin/python" -m pip --disable-pip-version-check --no-input --quiet install --no-deps \
        --require-hashes --only-binary=:all: -r "$lock" || die "Cosmic Ray could not be installed."
    cp -- "$lock" "$tool/$lock"
fi

copy=$(mktemp -d "${TMPDIR:-/tmp}/forest-crane-mutants.XXXXXX")
trap 'rm -rf -- "$copy"' EXIT
cp -a -- src test "$copy"
for entry in [!.]*; do # what tests read, and nobody breaks
    [[ -e $copy/$entry ]] || ln -s -- "$root/$entry" "$copy/$entry"
done
packages=$(printf ':%s' "$copy"/src/*)
run=run.py
[[ " $* " != *" --sample"* ]] || run=sample.py
PYTHONPATH=${packages#:}${PYTHONPATH:+:$PYTHONPATH} "$venv/bin/python" "$copy/test/mutation/$run" \
    "$tool/bin/python" "$copy" "$@"
