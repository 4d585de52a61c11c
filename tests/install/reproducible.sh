#!/usr/bin/env bash
# Builds the release twice - in other folders, another locale, time zone and umask, in another order
# - and compares the bytes of program, library and Debian package. Silent if they are the same.
#   tests/install/reproducible.sh [-DOPTION=VALUE...]     some minutes; the build folders are temporary
# Only cpack always runs under umask 022: ar notes the modes of the files that a package consists of.
# SOURCE_DATE_EPOCH, the time that the package's files have, is the commit's unless it is set.
set -euo pipefail
cd "$(dirname "$0")/../.."
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
export SOURCE_DATE_EPOCH=${SOURCE_DATE_EPOCH:-$(git log -1 --format=%ct)}

copy() { # FOLDER: the files of the project, new to the second
  mkdir -p "$1"
  git ls-files -z | xargs -0 cp --parents -t "$1"
}

build() { # SOURCE BUILD JOBS options
  local source=$1 folder=$2 jobs=$3
  shift 3
  { cmake -S "$source" -B "$folder" -G Ninja -DCMAKE_BUILD_TYPE=Release -DSCATTERD_TESTS=OFF "$@" &&
    cmake --build "$folder" -j "$jobs" && (umask 022; cd "$folder" && cpack -G DEB)
  } >"$folder.log" 2>&1 ||
    { tail -30 "$folder.log"; exit 1; }
}

copy "$work/one"
copy "$work/a longer/path/to/two"
build "$work/one" "$work/one-build" "$(nproc)" "$@"
(umask 077; LC_ALL=C.UTF-8 TZ=Pacific/Kiritimati PYTHONHASHSEED=17 \
  build "$work/a longer/path/to/two" "$work/a longer/path/to/build" 1 "$@")

failed=0
same() { # path within both builds
  cmp "$work/one-build/$1" "$work/a longer/path/to/build/$1" || failed=1
}
same server/scatterd
same lib/libscatter.a
package=$(cd "$work/one-build" && ls scatterd_*.deb)
same "$package"
if [ $failed -ne 0 ] && [ -n "${KEEP:-}" ]; then
  trap - EXIT
  echo "both are in $work" >&2
fi
exit $failed
