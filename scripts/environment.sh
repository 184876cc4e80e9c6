# Sourced by the scripts: the repository's root, and Debian's own tools before any others.
set -euo pipefail
export PATH="/usr/bin:$PATH" LC_ALL=C.UTF-8 LANG=C.UTF-8
root="$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)"
cd "$root"
if [[ " $* " == *" --help "* || " $* " == *" -h "* ]]; then  # the comment at the top of the script that sources this
  sed -n '2,/^[^#]/{s/^# \{0,1\}//p}' "$root/scripts/$(basename "$0")"
  exit 0
fi
jobs="${MM_JOBS:-$(nproc)}"

# configure_and_build <folder> <targets> [cmake options …]
configure_and_build() {
  local folder="$1" targets="$2" begun=$SECONDS
  shift 2
  mkdir -p "$folder"
  export CMAKE_GENERATOR=Ninja  # of a new folder: it begins what is ready, make a library after those that it needs
  cmake -S . -B "$folder" -DMM_STRICT=ON "$@" >"$folder/configure.log" 2>&1 || { cat "$folder/configure.log"; return 1; }
  # shellcheck disable=SC2086
  nice cmake --build "$folder" -j "$jobs" --target $targets || return 1
  echo "build: done ($((SECONDS - begun)) s)"
}
