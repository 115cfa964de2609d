#!/bin/sh
# The pictures of the book, picture-*.png: pages of the tool as a browser shows them. Needs veridyn in PATH and chromium.
#   docs/pictures.sh
set -eu
top=$(cd "$(dirname "$0")/.." && pwd)
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
ln -s "$top/examples" examples

# picture NAME PAGE [HEIGHT]: the first screen of a page
picture() {
  chromium --headless --no-sandbox --disable-gpu --hide-scrollbars --force-device-scale-factor=1 --virtual-time-budget=3000 \
    --window-size="1100,${3:-760}" --screenshot="$(dirname "$(find "$top/docs" "$top"/packages/*/docs -name "picture-$1.png")")/picture-$1.png" "file://$folder/$2" >/dev/null 2>&1
}

veridyn excite ur10e -o motion.csv --seed 2 --report excitation.html --quiet >/dev/null
veridyn excite psm-3dof -o swing.csv --quiet >/dev/null
veridyn excite psm-3dof -o other.csv --seed 7 --quiet >/dev/null
for n in 1 2; do veridyn simulate psm-3dof --trajectory swing.csv -o "$n.csv" --arm-seed 4 --seed $n --noise dvrk --quiet >/dev/null; done
veridyn simulate psm-3dof --trajectory other.csv -o other-rec.csv --arm-seed 4 --seed 3 --noise dvrk --quiet >/dev/null
for w in quiet loaded; do
  veridyn simulate psm-3dof --trajectory other.csv -o $w.csv --arm-seed 4 --seed 4 --noise dvrk --quiet $([ $w = quiet ] || echo "--effect payload:tool:mass=0.2") >/dev/null
done
awk -F, 'FNR==NR { if (FNR == 1 || $1 < 15) print; next } FNR > 1 && $1 >= 15' quiet.csv loaded.csv >picked-up.csv
veridyn check psm-3dof 1.csv --report recordings.html --quiet >/dev/null
veridyn identify psm-3dof --train 1.csv 2.csv --test other-rec.csv --model-out model.yaml --report identification.html --quiet >/dev/null
veridyn watch model.yaml picked-up.csv --report watch.html --quiet >/dev/null
veridyn info psm-3dof --report robot-files.html --quiet >/dev/null
veridyn stability examples/cooperate/two-arms-spring.yaml --map gain=0.1:12:25,delay=0:0.03:25 --report stability.html --quiet >/dev/null
veridyn cooperate examples/cooperate/two-arms-spring.yaml --report cooperation.html --quiet >/dev/null
veridyn excite psm-3dof --for calibration --frame counterweight --poses 30 -o postures.csv --quiet >/dev/null
veridyn kinematics psm-3dof --forward postures.csv --frame counterweight -o poses.csv --quiet >/dev/null
veridyn calibrate links psm-3dof-printed poses.csv --frame counterweight --report calibration.html --quiet >/dev/null
VERIDYN_DEMO=0 "$top/examples/demo.sh" "$(command -v veridyn)" demo >/dev/null
veridyn diagnose psm-3dof --train demo/changed-1.csv demo/changed-2.csv demo/changed-3.csv --test demo/changed-test.csv --report diagnosis.html --quiet >/dev/null
veridyn page . -o pages.html --quiet >/dev/null
for page in excitation recordings identification diagnosis watch robot-files stability cooperation calibration pages; do
  picture $page $page.html
done
