#!/bin/sh
# Error against run time of contact, particles, grains and pictures: writes errors_*.csv into this folder, to be drawn by
# plot_errors.py; docs/evidence.md says what is in them.
# Usage, in the project's folder: tests/evidence/errors.sh PATH_OF_WRY FOLDER_OF_TEST_PROGRAMS SCRATCH_FOLDER
set -e
wry=$1
tests=$2
scratch=$3
here=tests/evidence

echo cells,force_N,radius_m,closed_form_m,error,cpu_s > $here/errors_contact.csv
"$tests/test_fem" --gtest_filter='Hertz*' |
  sed -n 's/^\([0-9]*\) cells: force \(.*\) N, radius \(.*\) m, closed form \(.*\) m, error \(.*\) %, \(.*\) s$/\1 \2 \3 \4 \5 \6/p' |
  awk '{ printf "%s,%s,%s,%s,%g,%s\n", $1, $2, $3, $4, $5 / 100, $6 }' >> $here/errors_contact.csv

"$tests/bench/bench_mpm_grain_steps" > $here/errors_grains.csv

study() { # NAME, table of the study, then what wry accuracy is told
  name=$1
  table=$2
  shift 2
  "$wry" accuracy "$@" --jobs 1 --threads 1 --out "$scratch/$name" --quiet
  cp "$scratch/$name/accuracy/$table" $here/errors_$name.csv
}
study column_cell accuracy.csv shots/column.toml --frames 1-13 --set 'accuracy."mpm.cell_size"=[0.033,0.025,0.02,0.0142]' \
  --set 'accuracy.reference={ "mpm.cell_size" = 0.01 }' --set mpm.precision=f64
study column_ppc accuracy.csv shots/column.toml --frames 1-13 --set mpm.cell_size=0.02 \
  --set 'accuracy."body.column.particles_per_cell"=[1,2,4,8]' --set 'accuracy.reference={ "body.column.particles_per_cell" = 27 }'
study column_precision accuracy.csv shots/column.toml --frames 1-13 --set mpm.cell_size=0.02 \
  --set 'accuracy."mpm.precision"=["f32"]' --set 'accuracy.reference={ "mpm.precision" = "f64" }'
study samples pictures.csv shots/bunny.toml --set body.bunny.resolution=0.12 --frames 6 --set 'render.size=[960,540]' --set accuracy.repeats=3 \
  --set 'accuracy."render.samples"=[1,2,4,8,16,32,64]' --set 'accuracy.reference={ "render.samples" = 256 }'
