#!/usr/bin/env bash
# The life of the Debian package on a fresh machine: install, serve, upgrade with data kept, remove,
# purge. Needs root and debootstrap; takes a few minutes, so it is run by hand:
#   tests/install/chroot.sh BUILD [FOLDER]      FOLDER: a debootstrap tree to use again
set -euo pipefail
build=$(realpath "$1") root=${2:-$(mktemp -d)}
say() { echo "== $*"; }

[ -e "$root/etc/debian_version" ] || debootstrap --variant=minbase bookworm "$root" >/dev/null
inside() { chroot "$root" env DEBIAN_FRONTEND=noninteractive "$@"; }
mount -t proc proc "$root/proc"
finish() {
  inside sh -c 'kill $(cat /run/scatterd.pid) 2>/dev/null' || true
  umount "$root/proc"
}
trap finish EXIT
[ ! -e /etc/resolv.conf ] || cp /etc/resolv.conf "$root/etc/resolv.conf"

for version in 1 2; do
  (cd "$build" && cpack -G DEB -B "$root/tmp/package-$version" -R "0.1.0+$version" >/dev/null)
done
inside apt-get update -qq
inside apt-get install -y -qq --no-install-recommends curl ca-certificates >/dev/null

start() {
  inside sh -c 'mkdir -p /var/lib/scatterd &&
    scatterd --config /etc/scatterd/scatterd.conf >/var/log/scatterd.log 2>&1 & echo $! >/run/scatterd.pid'
  for _ in $(seq 100); do
    inside curl -fs http://127.0.0.1:8480/readyz >/dev/null && return
    sleep 0.1
  done
  cat "$root/var/log/scatterd.log"
  exit 1
}
stop() {
  inside sh -c 'kill $(cat /run/scatterd.pid)'
  while inside curl -s http://127.0.0.1:8480/healthz >/dev/null; do sleep 0.1; done
}

say "install"
inside sh -c 'apt-get install -y -qq /tmp/package-1/*.deb' >/dev/null
start
inside curl -fs -H 'Content-Type: application/json' -d '{"inputs":{"message":"installed"}}' \
  http://127.0.0.1:8480/processes/echo/execution | grep -q installed
stop
echo "# the operator's line" >>"$root/etc/scatterd/scatterd.conf"
echo keep >"$root/var/lib/scatterd/kept"

say "upgrade"
inside sh -c 'apt-get install -y -qq /tmp/package-2/*.deb' >/dev/null
inside dpkg-query -W -f='${Version}\n' scatterd | grep -q '+2'
grep -q "operator's line" "$root/etc/scatterd/scatterd.conf"
[ "$(cat "$root/var/lib/scatterd/kept")" = keep ]
start
stop

say "remove"
inside apt-get remove -y -qq scatterd >/dev/null
[ ! -e "$root/usr/bin/scatterd" ] && [ -e "$root/var/lib/scatterd/kept" ] && [ -e "$root/etc/scatterd/scatterd.conf" ]

say "purge"
inside apt-get purge -y -qq scatterd >/dev/null
[ ! -e "$root/var/lib/scatterd" ] && [ ! -e "$root/etc/scatterd" ]
say "clean"
