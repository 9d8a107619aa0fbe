#!/bin/bash
# The deflection of a thin strip on ever finer cells: tests/evidence/bending_strip.sh WRY > tests/evidence/bending_strip.csv
set -euo pipefail
wry=${1:-build/release/wry}
here=$(dirname "$0")
out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT
tip() {
  "$wry" simulate "$here/bending_strip.toml" --out "$out/run" --fresh --quiet --threads 1 "$@"
  tail -n 1 "$out/run/measure.csv" | cut -d , -f 3
}
echo "element,split,cells,edge_m,tip_m"
for cells in 10,2,4 13,2,5 20,2,8 40,2,16 80,2,32; do
  edge=$(awk "BEGIN { print 0.6 / ${cells%%,*} }")
  for split in kuhn symmetric; do
    echo "tet4,$split,\"$cells\",$edge,$(tip --set "body.strip.cells=[$cells]" --set "body.strip.split=$split")"
  done
done
for cells in 10,1,4 20,1,8 40,2,16; do
  edge=$(awk "BEGIN { print 0.6 / ${cells%%,*} }")
  echo "tet10,kuhn,\"$cells\",$edge,$(tip --set "body.strip.cells=[$cells]" --set body.strip.element=tet10 \
    --set material.skin.model=micropolar --set material.skin.length_scale=0 --set material.skin.couple_modulus_ratio=1)"
done
