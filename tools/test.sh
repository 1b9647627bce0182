#!/usr/bin/env bash
# Runs every check that a change must pass: formatting, lints, documentation and tests, with warnings as errors.
# Sets the machine up first.
#
#   tools/test.sh             all checks
#   tools/test.sh FILTER...   the same; the arguments go to the test programs (for example: --skip references)
#
# One profile for all, so that dependencies compile once: `test-fast`, which is the release profile with the crate's
# assertions and overflow checks. The command that the tests run has them too.
set -euo pipefail
cd "$(dirname "$0")/.."

step() { printf '\n== %s\n' "$*"; "$@"; }

# Each test that draws starts a software Vulkan device with a thread per core, so more tests at once than
# this gain nothing and cost memory.
cores=$(nproc 2>/dev/null || echo 2)
export RUST_TEST_THREADS=${RUST_TEST_THREADS:-$((cores < 4 ? cores : 4))}
export RUST_BACKTRACE=${RUST_BACKTRACE:-1}

temporary=$(mktemp -d)
trap 'rm -rf "$temporary"' EXIT
# Tests whose files are absent add a line each; where HEMICUBE_SCENES or ../shared/scenes is there, an absent file fails.
export HEMICUBE_NOT_CHECKED=$temporary/not-checked
touch "$HEMICUBE_NOT_CHECKED"

profile="--profile test-fast --locked"
step tools/setup.sh --test
step cargo fmt --check
# shellcheck disable=SC2086 # $profile is words
step cargo clippy $profile --all-targets -- -D warnings
# shellcheck disable=SC2086
RUSTDOCFLAGS="-D warnings" step cargo doc $profile --no-deps
# shellcheck disable=SC2086
step cargo test $profile --doc -- "$@"
printf '\nchecked and documented in %d s; now the tests\n' "$SECONDS"
# shellcheck disable=SC2086
step cargo test $profile --lib --bins --test it -- "$@" | tee "$temporary/log"

# The last line is cargo's own, of the integration tests; with what was not checked behind it, if there is anything.
if [ -s "$HEMICUBE_NOT_CHECKED" ]; then
    printf '\nnot checked:\n' && sort -u "$HEMICUBE_NOT_CHECKED"
    result=$(grep '^test result: ' "$temporary/log" | tail -n 1)
    reasons=$(sed 's/^[^ ]*: //' "$HEMICUBE_NOT_CHECKED" | sort -u | paste -sd ';' | sed 's/;/; /g')
    printf '\n%s; %d tests not checked: %s\n' "$result" "$(cut -d ' ' -f 1 "$HEMICUBE_NOT_CHECKED" | sort -u | wc -l)" "$reasons"
fi
