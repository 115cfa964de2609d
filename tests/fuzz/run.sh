#!/bin/sh
# run.sh FOLDER SECONDS [TARGET...]: fuzzes the readers one after the other with the fuzzer in the folder. What it learns stays in
# FOLDER/corpus, inputs that break a reader in FOLDER/findings. Status 1 where there are any.
cd "$(dirname "$0")/../.." || exit 2
folder=$1 seconds=$2
shift 2
fuzzer=$folder/veridyn_fuzzer
# Libraries of others look at what malloc() returns; ours throw.
export ASAN_OPTIONS=allocator_may_return_null=1:max_allocation_size_mb=1000 UBSAN_OPTIONS=print_stacktrace=1
export LSAN_OPTIONS=suppressions=$PWD/tests/fuzz/leaks.txt:print_suppressions=0
[ $# -gt 0 ] || set -- $("$fuzzer" --targets)
mkdir -p "$folder/findings"
broken=0
for target; do
  mkdir -p "$folder/corpus/$target" "$folder/seeds/$target"
  "$fuzzer" --target="$target" --seeds="$folder/seeds/$target" || exit 2
  own=tests/fuzz/corpus/$target
  [ -d "$own" ] || own=
  if "$fuzzer" --target="$target" -max_total_time="$seconds" -timeout=60 -rss_limit_mb=2500 -malloc_limit_mb=0 -max_len=65536 \
      -print_final_stats=1 -artifact_prefix="$folder/findings/$target-" "$folder/corpus/$target" "$folder/seeds/$target" $own \
      >"$folder/$target.log" 2>&1; then
    echo "$target: $(sed -n 's/^stat::number_of_executed_units: *//p' "$folder/$target.log") inputs in $seconds s, no finding"
  else
    echo "$target: $(grep -m 1 -E 'ERROR|SUMMARY|runtime error|contradiction|terminate' "$folder/$target.log"); see $folder/$target.log"
    broken=1
  fi
done
exit $broken
