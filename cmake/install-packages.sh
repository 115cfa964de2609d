#!/bin/sh
# Installs the Debian packages listed in the given files that are missing; does nothing where all are there.
set -eu
wanted=$(sed 's/#.*//' "$@" | tr '\n' ' ')
missing=""
for package in $wanted; do
  dpkg-query -W -f='${Status}' "$package" 2>/dev/null | grep -q 'install ok installed' || missing="$missing $package"
done
[ -z "$missing" ] && exit 0
root=""
[ "$(id -u)" = 0 ] || root="sudo"
echo "Installing:$missing"
if ! command -v apt-get >/dev/null 2>&1; then
  echo "This is not a Debian system; please install the equivalents of:$missing" >&2
  exit 1
fi
export DEBIAN_FRONTEND=noninteractive
$root apt-get update -qq
$root apt-get install -y -qq --no-install-recommends $missing >/dev/null
