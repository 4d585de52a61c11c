#!/usr/bin/env bash
# All tests, from nothing: installs what they need, checks the formatting, builds with warnings as
# errors, looks through the sources with clang-tidy and cppcheck, and runs everything, under
# AddressSanitizer and UBSan and in a release build.
#   tests/run.sh            everything
#   tests/run.sh REGEX      only the tests whose names match, without sanitizers
set -euo pipefail
cd "$(dirname "$0")/.."

bash .ci/install tests

echo "== formatting"
git ls-files '*.c' '*.h' '*.cpp' | xargs -r clang-format --dry-run --Werror

build() { # folder, further options
  local folder=$1
  shift
  echo "== build in $folder ($*)"
  cmake -S . -B "$folder" -G Ninja -DSCATTERD_WERROR=ON "$@" >"$folder.log" 2>&1 &&
    cmake --build "$folder" >>"$folder.log" 2>&1 || { tail -50 "$folder.log"; exit 1; }
  rm -f "$folder.log"
}

# What decides is the same every time; tests run by hand choose seeds of their own.
export SCATTERD_SEED="${SCATTERD_SEED:-20251123}"
jobs=$(nproc)
build build-check
if [ $# -gt 0 ]; then
  ctest --test-dir build-check --output-on-failure -j "$jobs" -R "$1"
  exit
fi
echo "== static analysis"
bash tests/static.sh build-check
build build-sanitized -DSCATTERD_SANITIZE=ON -DCMAKE_BUILD_TYPE=RelWithDebInfo
echo "== tests, under AddressSanitizer and UndefinedBehaviorSanitizer"
ctest --test-dir build-sanitized --output-on-failure -j "$jobs"
echo "== tests, release build"
ctest --test-dir build-check --output-on-failure -j "$jobs"
