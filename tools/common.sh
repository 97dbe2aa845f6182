# What tools/setup, tools/run, tools/test and tools/gpu_check share. Sourced, never run.
# shellcheck shell=bash

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
jobs=${CMAKE_BUILD_PARALLEL_LEVEL:-$(nproc)}
# Debian's own has the packages that the tools need; another may come first on the PATH.
# Elsewhere that one will do.
# shellcheck disable=SC2034 # used where this is sourced
python=${MACHPOINT_PYTHON:-$(PATH=/usr/bin:$PATH type -P python3 || echo /usr/bin/python3)}

# Notes go to stderr: stdout belongs to the program that is run.
say() { printf 'machpoint: %s\n' "$*" >&2; }

fail() {
    say "$@"
    exit 1
}

# Asked for help, a script shows the comment at its top, and does nothing else.
for argument in "$@"; do
    [[ $argument == -h || $argument == --help ]] || continue
    sed -n '2,${/^#/!q;s/^# \{0,1\}//p}' "$0"
    exit
done

# CMake's search for HDF5 breaks there, and says that there is none.
[[ $root != *[[:space:]]* ]] || fail "\"$root\" contains a space; clone elsewhere"

# Runs a command and shows what it printed only when it fails.
quietly() {
    local log status=0
    log=$(mktemp)
    "$@" >"$log" 2>&1 </dev/null || status=$?
    if ((status != 0)); then
        cat "$log" >&2
        say "failed with status $status: $*"
    fi
    rm -f "$log"
    return "$status"
}

# alone COMMAND...: runs it while nothing else builds in this checkout. It must not call
# tools/setup, which does so, too.
alone() {
    mkdir -p "$root/build"
    (
        flock -n 8 || { say "waiting for another build" && flock 8; }
        "$@" 8>&- # what stays behind does not keep the lock
    ) 8>"$root/build/lock"
}

# build_in FOLDER PRESET "TARGET..." [CMake option]...: configures and builds targets in
# build/FOLDER.
build_in() {
    alone configure_and_build "$@"
}

configure_and_build() {
    local folder=$root/build/$1 preset=$2 targets
    read -ra targets <<<"$3"
    shift 3
    quietly cmake -S "$root" --preset "$preset" -B "$folder" \
        ${MACHPOINT_PYTHON:+-D "Machpoint_PYTHON=$MACHPOINT_PYTHON"} "$@" &&
        quietly cmake --build "$folder" --parallel "$jobs" --target "${targets[@]}"
}

# build PRESET TARGET [CMake option]...: the same in the folder of the preset.
build() {
    local preset=$1 target=$2
    shift 2
    say "building $target ($preset; minutes the first time)"
    build_in "$preset" "$preset" "$target" "$@"
}
