#!/usr/bin/env bash
# Runs fuzz targets, SECONDS each, and prints a row per target for the table in tests/README.md:
# executions, seconds, seconds of processor, edges of our code reached, inputs kept, findings.
#   tests/fuzz/run.sh BUILD SECONDS [TARGET...]     libFuzzer, BUILD of the preset fuzz (clang)
#   tests/fuzz/run.sh --afl BUILD SECONDS [TARGET]  AFL++, BUILD of the preset afl; target: answer
# One after the other; SCATTERD_FUZZ_JOBS=7 runs as many at a time.
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

row() { # target executions seconds processor edges inputs findings
  printf '| `%s` | %s | %s | %s | %s | %s | %s |\n' "$@"
}

TIMEFORMAT='%U %S'
processor() { # FILE of what `time` said last
  tail -1 "$1" | awk '{printf "%.0f", $1 + $2}'
}

stat() { # FILE NAME: a final statistic of libFuzzer
  sed -n "s/^stat::$2: *//p" "$1" | tail -1
}

run_libfuzzer() {
  local target=$1 corpus=$build/corpus/$1 found=$build/findings/$1 log=$build/findings/$1.log
  local options=(-max_total_time="$seconds" -timeout=60 -report_slow_units=60 -rss_limit_mb=3000
    -print_final_stats=1
    -artifact_prefix="$found/" -use_value_profile=1 -verbosity=1)
  mkdir -p "$corpus" "$found"
  local words=$build/tests/fuzz/seeds/$target.dict
  if [ -f "$words" ]; then options+=(-dict="$words"); fi
  # shellcheck disable=SC2046
  { time nice -n 19 "$build/tests/fuzz/fuzz_$target" "${options[@]}" "$corpus" $(seeds "$target") \
    >"$log" 2>&1 || true; } 2>"$log.time"
  row "$target" "$(stat "$log" number_of_executed_units)" \
    "$(sed -n 's/^Done .* in \([0-9]*\) second.*/\1/p' "$log")" \
    "$(processor "$log.time")" \
    "$(grep -o 'cov: [0-9]*' "$log" | tail -1 | cut -d' ' -f2)" \
    "$(find "$corpus" -type f | wc -l)" "$(find "$found" -type f | wc -l)"
}

run_afl() {
  local target=$1 out=$build/corpus/afl-$1 from=$build/afl-seeds/$1 found=$build/findings/afl-$1
  local log=$build/findings/afl-$1.log stats=$out/default/fuzzer_stats
  mkdir -p "$from" "$out" "$found"
  # shellcheck disable=SC2046
  find $(seeds "$target") -type f -size -4k -exec cp -t "$from" {} +
  { time AFL_NO_UI=1 AFL_SKIP_CPUFREQ=1 AFL_I_DONT_CARE_ABOUT_MISSING_CRASHES=1 AFL_AUTORESUME=1 \
    AFL_IGNORE_SEED_PROBLEMS=1 AFL_NO_AFFINITY=1 \
    nice -n 19 afl-fuzz -V "$seconds" -t 60000+ -m none -i "$from" -o "$out" -- \
    "$build/tests/fuzz/fuzz_$target" >"$log" 2>&1 || true; } 2>"$log.time"
  find "$out/default" -name 'id:*' -path '*/crashes/*' -exec cp -t "$found" {} +
  value() { sed -n "s/^$1 *: *//p" "$stats"; }
  row "$target" "$(value execs_done)" "$(value run_time)" "$(processor "$log.time")" "$(value edges_found)" \
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
echo '| target | executions | seconds | processor | edges | inputs | findings |'
echo '|---|---|---|---|---|---|---|'
jobs=${SCATTERD_FUZZ_JOBS:-1}
for target; do
  while [ "$(jobs -rp | wc -l)" -ge "$jobs" ]; do wait -n; done
  "run_$engine" "$target" &
done
wait
[ -z "$(find "$build/findings" -mindepth 2 -type f)" ]
