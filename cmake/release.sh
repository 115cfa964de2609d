#!/bin/sh
# What a version publishes, of the last commit, in BUILD/release, then tried: release.sh BUILD
#
#   veridyn-V.tar.gz           the sources                      *.deb                     Debian packages
#   veridyn-V-*.whl            the module for this Python       Dockerfile                the tool as an image, of the sources
#   veridyn-V-book.tar.gz      the book as a site               veridyn-V-symbols.txt     public functions
#   veridyn-V.cdx.json         what the tool is made of         SHA256SUMS
set -eu
cd "$(dirname "$0")/.."
build=$1
out=$build/release
version=$(sed -n 's/^project(veridyn VERSION \([0-9.]*\).*/\1/p' CMakeLists.txt)
make="${MAKE:-make} --no-print-directory BUILD=$build"
changed=$(git status --porcelain)
[ -z "$changed" ] || { printf 'release: found changes that are not in a commit, expected none:\n%s\n' "$changed" >&2; exit 1; }
rm -rf "$out"
mkdir -p "$out"
git archive --prefix="veridyn-$version/" HEAD | gzip -9n >"$out/veridyn-$version.tar.gz"
$make deb
cp "$build"/debs/*.deb "$out"
VERIDYN=$build/bin/veridyn $make docs
tar -C "$build/site" --transform "s/^html/veridyn-$version-book/" --sort=name --owner=0 --group=0 -czf "$out/veridyn-$version-book.tar.gz" html
python3 cmake/bill_of_materials.py "$build/bin/veridyn" "$version" "$out/veridyn-$version.cdx.json"
$make wheel  # the module alone holds the library
cp "$build"/wheel/*.whl Dockerfile "$out"
cp tests/structure/symbols.txt "$out/veridyn-$version-symbols.txt"
(cd "$out" && sha256sum -- * >SHA256SUMS)

try() { tests/bare/bare_debian.sh "$build" "$1" || [ $? = 77 ]; }
try root
try release
if docker info >/dev/null 2>&1; then
  docker build -q -t "veridyn:$version" . && docker run --rm "veridyn:$version" info psm-3dof >/dev/null
else
  echo "There is no container engine: the commands of the Dockerfile run on a bare Debian root."
  try docker
fi
ls "$out"
