#!/usr/bin/env bash
# The reference pages in server/ are those that the program prints. Argument: the program.
set -euo pipefail
program=$1
cd "$(dirname "$0")/../../server"
same() { # page, option
  "$program" "$2" | diff -u "$1" - ||
    { echo "reference: server/$1 is old; scatterd $2 >server/$1 makes it" >&2; exit 1; }
}
same PARAMETERS.md --print-parameters
same METRICS.md --print-metrics
