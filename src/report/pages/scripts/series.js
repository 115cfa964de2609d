// What figures show: {command, joints, arms, recordings, ...}, see page_series.hpp. Columns of
// numbers come as 16-bit steps between their ends and are unpacked here.

function unpacked(column) {
  const bytes = atob(column.int16);
  return Array.from({length: bytes.length / 2}, (_, k) => {
    const step = bytes.charCodeAt(2 * k) | bytes.charCodeAt(2 * k + 1) << 8;
    return step === 0xffff ? null : column.from + step * column.step;
  });
}

const series = JSON.parse(
    byId('series').textContent, (_, value) => value && value.int16 !== undefined ? unpacked(value) : value);

const kGap = 2.5;  // median steps without a sample are a gap

/** "Joint 2, pitch", from its number (from 1); 0 is the whole arm. */
function jointName(joint) {
  const known = series.joints[joint - 1];
  if (!known) return joint ? 'Joint ' + joint : 'Whole arm';
  return 'Joint ' + joint + ', ' + known.name;
}

/** The same within a sentence; a joint's own name keeps its capitals. */
function jointInText(joint) {
  const name = jointName(joint);
  return name[0].toLowerCase() + name.slice(1);
}

function shortJoint(joint) {
  const known = series.joints[joint - 1];
  return known ? joint + '\u00a0' + known.name : joint ? String(joint) : 'whole arm';
}

function jointOptions() {
  return series.joints.map((_, i) => [i + 1, jointName(i + 1)]);
}

function median(values) {
  const sorted = values.filter(isNumber).sort((a, b) => a - b);
  return sorted.length ? sorted[sorted.length >> 1] : 0;
}

/** Indices of the samples before which the recording has a gap. */
function gapsOf(recording) {
  const steps = recording.time.slice(1).map((t, k) => t - recording.time[k]);
  const usual = median(steps);
  return new Set(steps.flatMap((step, k) => step > kGap * usual ? [k + 1] : []));
}

function difference(a, b) {
  return a.map((value, k) => value === null || b[k] === null ? null : value - b[k]);
}

/** Curves of one joint that are there: measured, model and, where something was found, extended. */
function curvesOf(joint) {
  return ['measured', 'model', 'extended'].filter((name) => joint[name]);
}

/** Measured minus modelled, for "model" or "extended". */
function residualOf(joint, name) {
  return difference(joint.measured, joint[name]);
}

/** Rows [time, value of each column]; a row of nulls at every gap, so that no line crosses it. */
function rowsOf(recording, columns) {
  const gaps = gapsOf(recording);
  const rows = [];
  recording.time.forEach((t, k) => {
    if (gaps.has(k)) rows.push([(recording.time[k - 1] + t) / 2, ...columns.map(() => null)]);
    rows.push([t, ...columns.map((column) => column[k])]);
  });
  return rows;
}

function rangeOf(lists) {
  let low = Infinity;
  let high = -Infinity;
  for (const values of lists) {
    for (const v of values) {
      if (!isNumber(v)) continue;
      if (v < low) low = v;
      if (v > high) high = v;
    }
  }
  if (!(high > low)) return isNumber(low) ? [low - 1, low + 1] : [-1, 1];
  const pad = 0.03 * (high - low);
  return [low - pad, high + pad];
}

// ---- colours: names of the style sheet, which has them for light and dark

const kCurve = {  // colour of a curve's style, and its width: each line is seen on the one below it
  recorded: ['measured', 5], measured: ['measured', 5], model: ['model', 2.6], wanted: ['model', 2.6],
  simulated: ['extended', 1.2], extended: ['extended', 1.2], limit: ['limit', 1],
  x: ['model', 1.3], y: ['extended', 1.3], z: ['forward', 1.3],
  'x wanted': ['pale-model', 5], 'y wanted': ['pale-extended', 5], 'z wanted': ['pale-forward', 5]
};

function colour(name) {
  return getComputedStyle(document.documentElement).getPropertyValue('--' + name).trim();
}

function key(name, colourName) {
  return element('span', {class: 'key'}, element('i', {style: 'background:var(--' + colourName + ')'}), name);
}
