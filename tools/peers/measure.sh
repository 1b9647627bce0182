#!/usr/bin/env bash
# Measures what the guide (src/guide/measurements.md) says about error against time: two scenes, all methods and both peers, on this machine.
#
#   tools/peers/measure.sh DIR              some 20 minutes on two cores that have nothing else to do
#   tools/peers/measure.sh DIR --guide      the same, then puts the tables and charts into src/guide/measurements.md and assets/
#   tools/peers/measure.sh DIR --try        a few points of Cornell, once each, to see that everything is there
#
# HEMICUBE_SCENES is the folder of the scenes with their references (default ../shared/scenes): cornell and sponza, each with
# NAME.gltf and E_256x256.exr, whose layer b1 is the irradiance after one bounce. DIR gets a folder for each scene, with
# points.csv, charts and index.html, and peers.csv with the points of the peers. What is there already is not run again.
set -euo pipefail
usage() { sed -n '2,/^set /{/^#/s/^# \{0,1\}//p}' "$0"; }
case ${1:-} in '' | -*) usage; exit 2 ;; esac
out=$(realpath -m "$1")
what=${2:-}
case $what in '' | --guide | --try) ;; *) usage; exit 2 ;; esac
scenes=${HEMICUBE_SCENES:-../shared/scenes}

cd "$(dirname "$0")/../.."
hemicube=${HEMICUBE:-target/release/hemicube}
[ -n "${HEMICUBE:-}" ] || cargo build --release --quiet
mkdir -p "$out"

radiance() { # one setting of rpict: ambient divisions, super-samples, accuracy, resolution
  printf '%s\n' --radiance "{\"ad\": $1, \"as\": $2, \"aa\": $3, \"ar\": $4}"
}
mapfile -t quick < <(radiance 128 0 0.3 32)
mapfile -t usual < <(radiance 128 0 0.3 32; radiance 256 64 0.25 48; radiance 512 128 0.2 64)
mapfile -t careful < <(radiance 1024 256 0.15 128)

peers() { # scene, then flags
  local name=$1
  shift
  tools/peers/run.py "$scenes/$name/$name.gltf" --reference "$scenes/$name/E_256x256.exr" -o "$out/peers.csv" "$@"
}
ours() { # scene, then flags
  local name=$1
  shift
  "$hemicube" convergence "$scenes/$name/$name.gltf" --reference "$scenes/$name/E_256x256.exr" --layer b1 -o "$out/$name" \
    --peers "$out/peers.csv" "$@"
}

if [ "$what" = --try ]; then
  peers cornell --repeats 1 "${quick[@]}" --mitsuba '{"spp": 16}'
  ours cornell --repeats 1 --methods splatting,ward,path --accuracy 0.6,0.3 --rays 256 --spp 4,16
  tools/peers/table.py "$out/cornell/points.csv"
  exit 0
fi

peers cornell "${usual[@]}" "${careful[@]}" --mitsuba '{"spp": 16}' --mitsuba '{"spp": 64}' --mitsuba '{"spp": 256}'
ours cornell --spp 4,16,64,256

# A point of Sponza takes ten times as long: once each, fewer of the slow, settings of splatting one at a time.
peers sponza "${usual[@]}" --mitsuba '{"spp": 16}' --mitsuba '{"spp": 64}' --mitsuba '{"spp": 256}'
splatting() { ours sponza --repeats 1 --methods splatting "$@"; }
splatting --accuracy 0.6,0.3,0.2 --capture compute --capture-size 16,32 --gradients both
splatting --accuracy 0.3 --capture hemicube,plane --capture-size 32 --gradients both
splatting --accuracy 0.3 --capture compute --capture-size 32 --gradients none
ours sponza --repeats 1 --methods ward --accuracy 0.3 --rays 256,1024
ours sponza --repeats 1 --methods path --spp 4,16,64

if [ "$what" = --guide ]; then
  for name in cornell sponza; do cp "$out/$name/error-cpu.svg" "assets/error-$name.svg"; done
  tools/peers/table.py "$out/cornell/points.csv" "$out/sponza/points.csv" --into src/guide/measurements.md
else
  tools/peers/table.py "$out/cornell/points.csv" "$out/sponza/points.csv"
fi
