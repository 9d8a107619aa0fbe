#!/bin/sh
# Error against run time of the integrators: runs the ladder of shots/flexing_bar.toml with each and writes
# accuracy_integrators.csv into this folder, to be drawn by plot_accuracy.py.
# Usage, in the project's folder: tests/evidence/accuracy.sh PATH_OF_WRY SCRATCH_FOLDER
set -e
wry=$1
scratch=$2
table=tests/evidence/accuracy_integrators.csv

rm -f $table
for integrator in backward-euler bdf2 sdirk2; do
  "$wry" accuracy shots/flexing_bar.toml --set fem.integrator=$integrator --jobs 1 --threads 1 --out "$scratch/$integrator" --quiet
  csv="$scratch/$integrator/accuracy/accuracy.csv"
  [ -f $table ] || sed -n "1s/^/integrator,/p" "$csv" > $table
  sed -n "2,\$s/^/$integrator,/p" "$csv" >> $table
done
