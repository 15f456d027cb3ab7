#!/usr/bin/env bash
# Fuzzes what reads files and messages, guided by the lines that it runs; needs CPython 3.11 to 3.13.
#
#   scripts/fuzz.sh [SECONDS [TARGET...]]    a minute for each target of test/fuzz/targets.py
#
# The exit code is 1 if an input raised what it must not, or took over 1 s or 1 GB; it is in .venv/fuzz/found.
set -euo pipefail
# shellcheck source=scripts/setup.sh
source "$(dirname "${BASH_SOURCE[0]}")/setup.sh" test
cd "$root"
tool=$venv/fuzz lock=requirements-fuzz.lock seconds=${1:-60} failed=()
[[ $seconds =~ ^[1-9][0-9]*$ ]] || die "SECONDS '$seconds'; allowed: whole, 1 or more" # 0 has no end
if ! cmp --silent "$lock" "$tool/$lock"; then
    say "Installing Atheris into .venv/fuzz …"
    "$venv/bin/python" -m pip --disable-pip-version-check --no-input --quiet install --upgrade --no-deps \
        --target "$tool/lib" --require-hashes --only-binary=:all: -r "$lock" || die "Atheris could not be installed."
    cp -- "$lock" "$tool/$lock"
fi
TIMEFORMAT=%U
export PYTHONPATH=$tool/lib${PYTHONPATH:+:$PYTHONPATH}
read -r -a targets <<<"${*:2}"
((${#targets[@]})) || mapfile -t targets < <("$venv/bin/python" test/fuzz/fuzz.py 2>"$tool/targets.log")
for target in "${targets[@]}"; do
    found=$tool/found/$target
    mkdir -p "$found"
    { time "$venv/bin/python" test/fuzz/fuzz.py "$target" "$found" -max_total_time="$seconds" \
        -artifact_prefix="$found/" -print_final_stats=1 >"$found.log" 2>&1 || failed+=("$target"); } 2>"$found.time"
    executed=$(grep -a '^stat::number_of_executed' "$found.log" || true)
    printf '%-12s %12s executions in %7s s of processor\n' "$target" "${executed##* }" "$(<"$found.time")"
done
((${#failed[@]} == 0)) || die "see $tool/found: ${failed[*]}"
