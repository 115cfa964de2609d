#!/bin/sh
# Runs one of the Makefile's targets in a bare Debian 12 root, so that a package missing from cmake/debian-packages*.txt
# cannot go unseen: bare_debian.sh BUILD root|tool|tests|python|mpi|ros|docs|docker|release
#
# `root` unpacks Debian's minimal system plus make once, into BUILD/bare; every other word copies it, puts the sources and
# what BUILD has compiled at their own paths in the copy, and works there as root. Skipped (77), with the reason, where this
# cannot be done: no root, no debootstrap, no package registry.
set -eu
source_dir=$(cd "$(dirname "$0")/../.." && pwd)
build=$(cd "$1" && pwd)
what=$2
cache=$build/bare
root=$cache/$what

skip() {
  echo "bare Debian: skipped: $1"
  exit 77
}
[ "$(id -u)" = 0 ] || skip "only root can make one"
command -v debootstrap >/dev/null 2>&1 || skip "there is no debootstrap"
case $build in "$source_dir"/*) ;; *) skip "the build folder is outside the sources" ;; esac
unshare --mount --pid --fork true 2>/dev/null || skip "mounts of its own are not allowed here"

if [ "$what" = root ]; then
  [ -f "$cache/done" ] && exit 0
  rm -rf "$root"
  mkdir -p "$root"
  debootstrap --variant=minbase --include=make,ca-certificates bookworm "$root" >"$cache/root.log" 2>&1 || {
    grep -q '^E: .*\(download\|Release\|retriev\)' "$cache/root.log" && skip "the package registry cannot be reached"
    tail -20 "$cache/root.log"
    exit 1
  }
  : >"$cache/done"
  exit 0
fi
[ -f "$cache/done" ] || skip "there is no root; see bare/root"

# A copy whose clock, devices and network are this machine's.
copy_of_root() {
  rm -rf "$1"
  cp -a "$cache/root" "$1"
  for file in /etc/resolv.conf /etc/hosts; do [ ! -f $file ] || cp -L $file "$1$file"; done
  [ ! -d /etc/apt/apt.conf.d ] || cp -rL /etc/apt/apt.conf.d/. "$1/etc/apt/apt.conf.d/"
}
# inside ROOT COMMANDS: as root of ROOT, in the folder of the sources, with none of this machine's environment
inside() {
  unshare --mount --pid --fork sh -eu -c '
    mount -t proc proc "$1/proc"
    mount --bind /dev "$1/dev"
    mkdir -p "$1$2"
    exec env -i PATH=/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin HOME=/root LANG=C.UTF-8 \
      DEBIAN_FRONTEND=noninteractive chroot "$1" sh -eu -c "cd \"$2\"; $3"' sh "$1" "$source_dir" "$2"
}

copy_of_root "$root"
trap 'rm -rf "$root" "$cache/stranger"' EXIT
mkdir -p "$root$source_dir" "$root$build"
if [ "$what" = release ]; then  # no more than its archive holds
  (cd "$source_dir" && tar -tzf "$build"/release/veridyn-[0-9]*[0-9].tar.gz | sed -n 's#^[^/]*/\(.*[^/]\)$#\1#p' | tar -cf - -T -)
else
  (cd "$source_dir" && tar -cf - --exclude=./.git --exclude='./build*' --exclude=./out .)
fi | tar -xf - -C "$root$source_dir"
(cd "$build" && tar -cf - --exclude=./bare --exclude=./ros --exclude=./debs --exclude=./release --exclude=./site --exclude=./Testing --exclude='./bin/test_*' .) |
  tar -xf - -C "$root$build"
name=$(basename "$build")
# BUILD may have been asked for more than the package list of a target provides.
tool="BUILD=$name CMAKE_FLAGS='--preset dev -DVERIDYN_TESTS=OFF -DVERIDYN_BENCHMARKS=OFF -DVERIDYN_PYTHON=OFF'"
# The compiler's launcher is part of every command that BUILD has run.
grep -q '^VERIDYN_CCACHE:FILEPATH=/' "$build/CMakeCache.txt" && inside "$root" 'apt-get update -qq; apt-get install -y -qq --no-install-recommends ccache >/dev/null'

