#!/bin/sh
# Inside a bare Debian root: installs what /release holds, one package after the other, each with what it needs and no more, and
# uses it as the README says; then removes it and looks for what is left: installed.sh FOLDER, which does not count.
set -eu
cd /release
sha256sum --check --quiet SHA256SUMS
tar -xzf veridyn-[0-9]*[0-9].tar.gz -C /tmp
source=$(echo /tmp/veridyn-*)
install() {
  apt-get install -y -qq --no-install-recommends "$@" >/tmp/log 2>&1 || { cat /tmp/log; exit 1; }
  echo "installed: $*"
}
apt-get update -qq

install ./libveridyn[0-9]*.deb ./veridyn_*.deb
veridyn --version
ls /usr/share/man/man1/veridyn-identify.1.gz >/dev/null
for row in dvrk:dvrk cooperation:cooperate calibration:calibrate; do
  command=${row#*:}
  status=0
  veridyn "$command" --help >/dev/null 2>/tmp/said || status=$?
  [ $status = 2 ] && [ "$(wc -l </tmp/said)" = 1 ] || { echo "veridyn $command without its package: status $status"; cat /tmp/said; exit 1; }
  install ./veridyn-"${row%:*}"_*.deb
  veridyn "$command" --help >/dev/null
  ls "/usr/share/man/man1/veridyn-$command.1.gz" >/dev/null
done

install ./python3-veridyn_*.deb
python3 -c 'import veridyn; print("Python module", veridyn.__version__)'
cd "$source"
export VERIDYN_SOURCE="$source"
for page in README.md docs/own-robot.md; do python3 tests/readme/blocks.py check "$page" /tmp/blocks; done

cd /release
install ./libveridyn-dev_*.deb g++ cmake make
cmake -S "$source/examples/own_project" -B /tmp/own >/tmp/log && cmake --build /tmp/own >>/tmp/log || { cat /tmp/log; exit 1; }
/tmp/own/controller "$source/data/robots/planar-2r.yaml" >/dev/null

apt-get purge -y -qq '*veridyn*' >/dev/null
left=$(find / -xdev \( -path /release -o -path /release.sh -o -path /tmp -o -path /proc -o -path "$1" \) -prune -o -name '*veridyn*' -print)
[ -z "$left" ] || { echo "left behind: $left"; exit 1; }

install python3-venv
python3 -m venv --system-site-packages /tmp/env
/tmp/env/bin/pip install --quiet --no-index --no-deps veridyn-*.whl
(cd /tmp && /tmp/env/bin/python -c 'import veridyn; print("wheel", veridyn.__version__, veridyn.read_model("psm-3dof").joints, "joints")')
echo "installed, used and removed"
