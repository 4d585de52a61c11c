#!/usr/bin/env bash
# Runs fuzz targets one after the other, SECONDS each, and prints a row per target for the table in
# tests/README.md: executions, seconds, edges of our code reached, inputs kept, findings.
#   tests/fuzz/run.sh BUILD SECONDS [TARGET...]     libFuzzer, BUILD of the preset fuzz (clang)
#   tests/fuzz/run.sh --afl BUILD SECONDS [TARGET]  AFL++, BUILD of the preset afl; target: answer
# Corpora stay in BUILD/corpus/TARGET, so that a later run goes on from there; inputs that break
# something are in BUILD/findings/TARGET. Exits with 1 if there are any.
set -euo pipefail
engine=libfuzzer
[ "${1:-}" = --afl ] && { engine=afl; shift; }
build=${1:?BUILD} seconds=${2:?SECONDS}
shift 2
here=$(cd "$(dirname "$0")" && pwd)

# The sanitizers' own words; a finding of UBSan ends the run as one of ASan does.
export ASAN_OPTIONS=abort_on_error=1:symbolize=0:detect_leaks=0:allocator_may_return_null=1
[ $engine = libfuzzer ] && ASAN_OPTIONS=allocator_may_return_null=1
export UBSAN_OPTIONS=print_stacktrace=1

seeds() { # TARGET: the folders that its test replays
  local folder
  for folder in "$here/seeds/$1" "$build/tests/fuzz/seeds/$1"; do
    if [ -d "$folder" ]; then echo "$folder"; fi
  done
}

row() { # target executions seconds edges inputs findings
  printf '| `%s` | %s | %s | %s | %s | %s |\n' "$@"
}

stat() { # FILE NAME: a final statistic of libFuzzer
  sed -n "s/^stat::$2: *//p" "$1" | tail -1
}

run_libfuzzer() {
  local target=$1 corpus=$build/corpus/$1 found=$build/findings/$1 log=$build/findings/$1.log
  local options=(-max_total_time="$seconds" -timeout=20 -rss_limit_mb=3000 -print_final_stats=1
    -artifact_prefix="$found/" -use_value_profile=1 -verbosity=1)
  mkdir -p "$corpus" "$found"
  local words=$build/tests/fuzz/seeds/$target.dict
  if [ -f "$words" ]; then options+=(-dict="$words"); fi
  # shellcheck disable=SC2046
  nice -n 19 "$build/tests/fuzz/fuzz_$target" "${options[@]}" "$corpus" $(seeds "$target") \
    >"$log" 2>&1 || true
  row "$target" "$(stat "$log" number_of_executed_units)" \
    "$(sed -n 's/^Done .* in \([0-9]*\) second.*/\1/p' "$log")" \
    "$(grep -o 'cov: [0-9]*' "$log" | tail -1 | cut -d' ' -f2)" \
    "$(find "$corpus" -type f | wc -l)" "$(find "$found" -type f | wc -l)"
}

run_afl() {
  local target=$1 out=$build/corpus/afl-$1 from=$build/afl-seeds/$1 stats
  mkdir -p "$from" "$out"
  # shellcheck disable=SC2046
  find $(seeds "$target") -type f -size -4k -exec cp -t "$from" {} +
  AFL_NO_UI=1 AFL_SKIP_CPUFREQ=1 AFL_I_DONT_CARE_ABOUT_MISSING_CRASHES=1 AFL_AUTORESUME=1 \
    AFL_IGNORE_SEED_PROBLEMS=1 AFL_NO_AFFINITY=1 \
    nice -n 19 afl-fuzz -V "$seconds" -t 20000+ -m none -i "$from" -o "$out" -- \
    "$build/tests/fuzz/fuzz_$target" >"$build/afl-$target.log" 2>&1 || true
  stats=$out/default/fuzzer_stats
  value() { sed -n "s/^$1 *: *//p" "$stats"; }
  row "$target" "$(value execs_done)" "$(value run_time)" "$(value edges_found)" \
    "$(value corpus_count)" "$(value saved_crashes)"
}

if [ $# -eq 0 ]; then
  if [ $engine = afl ]; then set -- answer; fi
  if [ $engine = libfuzzer ]; then
    for program in "$build"/tests/fuzz/fuzz_*; do
      if [ -x "$program" ]; then set -- "$@" "${program##*/fuzz_}"; fi
    done
  fi
fi
mkdir -p "$build/findings"
echo '| target | executions | seconds | edges | inputs | findings |'
echo '|---|---|---|---|---|---|'
for target; do "run_$engine" "$target" | tee "$build/row"; findings=${findings:-}$(sed 's/.*| \([0-9]*\) |$/\1/' "$build/row"); done
[ -z "${findings//0/}" ]
