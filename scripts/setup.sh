#!/usr/bin/env bash
# Makes .venv in the checkout and installs the locked dependencies and the packages of src/ into it.
#
#   scripts/setup.sh         what running needs
#   scripts/setup.sh test    also what only the tests need (pytest, the libraries that they compare with, and, as
#                            root on Debian, Chromium)
#   scripts/setup.sh dev     what running needs, and the check tools (ruff, mypy, import-linter, pre-commit, colcon)
#   scripts/setup.sh docs    what running needs, and the tools that build the pages (mkdocs-material, mkdocstrings)
#
# PYTHON names the interpreter (CPython 3.10 to 3.14 on x86-64 Linux; default: that of .venv, or python3).
# A sourced ROS 2 Jazzy is used in place of the ROS wheels. A second run does nothing and starts no python.
# The other scripts source this file, so that they inherit the environment that it cleans.
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd -P)
venv=$root/.venv
log=$venv/pip.log
step_pid=""
step_output=""
step_text=""

say() { printf 'setup: %s\n' "$*" >&2; }

die() {
    printf 'setup: error: %s\n' "$*" >&2
    exit 1
}

# --- the interpreter -------------------------------------------------------------------------------

find_python() { # -> python, an absolute path
    local wanted=${PYTHON:-} made_with=""
    [[ ! -r $venv/.python ]] || made_with=$(<"$venv/.python")
    # Who chose an interpreter once need not name it again; a sourced ROS goes with python3.
    [[ -n $wanted || -n ${ROS_DISTRO:-} || ! -x $made_with ]] || wanted=$made_with
    wanted=${wanted:-python3}
    python=$(type -P -- "$wanted") ||
        die "$wanted was not found; install it (Debian, Ubuntu: sudo apt install python3) or set PYTHON."
    case $python in /*) ;; *) python=$PWD/$python ;; esac
    # With our own .venv activated, python3 is a link into what may have to be remade.
    case $python in "$venv"/*) python=${made_with:-$python} ;; esac
}

check_platform() {
    [[ $(uname -s) == Linux && $(uname -m) == x86_64 ]] ||
        die "this is $(uname -s) on $(uname -m); the ROS 2 wheels exist only for Linux on x86_64."
}

check_python() {
    local facts implementation version bits
    facts=$("$python" -c 'import platform, struct
print("%s %s %d" % (platform.python_implementation(), platform.python_version(), struct.calcsize("P") * 8))' 2>&1) ||
        die "$python is no Python that runs: ${facts##*$'\n'}"
    read -r implementation version bits <<<"$facts"
    [[ $implementation == CPython && $version =~ ^3\.1[0-4]\. && $bits == 64 ]] ||
        die "$python is $implementation $version ($bits bit); CPython 3.10 to 3.14 (64 bit) is needed:" \
            "set PYTHON to such an interpreter."
    "$python" -c 'import venv, ensurepip' 2>/dev/null ||
        die "$python has no venv and ensurepip modules;" \
            "install them (Debian, Ubuntu: sudo apt install python${version%.*}-venv) and run this again."
}

# --- ROS: a sourced Jazzy, or the wheels --------------------------------------------------------------

check_distro() {
    [[ -z ${ROS_DISTRO:-} || $ROS_DISTRO == jazzy ]] ||
        die "ROS 2 $ROS_DISTRO is sourced here, but this project needs Jazzy:" \
            "use a terminal in which no ROS, or Jazzy, is sourced."
}

find_sourced_ros() { # -> ros_path, the directory from which python would take rclpy; starts no python
    local entry entries
    ros_path=""
    [[ ${ROS_DISTRO:-} == jazzy ]] || return 0
    ros_path=unlisted # not on PYTHONPATH; the interpreter may bring its own
    IFS=: read -ra entries <<<"${PYTHONPATH:-}"
    for entry in "${entries[@]}"; do
        [[ -f $entry/rclpy/__init__.py ]] || continue
        ros_path=$entry
        return 0
    done
}

find_mode() { # -> mode: jazzy or wheels
    mode=wheels
    [[ -n $ros_path ]] || return 0
    if "$python" -c 'import numpy; from rclpy.node import Node' 2>/dev/null; then
        mode=jazzy
    else
        say "ROS_DISTRO is jazzy, but $python cannot import rclpy; the ROS wheels are used instead."
    fi
}

# A half-sourced ROS, or another environment of wheels that started us, would shadow the wheels.
clean_environment() {
    unset PYTHONHOME
    unset PYTHONDONTWRITEBYTECODE # pip compiles nothing: who imports a module first keeps it for the others
    [[ $mode == wheels ]] || return 0
    unset PYTHONPATH LD_LIBRARY_PATH AMENT_PREFIX_PATH ROS_DISTRO _ROS_WHEELS_BOOTSTRAP_COMPLETE
    [[ ${RMW_IMPLEMENTATION:-rmw_fastrtps_cpp} == rmw_fastrtps_cpp ]] && return 0
    say "RMW_IMPLEMENTATION=$RMW_IMPLEMENTATION is ignored: the ROS wheels bring rmw_fastrtps_cpp only."
    unset RMW_IMPLEMENTATION
}

# --- the stamp: what .venv was made from ------------------------------------------------------------------

sums_of() { (cd "$root" && sha256sum -- "$@"); }

compute_keys() { # -> run_key, test_key, dev_key, docs_key
    run_key="checkout $root
python $(readlink -f -- "$python") ${PYENV_VERSION:-}
ros $ros_path
$(sums_of pyproject.toml requirements.lock requirements-jazzy.lock)"
    test_key="$run_key
$(sums_of requirements-test.lock requirements-jazzy-test.lock)"
    dev_key="$run_key
$(sums_of requirements-dev.lock)"
    docs_key="$run_key
$(sums_of requirements-docs.lock)"
}

is_done() { # is_done run|test|dev|docs
    local key=${1}_key
    [[ -x $venv/bin/python && -r $venv/.stamp-$1 && -r $venv/.mode && $(<"$venv/.stamp-$1") == "${!key}" ]]
}

# --- installing -----------------------------------------------------------------------------------------

stop_step() { # stop_step EXIT_CODE: no pip is left behind, whichever signal came
    trap '' INT TERM HUP
    [[ -z $step_pid ]] || kill -TERM -- "-$step_pid" 2>/dev/null || true
    [[ -z $step_pid ]] || wait "$step_pid" 2>/dev/null || true
    [[ -z $step_output ]] || rm -f -- "$step_output"
    say "interrupted; the next run starts again."
    exit "$1"
}

disk_is_full() { # python -m venv keeps its reason to itself
    local free_kib
    free_kib=$(df --output=avail -k -- "$root" | tail -n 1)
    ((free_kib < 10240))
}

explain_failure() { # explain_failure WHAT OUTPUT
    local output=$2 kept="its log is $log"
    printf '%s\n' "$output" >>"$log" 2>/dev/null || kept="its last words: ${output##*$'\n'}"
    if [[ $output == *"No space left on device"* || $output == *"Disk quota"* ]] || disk_is_full; then
        die "the disk is full: .venv needs 0.7 GB in $root, 1.2 GB with the tests' part and 1.3 GB with the check tools;" \
            "downloads go to ${TMPDIR:-/tmp}; make room and run this again."
    elif [[ $output =~ NewConnectionError|Temporary\ failure|Name\ or\ service|ConnectTimeout|ReadTimeout ||
        $output =~ refused|unreachable|ProxyError|Max\ retries|Connection\ (aborted|broken)|SSLError ]]; then
        die "no network: pip cannot reach its package index ($kept)."
    fi
    die "$1 failed ($kept)."
}

run_quietly() { # run_quietly COMMAND... -> step_text, all it printed; interruptible, and so never in a subshell
    local status=0
    step_output=$(mktemp "${TMPDIR:-/tmp}/forest-crane-setup.XXXXXX") ||
        die "cannot write to ${TMPDIR:-/tmp}: is the disk full?"
    set -m # a process group of its own, so that what the step starts can be stopped with it
    "$@" >"$step_output" 2>&1 </dev/null &
    step_pid=$!
    set +m
    wait "$step_pid" || status=$?
    step_pid=""
    step_text=$(<"$step_output")
    rm -f -- "$step_output"
    step_output=""
    return "$status"
}

run_step() { # run_step WHAT COMMAND...: its output is kept only to explain a failure
    local what=$1
    shift
    run_quietly "$@" || explain_failure "$what" "$step_text"
}

pip_install() { # pip_install WHAT ARGUMENTS...
    local what=$1
    shift
    # Python compiles what is imported, when it is: pip would compile everything, tests of libraries included.
    run_step "$what" "$venv/bin/python" -m pip --disable-pip-version-check --no-input \
        install --no-compile --no-deps "$@"
}

pip_install_lock() { # pip_install_lock ""|-test
    local lock=requirements$1.lock
    [[ $mode == wheels ]] || lock=requirements-jazzy$1.lock
    pip_install "installing $lock" --require-hashes --only-binary=:all: -r "$root/$lock"
}

make_venv() {
    local options=()
    [[ $mode == wheels ]] || options=(--system-site-packages)
    if [[ -e $venv ]]; then
        [[ -e $venv/.python ]] || die ".venv exists but was not made by scripts/setup.sh: move it away first."
        rm -rf -- "$venv"
    fi
    mkdir -- "$venv" 2>/dev/null || die "cannot write to $root: is it read-only, or the disk full?"
    printf '%s\n' "$python" >"$venv/.python" || die "cannot write to $venv: is the disk full?"
    say "Installing into .venv (first time only, about a minute) …"
    run_step "making .venv" "$python" -m venv "${options[@]}" "$venv"
}

compile_laws() { # once, for the nodes, which never compile; studies do by themselves, so nothing is fatal
    local module line
    say "Compiling plant, controller and driver (some seconds) …"
    for module in forest_sim.compiled forest_control.compiled; do
        run_quietly "$venv/bin/python" -m "$module" || {
            printf '%s\n' "$step_text" >>"$log" 2>/dev/null || true
            say "$module made no machine code, so its nodes run interpreted (${step_text##*$'\n'})."
            continue
        }
        while read -r line; do # where each lies; and, if it was made anew, why
            [[ $line == /* ]] || say "$line"
        done <<<"$step_text"
    done
}

install_run() {
    make_venv
    pip_install_lock ""
    pip_install "installing the packages of src/" --no-build-isolation -e "$root"
    compile_laws
    printf '%s\n' "$mode" >"$venv/.mode"
    printf '%s\n' "$run_key" >"$venv/.stamp-run"
    say "Done."
}

# The page's tests drive a real browser. Whoever may install packages gets one; others are told.
install_browser() {
    local name packages
    for name in chromium chromium-browser google-chrome; do
        ! type -P "$name" >/dev/null || return 0
    done
    if ((EUID == 0)) && type -P apt-get >/dev/null; then
        run_step "apt-get update" apt-get --quiet update
        packages=(chromium)
        ! apt-cache show chromium-headless-shell >/dev/null 2>&1 || packages+=(chromium-headless-shell)
        run_step "installing chromium" env DEBIAN_FRONTEND=noninteractive \
            apt-get --quiet --yes install --no-install-recommends "${packages[@]}"
    else
        say "no Chromium was found, so the tests of the operator's page are skipped:" \
            "install it (Debian: sudo apt install chromium)."
    fi
}

install_test() {
    say "Installing what only the tests need …"
    pip_install_lock -test
    install_browser
    printf '%s\n' "$test_key" >"$venv/.stamp-test"
    say "Done."
}

install_dev() {
    say "Installing the check tools …"
    # EmPy, of which colcon makes its environment scripts, is published as source only.
    pip_install "installing requirements-dev.lock" --require-hashes --only-binary=:all: --no-binary=empy \
        --no-build-isolation --use-pep517 -r "$root/requirements-dev.lock"
    printf '%s\n' "$dev_key" >"$venv/.stamp-dev"
    say "Done."
}

install_docs() {
    say "Installing the tools that build the pages …"
    pip_install "installing requirements-docs.lock" --require-hashes --only-binary=:all: -r "$root/requirements-docs.lock"
    printf '%s\n' "$docs_key" >"$venv/.stamp-docs"
    say "Done."
}

install() { # install run|test|dev|docs
    local lock_fd
    check_platform
    # One setup at a time; the lock goes with the process that holds it, however that ends.
    exec {lock_fd}<"$root/pyproject.toml"
    flock -n "$lock_fd" || { say "another setup is running here; waiting for it …" && flock "$lock_fd"; }
    trap 'stop_step 130' INT
    trap 'stop_step 143' TERM
    trap 'stop_step 129' HUP
    if ! is_done run; then
        check_python
        find_mode
        clean_environment
        install_run
    fi
    mode=$(<"$venv/.mode")
    clean_environment
    is_done "$1" || "install_$1"
    trap - INT TERM HUP
    exec {lock_fd}<&-
}

main() { # main [run|test|dev|docs]
    case ${1:-run} in
    run | test | dev | docs) ;;
    -h | --help) sed -n '2,/^set /{/^set /d;s/^# \{0,1\}//;p}' "${BASH_SOURCE[0]}" && exit 0 ;;
    *) die "unknown argument '$1'; allowed: test, dev, docs (or nothing)." ;;
    esac
    check_distro
    find_python
    find_sourced_ros
    compute_keys
    is_done "${1:-run}" || install "${1:-run}"
    mode=$(<"$venv/.mode")
    clean_environment
}

main "$@"
