# What tools/setup, tools/run and tools/test share. Sourced, never run.
# shellcheck shell=bash

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
jobs=$(nproc)

# Notes go to stderr: stdout belongs to the program that is run.
say() { printf 'machpoint: %s\n' "$*" >&2; }

fail() {
    say "$@"
    exit 1
}

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

# build PRESET TARGET [CMake option]...: configures and builds one target.
build() {
    local preset=$1 target=$2
    shift 2
    say "building $target ($preset; minutes the first time)"
    quietly cmake -S "$root" --preset "$preset" "$@" &&
        quietly cmake --build "$root/build/$preset" --target "$target" \
            --parallel "$jobs"
}
