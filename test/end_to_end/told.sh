# Sourced by scripts of this folder.
check() {  # check <name> <condition …>
  local name="$1"
  shift
  if "$@"; then echo "ok $name"; else echo "not ok $name"; fi
}
