#!/usr/bin/env bash
# `mm import` as a user types it: exit status, one line on standard error, nothing half-written.
set -u
source "$(dirname "${BASH_SOURCE[0]}")/told.sh"
mm="${MM:?path of mm}"
work="$(mktemp -d)"
trap 'rm -rf "$work"' EXIT
cd "$work"

# refused <name> <words in the message> <arguments of mm …>
refused() {
  local name="$1" words="$2" status=0
  shift 2
  "$mm" "$@" >out 2>err || status=$?
  check "$name: status 2" [ "$status" -eq 2 ]
  check "$name: one line" [ "$(wc -l <err)" -eq 1 ]
  check "$name: says '$words'" grep -q -- "^mm: error: .*$words" err
  check "$name: nothing written" [ ! -e s.bag ]
}

cat >plate.yaml <<'Y'
name: plate
pose: free
balls:
  - {name: b0, centre_mm: [0, 0, 0], radius_mm: 4}
Y
printf 'time_s,x_mm,y_mm,z_mm,feature\n0,5,0,0,b0\n1,0,5,0,b0\n' >good.csv
printf 'time_s,x_mm,feature,spindel\n0,5,b0,1\n' >column.csv
printf 'time_s,x_mm,feature\n0,nan,b0\n' >nan.csv
printf 'time_s,x_mm,feature\n' >empty.csv
sed 's/radius_mm: 4/radius_mm: -4/' plate.yaml >negative.yaml
sed 's/pose:/psoe:/' plate.yaml >key.yaml

refused 'unknown column' 'column.csv:1: .*spindel' import column.csv --artifact plate.yaml --machine three_axis -o s.bag
printf 'time_s,x_mm,feature\n0,one,b0\n1,2,b0\n2,two,b9\n' >faults.csv
"$mm" import faults.csv --artifact plate.yaml --machine three_axis -o s.bag >out 2>err
check 'three faults: status 2' [ $? -eq 2 ]
check 'three faults: a line each' [ "$(grep -c '^mm: error: faults.csv:[24]: ' err)" -eq 3 ]
check 'three faults: nothing written' [ ! -e s.bag ]
printf 'Zeit;Pos;feature\n0;1,5;b0\n' >foreign.csv
refused 'what cannot be known' "columns: {Pos: " import foreign.csv --artifact plate.yaml --machine three_axis -o s.bag
check 'what was understood is shown all the same' grep -q 'ball or point touched' out
check 'a note names its remedy, in letters' sh -c "grep -q 'columns: {Zeit: time_ms}' out && ! grep -qP '[\x01-\x08]' out err"
printf 'Zeit [s];X [mm];\033[31mred;Abweichung X [um]\n0;1;\033]0;t\007;2\n1;2;3;\033c\n' >steers.csv
"$mm" import steers.csv --machine three_axis --preview >out 2>err
check 'what steers a terminal: status 2' [ $? -eq 2 ]
check 'what steers a terminal: is not printed' sh -c "grep -q 'red' out && ! grep -qP '[\x01-\x08\x0b-\x1f\x7f]' out err"
awk 'BEGIN { for (i = 0; i < 100000; ++i) printf "%sn%d", i ? "," : "", i; print ""; for (i = 0; i < 100000; ++i) printf "%s1.5", i ? "," : ""; print "" }' >wide.csv
refused 'a wide file' 'wide.csv:1: 100000 columns, at most 2000' import wide.csv --machine three_axis -o s.bag
printf 'Zeit;Pos;x\n0;1,5;2\n' >foreign.csv
refused 'a preview that should write' 'omit -o' import foreign.csv --machine three_axis --preview -o s.bag
refused 'NaN' "nan.csv:2: .*'x_mm'" import nan.csv --artifact plate.yaml --machine three_axis -o s.bag
refused 'empty session' 'empty.csv' import empty.csv --artifact plate.yaml --machine three_axis -o s.bag
refused 'missing artifact' '--artifact' import good.csv --machine three_axis -o s.bag
refused 'missing file' 'plate2.yaml' import good.csv --artifact plate2.yaml --machine three_axis -o s.bag
refused 'negative radius' 'negative.yaml:4: .*above 0' import good.csv --artifact negative.yaml --machine three_axis -o s.bag
refused 'unknown key' "key.yaml:2: .*did you mean 'pose'" import good.csv --artifact key.yaml --machine three_axis -o s.bag
refused 'unknown machine' 'four_axis' import good.csv --artifact plate.yaml --machine four_axis -o s.bag
refused 'unknown option' '--machin' import good.csv --artifact plate.yaml --machin three_axis -o s.bag
refused 'unknown command' "did you mean 'import'" imprt good.csv
(ulimit -f 1; refused 'file-size limit' 's.bag: cannot be written' import good.csv --artifact plate.yaml --machine three_axis -o s.bag)
check 'nothing temporary is left' [ -z "$(find . -name '*.part*')" ]

"$mm" import good.csv --artifact plate.yaml --machine three_axis -o s.bag >out 2>err
check 'a good file: status 0' [ $? -eq 0 ]
check 'a good file: nothing on standard error' [ ! -s err ]
check 'a good file: says what it read' grep -q '2 contacts' out
check 'a good file: rosbag reads it' sh -c 'rosbag info s.bag | grep "/probe/contact *2 msgs" >/dev/null'
printf 'columns: {Pos: x_mm, x: deviation_x_um}\n' >mapping.yaml
rm s.bag
"$mm" import foreign.csv --columns mapping.yaml --machine three_axis -o s.bag >out 2>err
check 'a foreign file: status 0' [ $? -eq 0 ]
check 'a foreign file: says what it understood' grep -q '^  Pos .*reading of joint x .*mm (mapping)' out
check 'help' sh -c "'$mm' import --help | grep -q time_s"
check 'version' sh -c "'$mm' --version | grep -q '^mm [0-9]'"
