#!/usr/bin/env bash
# examples/own_effect as its reader builds it: against this package's devel space; and effects that are wrong.
# thorough only: two packages are built, and searched with
set -u
mm="$(realpath "${MM:?path of mm}")"
devel="$(cd "$(dirname "$mm")/../.." && pwd)"
source_folder="$(pwd)"
work="$(mktemp -d)"
trap 'rm -rf "$work"' EXIT
export PATH="/usr/bin:$PATH" ROS_HOME="$work/ros_home"

check() {  # check <name> <condition …>
  local name="$1"
  shift
  if "$@"; then echo "ok $name"; else echo "not ok $name"; fi
}
build() {  # build <folder of a package> <build folder>
  (set +u; source "$devel/setup.bash"; cmake -S "$1" -B "$2" -DCMAKE_CXX_FLAGS="-Wall -Wextra -Werror" && cmake --build "$2") \
    >"$2.log" 2>&1 || { tail -n 20 "$2.log"; return 1; }
}
plain() { (set +u; source "$devel/setup.bash"; "$mm" "$@"); }
own() { (set +u; source "$work/own/devel/setup.bash"; "$mm" "$@"); }
bad() { (set +u; source "$work/bad/devel/setup.bash"; "$mm" "$@"); }

check 'the example builds, without a warning' build "$source_folder/examples/own_effect" "$work/own"
check 'the wrong effects build' build "$source_folder/test/support/bad_effects" "$work/bad"
plan="$source_folder/config/plans/nine_ball_plate.yaml"
cd "$work"
angle=140
plain simulate --machine three_axis --plan "$plan" --hide friction_lever:x/z=${angle}arcsec --seed 3 -o s.bag >/dev/null
printf 'machine: three_axis\neffects: []\n' >empty.yaml
printf 'machine: three_axis\neffects:\n  - {type: friction_lever, axis: x, across: z}\n' >own.yaml

# Without the package: an unknown effect, and a model that names it is refused.
plain calibrate s.bag --model empty.yaml --method least_squares -o c.yaml >/dev/null
plain diagnose s.bag --calibration c.yaml --json >plain.json 2>/dev/null
check 'without the package: unknown_effect' grep -q '"verdict": "unknown_effect"' plain.json
plain calibrate s.bag --model own.yaml -o none.yaml >/dev/null 2>err
check 'without the package: status 2' [ $? -eq 2 ]
check 'without the package: one line that says what to do' [ "$(grep -c 'ROS_PACKAGE_PATH' err) $(wc -l <err)" = '1 1' ]

# With it: found, named with its cause, added, applied.
own diagnose s.bag --calibration c.yaml --json >own.json 2>err
check 'with the package: nothing on standard error but progress' [ ! -s err ]
field() { python3 -c "import json,sys; d=json.load(open(sys.argv[1])); print($2)" "$1"; }
check 'found first, of all' [ "$(field own.json "d['missing'][0]['effect']['type'], d['missing'][0]['effect']['axis'], d['missing'][0]['effect']['across']")" = 'friction_lever x z' ]
check 'listed among the candidates' [ "$(field own.json "sum(c['effect']['type'] == 'friction_lever' for c in d['candidates']) >= 2")" = True ]
check 'no longer unknown' [ "$(field own.json "d['verdict'] != 'unknown_effect'")" = True ]
check 'its cause is told' grep -q 'pulls beside the middle of the friction' own.json
own calibrate s.bag --model own.yaml --method least_squares -o o.yaml --json >cal.json 2>/dev/null
check "calibrated: the angle that was hidden, $angle arcsec, within 5 %" [ "$(field cal.json "abs(abs(d['parameters'][0]['value']) / $angle - 1) < 0.05 and d['parameters'][0]['unit'] == 'arcsec'")" = True ]
check 'calibrated: what is left is near the repeatability of 0.3 um' [ "$(field cal.json "d['rms_um'] < 0.36")" = True ]
own add s.bag --calibration c.yaml '{type: friction_lever, axis: x, across: z}' -o added.yaml >out 2>err
check 'added' grep -q 'friction_lever' added.yaml
printf 'x_mm,y_mm,z_mm,x_velocity_mm_s\n5,5,9,1\n5,5,9,-1\n' >states.csv
own apply states.csv --calibration o.yaml -o corrected.csv >/dev/null 2>&1
check 'applied: both directions differ by the lever' [ "$(python3 -c "
import csv, math; r=list(csv.DictReader(open('corrected.csv'))); d=abs(float(r[0]['corrected_x_mm'])-float(r[1]['corrected_x_mm'])); lever=$angle*math.pi/648e3*9; print(0.9*lever < d < 1.1*lever)")" = True ]

# Wrong ones: one line each, and the others go on.
bad calibrate s.bag --model empty.yaml --method least_squares -o b.yaml >/dev/null 2>err
check 'wrong plugins do not stop what does not need them' [ $? -eq 0 ]
for words in 'missing.xml does not exist' 'no_xml.xml:1: is not XML' "'never_built' of package bad_effects is ignored" \
  "'nobody' of package bad_effects is ignored: its library has no class" "'old' .* build it again" \
  "'backlash' is already in the catalogue" "'throws_at_once' of package bad_effects is ignored: no licence file"; do
  check "one line: $words" [ "$(grep -c "^mm: warning: .*$words" err)" = 1 ]
done
check 'no other line' [ "$(wc -l <err)" -eq 7 ]
refused() {  # refused <type> <words>
  printf 'machine: three_axis\neffects:\n  - {type: %s}\n' "$1" >m.yaml
  bad calibrate s.bag --model m.yaml --method least_squares -o b.yaml >/dev/null 2>err
  check "$1: status 2" [ $? -eq 2 ]
  check "$1: says '$2', once" [ "$(grep -c "$2" err)" = 1 ]
}
refused throws_in_create "package bad_effects): no such bearing"
refused throws_at_work 'threw during evaluation: the table of loads is empty'
refused not_linear 'not linear in the parameters without'
bad diagnose s.bag --calibration c.yaml --json >bad.json 2>err
check 'a diagnosis goes on without them' [ "$(field bad.json "d['verdict']")" = unknown_effect ]

# What rospack keeps may be damaged by another program (a full disk): made anew, without a word.
own calibrate s.bag --model own.yaml --method least_squares -o o.yaml >/dev/null 2>&1
for cache in "$ROS_HOME"/rospack_cache_*; do truncate -s 40 "$cache"; done
own calibrate s.bag --model own.yaml --method least_squares -o o.yaml >/dev/null 2>err
check 'a damaged list of packages: status 0' [ $? -eq 0 ]
check 'a damaged list of packages: not a word' [ ! -s err ]
