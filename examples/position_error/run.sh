#!/bin/sh
# The experiment of DFNN: a mill warms up, its x axis is measured at 11 positions, a network learns the error.
#   run.sh [folder] [--law linear|saturating|bending] [--seed N] [--days 1|2|3]
# Results go to the folder (default: position_error).
# MM and POSITION_ERROR name other programs than those that are found.
set -eu
folder=position_error
case ${1:-} in "" | -*) ;; *) folder=$1; shift ;; esac
mm=${MM:-rosrun measuring_machine mm}
tool=${POSITION_ERROR:-rosrun measuring_machine position_error}
here=$(CDPATH= cd -- "$(dirname -- "$0")" && pwd)

$tool table "$@"
$tool simulate "$folder" "$@"
for run in training test; do
  $mm import "$folder/$run.csv" --machine three_axis -o "$folder/$run.bag"
done
for network in dfnn ridge; do
  echo
  echo "== $network, learned from training.bag"
  $mm calibrate "$folder/training.bag" --model "$here/$network.yaml" --method least_squares -o "$folder/$network.calibration"
  echo
  echo "== $network, on the other day"
  $mm compare "$folder/test.bag" --calibration "$folder/$network.calibration"
  $mm report "$folder/training.bag" --calibration "$folder/$network.calibration" -o "$folder/$network.html"
done
