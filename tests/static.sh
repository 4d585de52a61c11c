#!/usr/bin/env bash
# clang-tidy (.clang-tidy says which checks, and why not the others) and cppcheck over lib and
# server: tests/static.sh BUILD [FILE...], BUILD being any build folder, for its compile commands and
# generated files. Silent but for findings; 1 if there are any. Two minutes on 2 cores.
set -euo pipefail
cd "$(dirname "$0")/.."
build=${1:?BUILD}
shift
[ $# -gt 0 ] || mapfile -t files < <(git ls-files 'lib/src/*.c' 'server/*.c' 'server/*.cpp')
[ $# -eq 0 ] || files=("$@")
jobs=$(nproc)

# Options of gcc that clang does not know are no finding. Of one process per file each says how many
# warnings it left out: that goes to standard error.
tidy() {
  printf '%s\0' "${files[@]}" |
    xargs -0 -P "$jobs" -n 2 clang-tidy -p "$build" --quiet \
      --extra-arg=-Wno-unknown-warning-option --extra-arg=-Wno-ignored-optimization-argument \
      2>/dev/null
}

# Left out: what it says across functions of values that one of them fills (ctuuninitvar: it does not
# see that the callee writes first), and of system headers that it does not read.
check() {
  local include=(-I lib/include -I lib/src) folder
  for folder in server/*/ server/front/*/; do include+=(-I "$folder"); done
  cppcheck --enable=warning,performance,portability --std=c11 --library=posix,gnu --quiet -j "$jobs" \
    --error-exitcode=1 --inline-suppr --suppress=missingIncludeSystem --suppress=ctuuninitvar \
    --suppressions-list=tests/cppcheck.txt -D_GNU_SOURCE "${include[@]}" "${files[@]}"
}

failed=0
tidy || failed=1
check || failed=1
exit $failed
