#!/bin/sh
# The whole way on a built-in example: excite -> simulate -> identify -> compare with the truth -> diagnose a hidden effect.
#
#   demo.sh TOOL FOLDER      TOOL: the veridyn program; FOLDER: where the files go
set -eu
tool=$1
out=$2
robot=psm-3dof
mkdir -p "$out"

step() { printf '\n== %s\n' "$*"; }

step "1. Two motions for $robot that determine its parameters: one to identify from, one held out"
"$tool" excite "$robot" -o "$out/train-motion.csv" --criterion d-optimal --frequency 0.13 --seed 1 \
  --quiet --json "$out/excite.json"
"$tool" excite "$robot" -o "$out/test-motion.csv" --criterion condition --frequency 0.17 --seed 2 --quiet >"$out/test-motion.txt"
sed -n 's/^Condition/The held-out one: condition/p' "$out/test-motion.txt"

step "2. A simulated arm makes them, with the noise of a da Vinci Research Kit arm"
"$tool" simulate "$robot" --trajectory "$out/train-motion.csv" -o "$out/train.csv" \
  --noise dvrk --seed 1 --model-out "$out/truth.yaml"
"$tool" simulate "$out/truth.yaml" --trajectory "$out/test-motion.csv" -o "$out/test.csv" --noise dvrk --seed 2

step "3. Identification, which sees the recordings and nothing of the truth"
"$tool" identify "$robot" --train "$out/train.csv" --test "$out/test.csv" --quiet \
  --model-out "$out/identified.yaml" --json "$out/identified.json" >"$out/identified.txt"
sed '/noise floor/q' "$out/identified.txt"

step "4. What was found, against the truth"
"$tool" info "$out/truth.yaml" --quiet --json "$out/truth.json" >/dev/null
# The base parameters of both files by name: those with the smallest intervals, relative to their values.
awk '
  /"base_parameters": \[/ { inside = 1 }
  inside && /^  \]/ { inside = 0 }
  inside && /^      "name": / { name = $0; sub(/.*"name": "/, "", name); sub(/",?$/, "", name) }
  inside && /^      "value": / { value = $2; sub(/,/, "", value)
    if (FILENAME == ARGV[1]) truth[name] = value; else found[name] = value }
  inside && /^      "std": / && FILENAME != ARGV[1] { std = $2; sub(/,/, "", std); error[name] = std }
  inside && /^      "unit": / && FILENAME != ARGV[1] { unit = $0; sub(/.*: "/, "", unit); sub(/".*/, "", unit)
    if (!(name in truth)) next
    size = found[name] < 0 ? -found[name] : found[name]
    printf "%.6f\t%-34s %12.5f %12.5f +- %.5f  %s\n", error[name] / (size + 1e-12), name, truth[name], found[name], error[name], unit }
' "$out/truth.json" "$out/identified.json" >"$out/compared.txt"
printf '%-34s %12s %12s\n' "base parameter" "truth" "identified"
sort -n "$out/compared.txt" | head -n 10 | cut -f 2-

step "5. The same arm with something in it that the model does not know"
# One of four, drawn at random, as a user would meet it; VERIDYN_DEMO chooses (0 to 3).
case ${VERIDYN_DEMO:-$(($(date +%s) % 4))} in
  0) hidden=position_dependent_friction:insertion ;;
  1) hidden=position_dependent_friction:yaw ;;
  2) hidden=rotor_inertia:insertion ;;
  *) hidden=position_dependent_viscosity:pitch ;;
esac
for k in 1 2 3; do
  "$tool" excite "$robot" -o "$out/motion-$k.csv" --criterion d-optimal --frequency "0.1$k" --seed "$k" \
    --quiet >/dev/null
  "$tool" simulate "$out/truth.yaml" --trajectory "$out/motion-$k.csv" -o "$out/changed-$k.csv" \
    --noise dvrk --seed "$k" --effect "$hidden" --quiet >/dev/null
done
"$tool" simulate "$out/truth.yaml" --trajectory "$out/test-motion.csv" -o "$out/changed-test.csv" \
  --noise dvrk --seed 9 --effect "$hidden" --quiet >/dev/null
"$tool" diagnose "$robot" --train "$out/changed-1.csv" "$out/changed-2.csv" "$out/changed-3.csv" \
  --test "$out/changed-test.csv" --quiet --model-out "$out/extended.yaml" --json "$out/diagnosis.json" \
  --report "$out/diagnosis.html" >"$out/diagnosis.txt"
sed -n '/^1\. /,/explains/p; /^verdict/p' "$out/diagnosis.txt"

printf '\nThe identified model: %s\nThe extended model:   %s\n' "$out/identified.yaml" "$out/extended.yaml"
# The first finding of the JSON, and what it gained on the held-out recording.
awk -v hidden="$hidden" '
  /^  "findings": \[/ { inside = 1 }
  inside && /^  \]/ { inside = 0 }
  !inside || done { next }
  /^      "effect": / { effect = $2; gsub(/[",]/, "", effect) }
  /^      "joint": / { joint = $2 + 0 }
  /^      "coordinate": / { coordinate = $2; gsub(/[",]/, "", coordinate) }
  /^          "before": \[/ { list = "before"; k = 0; next }
  /^          "after": \[/ { list = "after"; k = 0; next }
  list != "" && /\]/ { if (list == "after") done = 1; list = ""; next }
  list != "" { k = k + 1; if (k == joint) error[list] = 100 * $1 }
  END {
    printf "Hidden was: %s\n", hidden
    if (!done) { print "Found: nothing"; exit }
    printf "Found first: %s:%s; held-out error of this joint: %.2f %% -> %.2f %%\n", effect, coordinate, error["before"], error["after"]
  }' "$out/diagnosis.json"
printf 'The report, for any browser: %s\n' "$out/diagnosis.html"
