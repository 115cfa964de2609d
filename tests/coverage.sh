#!/bin/sh
# coverage.sh FOLDER [ROOM...]: which lines, functions and branches of src/ROOM the tests in FOLDER ran, in a table by file and, with
# the source, in FOLDER/coverage/index.html.
set -eu
cd "$(dirname "$0")/.."
folder=$1
shift
rooms=""
for room; do rooms="$rooms src/$room include/veridyn/$room"; done
ls "$folder"/profiles/*.profraw >/dev/null 2>&1 || { echo "coverage: found no $folder/profiles; make coverage makes it" >&2; exit 3; }
llvm-profdata merge -sparse "$folder"/profiles/*.profraw -o "$folder/coverage.profdata"
# The first program is an argument, the others are options.
set --
for program in "$folder"/bin/test_*; do
  [ $# -gt 0 ] && set -- "$@" -object "$program" || set -- "$program"
done
llvm-cov show "$@" -instr-profile="$folder/coverage.profdata" -format=html -output-dir="$folder/coverage" -show-branches=count ${rooms:-src include}
llvm-cov report "$@" -instr-profile="$folder/coverage.profdata" -show-region-summary=false ${rooms:-src include}
