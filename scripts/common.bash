# shellcheck shell=bash
# Sourced by the other scripts: where the project is, and how it is built.

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)

# fail TEXT...: ends a script whose arguments are wrong.
fail() {
  echo "${0##*/}: $*" >&2
  exit 2
}

# quietly LOG COMMAND...: the command's output goes to the log, and is shown only if it fails.
quietly() {
  local log=$1 status=0
  shift
  mkdir -p "${log%/*}"
  "$@" >"$log" 2>&1 </dev/null || status=$?
  if ((status)); then
    cat "$log" >&2
    echo "failed (status $status): $*" >&2
  fi
  return "$status"
}

# configure NAME PRESET [-DOPTION=VALUE...]: makes build/NAME ready for ninja, unless it is so already with these values.
configure() {
  local name=$1 preset=$2 directory=$root/build/$1 option is_ready=yes
  shift 2
  if [[ -f $directory/build.ninja ]]; then
    for option in "$@"; do
      sed 's/:[A-Z]*=/=/' "$directory/CMakeCache.txt" | grep -Fx -e "${option#-D}" >/dev/null || is_ready=no
    done
    [[ $is_ready == yes ]] && return
  fi
  # A preset's source directory is the current one.
  (cd "$root" && quietly "$directory/configure.log" cmake --preset "$preset" -B "$directory" "$@")
}

# How many processes compile or test at once.
jobs=${CMAKE_BUILD_PARALLEL_LEVEL:-$(nproc)}

# build NAME [TARGET...]: builds what is out of date in build/NAME.
build() {
  local name=$1
  shift
  quietly "$root/build/$name/build.log" cmake --build "$root/build/$name" --parallel "$jobs" \
    ${@:+--target "$@"}
}

# build_programs TARGET...: installs what it takes to build these, and builds them in build/release. For the program alone
# a first configuration is without the tests, which need another package. If the packages cannot be had and the program is
# there, it does without: whoever installed it may have left what only a build needs away.
build_programs() {
  if ! "$root/scripts/install-packages" run; then
    [[ $* == metabuffer && -x $root/build/release/metabuffer ]] || return 1
    echo "${0##*/}: using build/release/metabuffer as it is; its sources may be newer" >&2
    return
  fi
  if [[ $* == metabuffer ]]; then
    [[ -f $root/build/release/build.ninja ]] || configure release release -DMETABUFFER_TESTS=OFF
    build release metabuffer
  else
    "$root/scripts/install-packages" catch2
    build_checked "$@"
  fi
}

# build_checked TARGET...: builds these in build/release, with the tests, and warnings are errors.
build_checked() {
  configure release release -DMETABUFFER_TESTS=ON -DMETABUFFER_WERROR=ON
  build release "$@"
}
