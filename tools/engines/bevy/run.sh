#!/usr/bin/env bash
# Renders balls in a volume of `hemicube bake volume --for bevy` with Bevy, without a window, and compares each pixel with the file.
# The first run builds Bevy; some minutes on two cores.
#   tools/engines/bevy/run.sh [SCENE]
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
hemicube=${HEMICUBE:-$here/../../../target/release/hemicube}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
"$hemicube" bake volume "$@" -o "$work/volume.ktx2" --for bevy --uniform 9,8,7
cargo run --quiet --manifest-path "$here/Cargo.toml" -- "$work/volume.ktx2"
