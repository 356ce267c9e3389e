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

# configure NAME PRESET [OPTION...]: makes build/NAME ready for ninja, unless it is so already with the same options.
# Without options any configuration that is there will do. CMake itself notices changes of the CMakeLists.
configure() {
  local name=$1 preset=$2 directory=$root/build/$1
  shift 2
  if [[ -f $directory/build.ninja ]]; then
    (($#)) || return 0
    [[ -f $directory/options && $(<"$directory/options") == "$*" ]] && return 0
  fi
  # A preset's source directory is the current one.
  (cd "$root" && quietly "$directory/configure.log" cmake --preset "$preset" -B "$directory" "$@") || return
  echo "$*" >"$directory/options"
}

# build NAME [TARGET...]: builds what is out of date in build/NAME.
build() {
  local name=$1
  shift
  quietly "$root/build/$name/build.log" cmake --build "$root/build/$name" --parallel "$(nproc)" \
    ${@:+--target "$@"}
}

# build_programs TARGET...: installs what it takes to build these, and builds them in build/release.
build_programs() {
  "$root/scripts/install-packages" run
  configure release release
  build release "$@"
}

# build_checked TARGET...: builds these in build/release for the checks: warnings are errors, and no test is left out.
build_checked() {
  configure release release -DMETABUFFER_WERROR=ON -DMETABUFFER_BROWSER_TESTS=ON -DMETABUFFER_PYTHON=ON
  build release "$@"
}
