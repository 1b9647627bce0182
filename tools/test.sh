#!/usr/bin/env bash
# Everything a change must pass: formatting, lints, documentation and tests, warnings denied. Sets the machine up first.
#
#   tools/test.sh             all of it
#   tools/test.sh FILTER...   the same; arguments go to the test programs (for example: --skip slow)
#
# It uses the release profile throughout: dependencies compile once, and software Vulkan is far too slow for a debug build.
set -euo pipefail
cd "$(dirname "$0")/.."

step() { printf '\n== %s\n' "$*"; "$@"; }

# Each test that draws starts a software Vulkan device with a thread per core, so more tests at once than
# this gain nothing and cost memory.
cores=$(nproc 2>/dev/null || echo 2)
export RUST_TEST_THREADS=${RUST_TEST_THREADS:-$((cores < 4 ? cores : 4))}
export RUST_BACKTRACE=${RUST_BACKTRACE:-1}

step tools/setup.sh --test
step cargo fmt --check
step cargo clippy --release --locked --all-targets -- -D warnings
RUSTDOCFLAGS="-D warnings" step cargo doc --release --locked --no-deps
step cargo test --release --locked -- "$@"
printf '\nall passed in %d s\n' "$SECONDS"
