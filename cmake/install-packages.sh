#!/bin/sh
# Installs the packages listed in the given files that are missing; does nothing where all are there. The lists have Debian's
# names; what another distribution lacks of them is in not-in-ID-VERSION.txt beside this script.
set -eu
ID="" VERSION_ID=""
[ ! -r "${OS_RELEASE:-/etc/os-release}" ] || . "${OS_RELEASE:-/etc/os-release}"
absent=" $(sed 's/#.*//' "$(dirname "$0")/not-in-$ID-$VERSION_ID.txt" 2>/dev/null | tr '\n' ' ') "
wanted=$(sed 's/#.*//' "$@" | tr '\n' ' ')
missing=""
for package in $wanted; do
  case $absent in *" $package "*) continue ;; esac
  dpkg-query -W -f='${Status}' "$package" 2>/dev/null | grep -q 'install ok installed' || missing="$missing $package"
done
[ -z "$missing" ] && exit 0
if [ -n "${LIST_ONLY:-}" ]; then
  echo "$missing"
  exit 0
fi
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
