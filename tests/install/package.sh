#!/usr/bin/env bash
# The Debian package holds what a machine needs, in its places, and systemd has nothing to say
# against the units. Argument: build folder.
set -euo pipefail
build=$1
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

(cd "$build" && cpack -G DEB -B "$work/out" >"$work/cpack.log" 2>&1) || { cat "$work/cpack.log"; exit 1; }
package=$(ls "$work"/out/scatterd_*.deb)
dpkg-deb -x "$package" "$work/tree"
dpkg-deb -e "$package" "$work/control"

for path in usr/bin/scatterd usr/bin/scatterd-client usr/bin/scatterd-backup \
  usr/share/man/man1/scatterd.1 usr/share/man/man1/scatterd-client.1 \
  usr/lib/systemd/system/scatterd.service usr/lib/systemd/system/scatterd.socket \
  etc/scatterd/scatterd.conf usr/lib/python3/dist-packages/scatterd/__init__.py; do
  [ -e "$work/tree/$path" ] || { echo "package: no $path" >&2; exit 1; }
done
grep -q '^Depends: .*libmicrohttpd' "$work/control/control"
grep -qx /etc/scatterd/scatterd.conf "$work/control/conffiles"
for script in postinst prerm postrm; do
  sh -n "$work/control/$script"
  [ -x "$work/control/$script" ]
done

for page in scatterd scatterd-client; do # what apropos finds
  grep -A1 '^.SH NAME' "$work/tree/usr/share/man/man1/$page.1" | grep -q "^$page .*- "
done

# The packaged configuration is one that the packaged program takes.
echo '{"inputs":{"message":"packaged"}}' >"$work/request.json"
"$work/tree/usr/bin/scatterd" run --config "$work/tree/etc/scatterd/scatterd.conf" --process echo \
  "$work/request.json" | grep -q packaged
if command -v systemd-analyze >/dev/null; then
  systemd-analyze security --offline=true --threshold=20 --no-pager \
    "$work/tree/usr/lib/systemd/system/scatterd.service" >"$work/security" ||
    { tail -1 "$work/security"; exit 1; } # threshold in tenths: an exposure of at most 2.0
  tail -1 "$work/security"
fi
