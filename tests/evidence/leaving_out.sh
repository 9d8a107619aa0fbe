#!/usr/bin/env bash
# What it costs to have the optional parts compiled in where a scene needs none of them: instructions of a build with
# OpenVDB, OSMesa, SuiteSparse and assimp against one without any (presets release and bare), by callgrind.
#   cmake --preset release && ninja -C build/release wry && cmake --preset bare && ninja -C build/bare wry
#   tests/evidence/leaving_out.sh > tests/evidence/leaving_out.csv
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT

# instructions PRESET words...
instructions() {
  local preset=$1
  shift
  valgrind --tool=callgrind --callgrind-out-file=/dev/null "build/$preset/wry" "$@" 2>&1 >/dev/null |
    sed -n 's/.*Collected : \([0-9]*\).*/\1/p'
}

echo "what,with,without,ratio"
row() {
  local name=$1 with without
  shift
  rm -rf "$scratch/with" "$scratch/without"
  with=$(instructions release "$@" ${OUT:+--out "$scratch/with"})
  without=$(instructions bare "$@" ${OUT:+--out "$scratch/without"})
  printf '%s,%s,%s,%s\n' "$name" "$with" "$without" "$(awk -v a="$with" -v b="$without" 'BEGIN { printf "%.4f", a / b }')"
}
row "start and --version" --version
OUT=yes
simulate=(--threads 1 --isa avx2 --quiet)
row "flexing_bar, 13 frames" simulate shots/flexing_bar.toml "${simulate[@]}" --set fem.linear_solver=pcg
row "closed_loop, 25 frames" simulate shots/closed_loop.toml "${simulate[@]}" --set fem.linear_solver=pcg --frames 1-25
row "column, 3 frames" simulate shots/column.toml "${simulate[@]}" --frames 1-3 --set mpm.cell_size=0.025
