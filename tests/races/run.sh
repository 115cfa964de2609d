#!/bin/sh
# run.sh BUILD: the tests that start threads and a search on two, under valgrind's helgrind. Status 1 where two threads touch the same memory without
# an order between them, or take locks in different orders. Helgrind does not see the guard of a function's static variable,
# nor what an atomic number orders: tests whose threads share such are not in the list.
cd "$(dirname "$0")/../.." || exit 2
build=$1
broken=0
# seen WHAT COMMAND...
seen() {
  what=$1
  shift
  if valgrind -q --tool=helgrind --error-exitcode=9 --suppressions=tests/races/helgrind.supp "$@" >"$build/races.log" 2>&1 &&
      ! grep -q ' 0 tests from' "$build/races.log"; then
    echo "$what: no race"
  else
    cat "$build/races.log"
    broken=1
  fi
}
while read -r program tests; do
  seen "test_$program $tests" "$build/bin/test_$program" --gtest_brief=1 --gtest_filter="$tests"
done <<'LIST'
math Parallel*:TheFactor.SizeDoesNot*
recordings Opened.APipe*:Opened.EveryRead*:Opened.ARecording*:Joined.AHeldJointMayBeMissingFromAPipe
watch GrowingRecording*
dvrk_io Served*
LIST
seen "excite --threads 2" "$build/bin/veridyn" excite planar-2r --starts 2 --evaluations 20 --duration 10 --threads 2 -o "$build/races.csv" --quiet
exit $broken
