#!/usr/bin/env bash
# Renders random small scenes and compares the energy of their light with the path tracer's: a line for each, then the ten worst.
# Fails where one is off by more than 5 % and three standard errors.
#
#   tools/fuzz_light.sh [SCENES] [FIRST] [FOLDER]
#
#   SCENES  how many, 1000 unless said otherwise (some 3 s each on two cores)
#   FIRST   seed of the first one, 0; the same seed gives the same scene
#   FOLDER  writes SEED-direct.png and SEED-indirect.png there: what is, left, and what should be, right
#
# What it finds is reduced to a test beside those of its kind (tests/it). tools/test.sh runs the first ten scenes.
set -euo pipefail
cd "$(dirname "$0")/.."

export HEMICUBE_FUZZ_SCENES=${1:-1000} HEMICUBE_FUZZ_FIRST=${2:-0}
if [ $# -ge 3 ]; then
    mkdir -p "$3"
    HEMICUBE_FUZZ_PICTURES=$(cd "$3" && pwd)
    export HEMICUBE_FUZZ_PICTURES
fi
cargo test --release --locked --test it -- light_fuzz:: --nocapture
