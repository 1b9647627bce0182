#!/usr/bin/env bash
# Checks `hemicube bake volume --for three` against three.js, which npm fetches. Needs Node 18 or later, and npm.
#   tools/engines/three/run.sh [SCENE]
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
hemicube=${HEMICUBE:-$here/../../../target/release/hemicube}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cp "$here/check.mjs" "$work"
"$hemicube" bake volume "$@" -o "$work/volume.json" --uniform 5 --inside 1 -q
"$hemicube" bake volume "$@" -o "$work/probes.json" --uniform 5 --inside 1 -q --for three
node -e 'const fs = require("fs"); const v = JSON.parse(fs.readFileSync(process.argv[1]));
fs.writeFileSync(process.argv[2], JSON.stringify({ points: v.positions }))' "$work/probes.json" "$work/points.json"
"$hemicube" probe --volume "$work/volume.json" --points "$work/points.json" -o "$work/light.json" --interpolation trilinear --no-leak-guard -q
cd "$work"
npm install --silent --no-fund --no-audit three@0.187.0
node check.mjs probes.json light.json
