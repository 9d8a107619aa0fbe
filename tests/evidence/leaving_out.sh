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

echo "what,with,without,ratio,ratio_after_start"
start_with=$(instructions release --version)
start_without=$(instructions bare --version)
awk -v a="$start_with" -v b="$start_without" 'BEGIN { printf "start and --version,%.0f,%.0f,%.4f,\n", a, b, a / b }'
row() {
  local name=$1 with without
  shift
  rm -rf "$scratch/with" "$scratch/without"
  with=$(instructions release "$@" --out "$scratch/with")
  without=$(instructions bare "$@" --out "$scratch/without")
  awk -v name="$name" -v a="$with" -v b="$without" -v c="$start_with" -v d="$start_without" \
    'BEGIN { printf "%s,%.0f,%.0f,%.4f,%.5f\n", name, a, b, a / b, (a - c) / (b - d) }'
}
simulate=(--threads 1 --isa avx2 --quiet)
row "flexing_bar, 13 frames" simulate shots/flexing_bar.toml "${simulate[@]}" --set fem.linear_solver=pcg
row "closed_loop, 5 frames" simulate shots/closed_loop.toml "${simulate[@]}" --set fem.linear_solver=pcg --frames 1-5
row "column, 2 frames" simulate shots/column.toml "${simulate[@]}" --frames 1-2 --set mpm.cell_size=0.03
