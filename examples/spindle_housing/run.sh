#!/bin/sh
# Finite elements for real: writes the deck of a spindle housing, runs CalculiX, and chooses temperature sensors.
#   run.sh [folder]      results go to the folder (default: spindle_housing in the present one)
# CCX, MM and SPINDLE_HOUSING name other programs than those that are found.
set -eu
folder=${1:-spindle_housing}
ccx=${CCX:-ccx}
mm=${MM:-rosrun measuring_machine mm}
tool=${SPINDLE_HOUSING:-rosrun measuring_machine spindle_housing}

fail() { echo "run.sh: error: $1" >&2; exit 2; }

command -v "$ccx" >/dev/null 2>&1 ||
  fail "CalculiX ('$ccx') is not installed: apt install calculix-ccx, or set CCX; mm sensors works on any CSV without it"
mkdir -p "$folder"
rm -f "$folder"/housing.dat "$folder"/housing.csv
$tool deck "$folder/housing.inp"
echo "ccx: 100 steps of 72 s, log in $folder/ccx.log"
(cd "$folder" && "$ccx" housing) >"$folder/ccx.log" 2>&1 ||
  fail "ccx stopped with an error: $(grep -m1 -i 'error' "$folder/ccx.log" || echo "see $folder/ccx.log")"
[ -s "$folder/housing.dat" ] || fail "ccx wrote no results; see $folder/ccx.log"
$tool convert "$folder/housing.dat" "$folder/housing.csv"

$tool positions "$folder/positions.csv"

for estimator in ksg histogram correlation; do
  echo
  echo "== $estimator"
  choose=information
  if [ $estimator = ksg ]; then choose=held_out; fi
  $mm sensors "$folder/housing.csv" --target nose_um --max 2 --estimator $estimator --choose $choose \
    --picture "$folder/$estimator.svg" --positions "$folder/positions.csv"
done
echo
echo "== by the error expected on other duties and on held-out blocks of time, the default"
$mm sensors "$folder/housing.csv" --target nose_um --max 2
echo
echo "== histogram, corrected by circular shift"
$mm sensors "$folder/housing.csv" --target nose_um --max 2 --estimator histogram --correction circular_shift
echo
echo "SENSORS found on its housing: single 0.20 L from the front bearing; pair 0.20 L and 0.24 L."
