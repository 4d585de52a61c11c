#!/usr/bin/env bash
# Installs a build into a new prefix, moves it, and uses what is there as a stranger would: the
# library through pkg-config, the program on one request. Arguments: build folder, C compiler, its
# flags (those of a sanitizer, if the library was built with one).
set -euo pipefail
build=$1 compiler=$2 flags=${3:-}
source=$(cd "$(dirname "$0")/../.." && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

cmake --install "$build" --prefix "$work/staging" >"$work/install.log"
mv "$work/staging" "$work/place"
export PKG_CONFIG_PATH=$(dirname "$(find "$work/place" -name scatter.pc)")

for header in "$source"/lib/include/scatter/*.h; do
  echo "#include <scatter/$(basename "$header")>"
done >"$work/headers.c"
echo 'int main(void) { return sct_solver_name(0) == 0; }' >>"$work/headers.c"
for program in "$source/lib/examples/poisson_2d.c" "$work/headers.c"; do
  # shellcheck disable=SC2046,SC2086 # flags are words
  "$compiler" -std=c11 $flags "$program" $(pkg-config --cflags --libs scatter) -o "$work/program"
  "$work/program"
done

echo '{"inputs":{"message":"installed"}}' >"$work/request.json"
"$work/place/bin/scatterd" run --process echo "$work/request.json" | grep -q '"message":"installed"'

for document in LICENSE README.md CHANGELOG.md lib/README.md server/README.md; do
  cmp "$source/$document" "$(find "$work/place/share/doc" -path "*scatterd/$document")"
done
