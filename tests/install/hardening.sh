#!/usr/bin/env bash
# The program is built so that a found hole is hard to use. Arguments: the program, and "yes" if it
# is an optimised build without sanitizers.
set -euo pipefail
program=$1 optimised=$2

says() { # what, pattern, text of readelf
  grep -Eq "$2" <<<"$3" || { echo "hardening: no $1 in $program" >&2; exit 1; }
}
header=$(readelf -hW "$program") segments=$(readelf -lW "$program")
dynamic=$(readelf -dW "$program") symbols=$(readelf -sW "$program")
says "position-independent executable" 'Type: +DYN' "$header"
says "RELRO" 'GNU_RELRO' "$segments"
says "immediate binding" 'BIND_NOW|FLAGS_1.*NOW' "$dynamic"
says "stack that is not executable" 'GNU_STACK.* RW ' "$segments"
says "stack protector" '__stack_chk_fail' "$symbols"
[ "$optimised" = yes ] && says "_FORTIFY_SOURCE" '__(snprintf|memcpy|vsnprintf|asprintf)_chk' "$symbols"
exit 0
