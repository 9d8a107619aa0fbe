#!/bin/sh
# The extreme suite: runs every case of the three lists (solids, contact, particles) and writes a row for each into
# extremes.csv in this folder; prints the table of docs/stability.md.
# Usage, in the project's folder: tests/evidence/extremes.sh FOLDER_OF_TEST_PROGRAMS [long]
set -e
tests=$1
table=$PWD/tests/evidence/extremes.csv
rm -f "$table"
WRY_EXTREMES_TABLE=$table
export WRY_EXTREMES_TABLE
"$tests/test_fem" --gtest_brief=1 --gtest_filter='*SolidExtreme*:*ContactExtremes*:*FastBox*:*Erleben*:FemContact.ABlockOnASlope*' >&2
[ "$2" = long ] && "$tests/test_fem_long" --gtest_brief=1 --gtest_filter='TwistedMat*' >&2
"$tests/test_mpm" --gtest_brief=1 --gtest_filter='Extremes.*:TurnedScene*:MatterKernels.AFlattened*:MatterKernels.AnInverted*:MatterFacts.FibresAlong*' >&2
sed -i '1i list,case,outcome,steps,newton_iterations,cuts,worst_residual,said' "$table"
python3 - "$table" <<'TABLE'
import csv, sys
print("| list | case | outcome | steps | Newton iterations | cuts | worst residual |")
print("|---|---|---|---|---|---|---|")
for row in csv.DictReader(open(sys.argv[1])):
    said = row["said"].split(" at dt")[0]
    outcome = row["outcome"] + (": " + (said if len(said) < 110 else said[:107] + "...") if said else "")
    print("| {list} | {case} | {0} | {steps} | {newton_iterations} | {cuts} | {worst_residual} |".format(outcome, **row))
TABLE
