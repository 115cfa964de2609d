// What the plots show: joints, and recordings with their motion and torques.

const series = JSON.parse(byId('series').textContent);

const colours = {
  measured: '#a3a39c',
  model: '#cf5b13',
  extended: '#0f6ab4',
  forward: '#0d7a72',
  backward: '#b5179e',
};
const curveNames = {
  measured: 'measured',
  model: 'model as it stands',
  extended: 'extended model'
};
if (result.command === 'identify') {
  curveNames.model = 'identified model';
  colours.model = colours.extended;
}

const kGap = 2.5;  // median steps without a sample are a gap

/** "Joint 2, pitch", from its number (from 1); 0 is the whole arm. */
function jointName(joint) {
  const known = series.joints[joint - 1];
  if (!known) return joint ? 'Joint ' + joint : 'Whole arm';
  return 'Joint ' + joint + ', ' + known.name;
}

function median(values) {
  const sorted = [...values].sort((a, b) => a - b);
  return sorted.length ? sorted[sorted.length >> 1] : 0;
}

/** Indices of the samples before which the recording has a gap. */
function gapsOf(recording) {
  const steps = recording.time.slice(1).map((t, k) => t - recording.time[k]);
  const usual = median(steps);
  return new Set(steps.flatMap((step, k) => step > kGap * usual ? [k + 1] : []));
}

/** Curves of one joint that are there: measured, model and, where something was found, extended. */
function curvesOf(joint) {
  return ['measured', 'model', 'extended'].filter((name) => joint[name]);
}

function difference(a, b) {
  return a.map((value, k) => value === null || b[k] === null ? null : value - b[k]);
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