case $what in
tool)
  inside "$root" "make packages && cmake --preset dev -B /tmp/fresh -DVERIDYN_TESTS=OFF -DVERIDYN_BENCHMARKS=OFF -DVERIDYN_BUILD_PACKAGES=NONE >/tmp/log 2>&1 || { cat /tmp/log; exit 1; }"
  inside "$root" "make tool $tool && $name/bin/veridyn info psm-3dof >/dev/null"
  ;;
tests)
  inside "$root" "make packages-tests && cmake --preset dev -B /tmp/fresh -DVERIDYN_TESTS=ON -DVERIDYN_BENCHMARKS=ON -DVERIDYN_PYTHON=ON >/tmp/log 2>&1 || { cat /tmp/log; exit 1; }"
  ;;
python)
  inside "$root" "make python $tool && PYTHONPATH=$name/python python3 -c 'import veridyn; print(veridyn.read_model(\"psm-3dof\"))' >/dev/null"
  ;;
mpi)
  inside "$root" "make mpi $tool
    $name/bin/veridyn excite planar-2r --starts 1 --duration 10 -o /tmp/motion.csv --quiet >/dev/null
    $name/bin/veridyn simulate planar-2r --trajectory /tmp/motion.csv -o /tmp/rec.csv --quiet >/dev/null
    mpirun --allow-run-as-root --oversubscribe -n 2 $name/bin/veridyn identify planar-2r --train /tmp/rec.csv /tmp/rec.csv"
  ;;
ros)
  inside "$root" "make ros-test $tool && for program in rostopic rosrun roslaunch; do command -v \$program; done"
  ;;
docs)
  inside "$root" "make docs BUILD=/tmp/docs"
  ;;
release)
  # What `make release` made: the README's first command on the sources that it publishes, then each package.
  inside "$root" "VERIDYN_DEMO=0 make demo $tool"
  copy_of_root "$cache/stranger"
  mkdir -p "$cache/stranger$source_dir"
  cp -r "$build/release" "$cache/stranger/release"
  cp "$source_dir/tests/bare/installed.sh" "$cache/stranger/release.sh"
  inside "$cache/stranger" "/release.sh \"$source_dir\""
  ;;
docker)
  # The commands of the Dockerfile's two stages, the first with what BUILD has compiled already.
  [ "$name" = build ] || skip "the Dockerfile builds in build/"
  run_lines() { awk -v stage="$1" '/^FROM /{n++} n == stage && sub(/^RUN /, "")' "$source_dir/Dockerfile"; }
  run_lines 1 >"$cache/lines"
  while read -r line; do
    inside "$root" "export CMAKE_FLAGS='--preset dev -DVERIDYN_TESTS=OFF -DVERIDYN_BENCHMARKS=OFF -DVERIDYN_PYTHON=OFF'; $line" </dev/null
  done <"$cache/lines"
  copy_of_root "$cache/stranger"
  cp -a "$root/packages" "$cache/stranger/packages"
  mkdir -p "$cache/stranger$source_dir"
  run_lines 2 >"$cache/lines"
  while read -r line; do inside "$cache/stranger" "$line" </dev/null; done <"$cache/lines"
  entry=$(sed -n 's/^ENTRYPOINT \["\(.*\)"\]$/\1/p' "$source_dir/Dockerfile")
  inside "$cache/stranger" "cd /; [ ! -e /packages ]; ${entry:?the Dockerfile has no entry point} info psm-3dof >/dev/null"
  ;;
*)
  echo "bare_debian.sh: found '$what', expected root, tool, tests, python, mpi, ros, docs, docker or release" >&2
  exit 2
  ;;
esac
echo "bare Debian: $what works"
