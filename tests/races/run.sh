#!/bin/sh
# run.sh BUILD: the tests that start threads, under valgrind's helgrind. Status 1 where two threads touch the same memory without
# an order between them, or take locks in different orders.
cd "$(dirname "$0")/../.." || exit 2
broken=0
while read -r program tests; do
  if valgrind -q --tool=helgrind --error-exitcode=9 --suppressions=tests/races/helgrind.supp \
      "$1/bin/test_$program" --gtest_brief=1 --gtest_filter="$tests" >"$1/races.log" 2>&1 && ! grep -q ' 0 tests from' "$1/races.log"; then
    echo "test_$program $tests: no race"
  else
    cat "$1/races.log"
    broken=1
  fi
done <<'LIST'
math Parallel*:TheFactor.DoesNot*
recordings Opened.APipe*:Opened.ARecording*:Joined.AHeldJointNeedNotBeInAPipe
watch GrowingRecording*
dvrk_io Served*
diagnosis Stages.EveryRecordingIsOpenedAndParsedOnce
LIST
exit $broken
