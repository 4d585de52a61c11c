#!/usr/bin/env bash
# From nothing to a solved problem: installs what is needed, builds, starts the daemon, lets it
# solve a convection-diffusion problem on a jittered cloud and prints the error norms.
#   clients/first-solve.sh          leaves the daemon running
#   clients/first-solve.sh --stop   stops it again at the end
set -euo pipefail
cd "$(dirname "$0")/.."

bash .ci/install
echo "Building, which takes a few minutes"
cmake -S . -B build -G Ninja -DSCATTERD_TESTS=OFF >build.log 2>&1 && cmake --build build >>build.log 2>&1 ||
  { tail -40 build.log; exit 1; }
rm -f build.log

url=http://127.0.0.1:8480
if curl -fs "$url/readyz" >/dev/null 2>&1; then
  echo "A daemon answers at $url already: using it"
else
  build/server/scatterd >build/scatterd.log 2>&1 &
  daemon=$!
  for _ in $(seq 100); do
    curl -fs "$url/readyz" >/dev/null 2>&1 && break
    kill -0 $daemon 2>/dev/null || { cat build/scatterd.log; exit 1; }
    sleep 0.1
  done
  echo "The daemon runs as process $daemon (kill $daemon stops it), its log is build/scatterd.log"
fi

PYTHONPATH=clients/python /usr/bin/python3 clients/python/examples/gartland.py --url "$url" \
  --plot build/gartland.png
echo "Picture of the solution: build/gartland.png"
echo "Open $url in a browser for the dashboard"
if [ "${1:-}" = --stop ] && [ -n "${daemon:-}" ]; then
  kill $daemon && wait $daemon || true
fi
