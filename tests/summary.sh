#!/bin/sh
# summary.sh BUILD: the tests of the last run of ctest in BUILD, counted over all processes, and why some were skipped.
set -eu
awk '
  /^\[  PASSED  \] [0-9]+ test/ {passed += $4}
  /^\[  FAILED  \] [0-9]+ test/ {failed += $4}
  was_skip {reasons[$0]++}
  {was_skip = /: Skipped$/}
  /^\[  SKIPPED \] [0-9]+ test/ {skipped += $4}
  END {
    for (reason in reasons) printf "Skipped %d: %s\n", reasons[reason], reason
    printf "%d passed, %d failed, %d skipped\n", passed, failed, skipped
  }' "$1/Testing/Temporary/LastTest.log"
