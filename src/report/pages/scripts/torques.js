// What pages about torques share: verdict per joint, errors, torque over time, residuals against
// the motion, friction against speed, parameters with their intervals.

const kStates = {
  at_floor: ['good', 'at the floor'], named: ['good', 'named'], unnamed: ['bad', 'not named'], cannot_tell: ['fair', 'cannot be told'],
  unexplained: ['bad', 'something is missing'], hardly_moved: ['fair', 'hardly moved: record it again'],
  no_torque: ['bad', 'no torque recorded'],
  unknown: ['fair', 'no floor known']
};

function heldOutPlace() {
  if (result.extended) return '/extended/test/relative_error';
  return result.test ? '/test/relative_error' : '/train/relative_error';
}

/** What the result's own verdict says of a joint. */
function saidOf(joint) {
  return verdictList().find((v) => v.joint === joint);
}

/** A verdict's state in the text's words. */
function stateWords(v) {
  if (v.state === 'named' && v.named < 0.995 * v.removable) return 'named in part';
  return (kStates[v.state] || ['', words(v.state)])[1];
}

/** The verdict's entries, one a joint, where the result has any. */
function verdictList() {
  return Array.isArray(result.verdict) ? result.verdict : (result.verdict || {}).joints || [];
}

/** What each joint's held-out error is made of, in numbers. */
function verdictTable() {
  const list = verdictList().filter((v) => isNumber(v.named));
  return list.length ? [
    heading('What it is made of'), paragraph('note', 'Held-out error of the model as it stands = its floor + what findings with names take + what signals without a name predict + what is left. The floor is the ' +
        'scatter between repeats of a motion; where nothing repeats, what a regression on smooth functions of the motion leaves over.'),
    table(['Joint', 'State', '#Held out', '#Floor', '#Named', '#Without a name', '#Left', 'Why'], list.map((v) => {
      const place = '/verdict/' + result.verdict.indexOf(v) + '/';
      return [strong(shortJoint(v.joint)), stateWords(v), ...['held_out', 'floor', 'named', 'unnamed', 'left'].map((part) => percent(place + part)), v.why ? typeset(v.why) : ''];
    }), 'verdict-parts')] : null;
}

/** One entry a joint: {joint, error, floor: places, ratio, state}. */
function verdictRows() {
  return series.joints.map((_, i) => {
    const error = heldOutPlace() + '/' + i;
    const floor = '/noise_floor/relative_error/' + i;
    const said = saidOf(i + 1);
    const ratio = isNumber(valueAt(floor)) && valueAt(floor) > 0 && isNumber(valueAt(error)) ? valueAt(error) / valueAt(floor) : null;
    const state = said && kStates[said.state] ? said.state : 'unknown';  // the judgement is the result's own
    return {joint: i + 1, error, floor, ratio, state, advice: said && said.advice};
  });
}

/** Bars: error over noise floor by joint, on a logarithmic scale; the error itself where no floor is known. */
function verdictBars(rows) {
  const overFloor = rows.some((r) => r.ratio !== null);
  const value = (r) => overFloor ? r.ratio : valueAt(r.error);
  const top = overFloor ? Math.max(10, ...rows.map((r) => r.ratio || 0)) * 1.15 : Math.max(1e-6, ...rows.map((r) => valueAt(r.error) || 0));
  const range = overFloor ? [0.5, top] : [0, top];
  return rowChart({
    name: 'verdict', joint: 0, title: overFloor ? 'Error over noise floor' : 'Error, in share of the torque', width: 560, left: 110, right: 210, range, log: overFloor,
    marks: overFloor ? [{at: 1, text: '1', kind: 'floor-line'}].concat([3, 10, 30, 100, 300].filter((at) => at < top).map((at) => ({at, text: '\u00d7' + at}))) : [],
    keys: [...new Set(rows.map((r) => r.state))].map((s) => key(kStates[s][1], kStates[s][0])),
    rows: rows.map((r) => ({
      label: shortJoint(r.joint), title: jointName(r.joint) + ': ' + kStates[r.state][1],
      parts: isNumber(value(r)) ? [{from: range[0], to: value(r), colour: kStates[r.state][0]}] : [],
      value: [drawing('tspan', {class: 'strong'}, r.ratio === null ? '' : '\u00d7' + short(r.ratio, 2) + '  '), drawnNumber(r.error), ' %',
              r.ratio === null ? '' : [' against ', drawnNumber(r.floor), ' %']]
    })),
  });
}

function jointsOf(rows) {
  return listed(rows.map((r) => String(r.joint)));
}

/** Bars of what each joint's held-out error is made of, where the verdict adds up. */
function verdictParts() {
  const list = verdictList().filter((v) => isNumber(v.held_out) && isNumber(v.named));
  if (!list.length) return null;
  const kinds = [['floor', 'quiet', 'noise floor'], ['named', 'good', 'named'], ['unnamed', 'bad', 'without a name'], ['left', 'fair', 'not to be told']];
  const top = Math.max(1e-9, ...list.map((v) => Math.max(v.held_out, v.floor)));
  return rowChart({
    name: 'verdict', joint: 0, title: 'What the held-out error is made of', width: 560, left: 110, right: 200, range: [0, top], keys: kinds.map(([, style, words]) => key(words, style)),
    rows: list.map((v) => {
      let at = 0;
      const place = '/verdict/' + result.verdict.indexOf(v);
      return {label: shortJoint(v.joint), title: jointName(v.joint) + (v.why ? ': ' + v.why : ''), parts: kinds.filter(([k]) => v[k] > 0).map(([k, style]) => ({from: at, to: at += v[k], colour: style})),
              value: [drawing('tspan', {class: 'strong'}, stateWords(v) + '  '), drawnNumber(place + '/held_out'), ' %']};
    })});
}

/** "Joints 1, 2 are at the noise floor; 3 leaves 12 times it." */
function verdictSentence(rows) {
  const good = rows.filter((r) => r.state === 'at_floor' || r.state === 'named');
  const rest = rows.filter((r) => !good.includes(r) && r.ratio !== null);
  const plural = (list, one, many) => (list.length === 1 ? 'Joint ' : 'Joints ') + jointsOf(list) + ' ' + (list.length === 1 ? one : many);
  const parts = [];
  if (good.length === rows.length && rows.length > 1) return 'All ' + rows.length + ' joints are predicted as well as repeats of a motion are alike.';
  if (good.length) parts.push(plural(good, 'is at the noise floor', 'are at the noise floor'));
  if (rest.length) parts.push(plural(rest, 'leaves ', 'leave ') + listed(rest.map((r) => short(r.ratio, 2))) + ' times the noise');
  return parts.length ? parts.join('; ').replace('; Joint', '; joint') + '.' : 'No motion was repeated, so that the noise floor is not known.';
}

/** What is wrong with the recordings, as paragraphs. */
function heldOutWarnings(test, train) {
  if (!test) return [paragraph('warning', 'Nothing is held out: the error is that of the recordings that the model was fitted to. Give --test.')];
  if ((result.warnings || []).length) return result.warnings.map((words) => paragraph('warning', words + '.'));
  const key = (r) => JSON.stringify([r.source, r.relative_error]);
  const same = (test.recordings || []).filter((r) => ((train || {}).recordings || (train || {}).sources || []).some(
      (other) => other === r.source || other.source === r.source || JSON.stringify(other.relative_error) === JSON.stringify(r.relative_error)));
  return same.length ? [paragraph('warning', listed(same.map((r) => fileName(r.source))) + (same.length === 1 ? ' was' : ' were') + ' learned from and tested on: not held out.')] : [];
}

/** Errors per joint as a table with bars. @param columns  [{name, place, kind}]; kind, if given, makes a bar. */
function errorTable(columns, floor) {
  const there = columns.filter((c) => c && Array.isArray(valueAt(c.place)) && valueAt(c.place).length);
  const bars = there.filter((c) => c.kind);
  const largest = Math.max(1e-12, ...bars.flatMap((c) => valueAt(c.place)).filter(isNumber));
  const width = (pointer) => (100 * valueAt(pointer) / largest).toFixed(2) + '%';
  const graph = (i) => element(
      'div', {class: 'bars', 'aria-hidden': 'true'},
      bars.filter((c) => isNumber(valueAt(c.place + '/' + i))).map((c) => element('i', {class: c.kind, style: 'width:' + width(c.place + '/' + i)})),
      isNumber(valueAt(floor + '/' + i)) ? element('b', {style: 'left:' + width(floor + '/' + i)}) : null);
  return table(
      ['Joint', ...there.map((c) => '#' + c.name), ...(bars.length ? [{name: 'With the noise floor', kind: 'graph'}] : [])],
      series.joints.map((joint, i) => [strong(i + 1 + ' ' + joint.name), ...there.map((c) => percent(c.place + '/' + i)), ...(bars.length ? [graph(i)] : [])]), 'errors');
}

const curveWords = () => ({measured: 'measured', model: result.command === 'identify' ? 'identified model' : 'model as it stands', extended: 'extended model'});
const curveStyle = (name) => result.command === 'identify' && name === 'model' ? 'extended' : name;

function torquePlots(recording, joint) {
  const data = recording.joints[joint - 1];
  const names = curvesOf(data);
  const curve = (name, values) => ({name: curveWords()[name], style: curveStyle(name), values});
  const unit = series.joints[joint - 1].torque_unit;
  return [
    {kind: 'time', title: 'Torque', unit, curves: names.map((n) => curve(n, data[n]))},
    {kind: 'error', title: 'Left over', unit, curves: names.slice(1).map((n) => curve(n, residualOf(data, n)))}
  ];
}

/** The torque of one joint for the first screen. */
function torquePicture(joint) {
  const recording = series.recordings.find((r) => r.time.length);
  if (!recording) return null;
  const data = recording.joints[joint - 1];
  const step = Math.ceil(recording.time.length / 700);
  const marks = curvesOf(data).map((name) => ({
    kind: 'line', name: curveWords()[name], colour: kCurve[curveStyle(name)][0], width: name === 'measured' ? 4 : 1.4,
    points: recording.time.map((t, k) => [t, data[name][k]]).filter((_, k) => k % step === 0)}));
  return chart({name: 'torque', joint, title: jointName(joint) + ', torque of ' + fileName(recording.source), x: {name: 'time [s]'},
                y: {name: series.joints[joint - 1].torque_unit}, width: 520, height: 270, marks});
}

// ---- what is left, against the motion

const kSteps = 25;   // of the horizontal axis, for the means
const kFewest = 5;   // samples for a mean
const quantities = [['q', 'position', ''], ['dq', 'velocity', '/s'], ['ddq', 'acceleration', '/s\u00b2']];

/** Mean of the points in each step of the range: [[middle of the step, mean], ...]. */
function means(points, [low, high]) {
  const sums = Array.from({length: kSteps}, () => [0, 0]);
  for (const [a, b] of points) {
    const sum = sums[Math.min(kSteps - 1, Math.max(0, Math.floor(kSteps * (a - low) / (high - low))))];
    sum[0] += 1;
    sum[1] += b;
  }
  return sums.map(([count, sum], k) => [low + (k + 0.5) * (high - low) / kSteps, count >= kFewest ? sum / count : null]);
}

/** Points of values by the direction in which the joint moves, with their means. */
function byDirection(x, values, speed, range) {
  return ['forward', 'backward'].flatMap((name, k) => {
    const points = [];
    values.forEach((v, i) => v !== null && x[i] !== null && speed[i] && (speed[i] > 0) === (k === 0) && points.push([x[i], v]));
    return [{kind: 'dots', name, colour: name, points},
            {kind: 'line', name: name + ', mean', colour: name, width: 2.4, silent: true, points: means(points, range)}];
  });
}

function residualRow(recording, joint, mover, name, yRange) {
  const motion = recording.joints[mover - 1];
  const residual = residualOf(recording.joints[joint - 1], name);
  return quantities.map(([key, quantity, per]) => {
    const range = rangeOf([motion[key]]);
    const figure = chart({
      name: 'residual', joint, title: (name === 'extended' ? 'Extended: ' : result.command === 'identify' ? '' : 'As it stands: ') + 'against ' + quantity,
      x: {name: quantity + ' [' + series.joints[mover - 1].unit + per + ']', range}, y: {name: series.joints[joint - 1].torque_unit, range: yRange},
      width: 340, height: 210, marks: byDirection(motion[key], residual, motion.dq, range)});
    figure.dataset.model = name;
    figure.dataset.against = key;
    return figure;
  });
}

/** Over time and against the motion: two sections with one choice of recording and joint. */
function torqueSections(about) {
  const place = element('div', {id: 'residual-plots'});
  let against = 0;
  const more = {
    choosers: (draw) => [chooser('Residual against', [{options: [[0, 'the joint itself']].concat(jointOptions())}], (value) => {
      against = Number(value);
      draw();
      noteState();
    })],
    draw: (recording, joints) => place.replaceChildren(...joints.flatMap((joint) => {
      const data = recording.joints[joint - 1];
      const names = curvesOf(data).slice(1);
      const yRange = rangeOf(names.map((name) => residualOf(data, name)));
      return [heading(jointName(joint) + (against && against !== joint ? ', against the motion of ' + jointInText(against) : '')),
              element('div', {class: 'residual-grid'}, names.flatMap((name) => residualRow(recording, joint, against || joint, name, yRange)))];
    }))
  };
  const panel = timePanel(torquePlots, more, about);
  return panel ? [
    section('over-time', 'Torque over time', 'Torques and, beneath them, what each model leaves. Drag across a plot to zoom, all joints follow; a double click shows all again.', panel),
    section('residuals', 'What is left, against the motion', 'Measured minus modelled torque at every sample, in the colour of the direction of motion, with the mean in steps of the ' +
        'horizontal axis. A line that is flat and at zero has nothing left to explain.', place)
  ] : [];
}

// ---- friction

function interpolated(xs, ys, at) {
  if (at <= xs[0]) return ys[0];
  for (let k = 1; k < xs.length; ++k) {
    if (at <= xs[k]) return ys[k - 1] + (ys[k] - ys[k - 1]) * (at - xs[k - 1]) / (xs[k] - xs[k - 1]);
  }
  return ys[ys.length - 1];
}

/** The identified curve with its band over the data: what the rest of the model leaves for friction. */
function frictionChart({joint, velocity, torque, half}, size) {
  const recording = series.recordings.find((r) => r.time.length);
  const data = recording && recording.joints[joint - 1];
  const name = data && (data.extended && result.command === 'diagnose' ? 'extended' : 'model');
  const dots = data ? residualOf(data, name).map((r, k) => r === null ? null : [data.dq[k], r + interpolated(velocity, torque, data.dq[k])]).filter(Boolean) : [];
  const units = series.joints[joint - 1];
  return chart({
    name: 'friction', joint, title: jointName(joint), x: {name: 'velocity [' + units.unit + '/s]'}, y: {name: units.torque_unit}, ...size,
    marks: [{kind: 'dots', name: 'data', colour: 'measured', points: dots},
            {kind: 'band', name: '95 % of the curve', colour: 'extended', points: velocity.map((v, k) => [v, torque[k] - half[k], torque[k] + half[k]])},
            {kind: 'line', name: 'identified', colour: 'extended', width: 2.2, points: velocity.map((v, k) => [v, torque[k]])}]});
}

function frictionSection() {
  const there = (series.friction || []).filter((f) => f.torque.some((v) => v !== 0));
  return section(
      'friction', 'Friction', 'Torque that depends on the speed: what the model says, with 95 % of its curve, over what the rest of the model leaves for it ' +
          '(component plus residual). Dots that leave the curve in a pattern are friction that the model does not have.',
      grid(there.map((f) => frictionChart(f, {width: 420, height: 240}))),
      jointTable((result.friction || []).map((f) => ({...f, name: f.effect + '(' + f.coordinate + ').' + f.parameter})), '/friction'));
}

// ---- parameters

const kNormal95 = 1.96;

// Effects of one joint beside each other: standard parameters "effect(place).name".
function jointTable(list, place) {
  const parts = list.map((p, k) => ({...p, k, match: /^([^(]+)\(([^,)]+)[^)]*\)\.(.+)$/.exec(p.name)})).filter((p) => p.match && isNumber(p.value));
  if (!parts.length) return null;
  const effects = [...new Set(parts.map((p) => p.match[1] + '\n' + p.match[3]))];
  const places = [...new Set(parts.map((p) => p.match[2]))];
  const cell = (where, effect) => {
    const one = parts.find((p) => p.match[2] === where && p.match[1] + '\n' + p.match[3] === effect);
    if (!one) return null;
    const write = isNumber(one.std) && one.std > 1e-9 ? fixed(Math.min(8, Math.max(0, 1 - Math.floor(Math.log10(one.std))))) : undefined;
    return [number(place + '/' + one.k + '/value', 'plain', write), isNumber(one.std) ? ['\u202f\u00b1\u202f', number(place + '/' + one.k + '/std', 'plain', write)] : '',
            element('span', {class: 'unit'}, ' ' + typeset(one.unit))];
  };
  const header = (effect) => {
    const [name, part] = effect.split('\n');
    return '#' + words(name) + (effects.filter((e) => e.startsWith(name + '\n')).length > 1 ? ', ' + words(part) : '');
  };
  return table(['Axis', ...effects.map(header)], places.map((where) => [strong(where), ...effects.map((effect) => cell(where, effect))]), 'by-joint');
}

/** Dots with 95 % intervals, one drawing a unit; a tick where the robot file has a value. */
function parameterDots(list, file) {
  const said = (item) => file && file.get(item.name);
  return groupBy(list, (p) => p.unit).map((group) => {
    const shown = group.filter(({item}) => isNumber(item.value)).slice(0, 24);
    const reach = Math.max(1e-12, ...shown.map(({item}) => Math.abs(item.value) + kNormal95 * (item.std || 0)), ...shown.map(({item}) => Math.abs(said(item) || 0)));
    return rowChart({
      name: 'intervals', joint: 0, title: 'In ' + typeset(group[0].item.unit), width: 560, left: 190, right: 110, range: [-reach, reach],
      marks: [{at: 0, text: '0', kind: 'zero'}, {at: -reach, text: short(-reach, 2)}, {at: reach, text: short(reach, 2)}],
      rows: shown.map(({item}) => ({
        label: item.name.length > 28 ? item.name.slice(0, 27) + '\u2026' : item.name, title: item.expression || item.name,
        parts: [{from: item.value - kNormal95 * (item.std || 0), to: item.value + kNormal95 * (item.std || 0), colour: 'quiet', thin: true}],
        dots: [{at: item.value, colour: 'extended'}].concat(isNumber(said(item)) ? [{at: said(item), colour: 'model', tick: true}] : []),
        value: isNumber(item.std) && item.value ? '\u00b1' + short(100 * item.std / Math.abs(item.value), 2) + ' %' : ''
      }))});
  });
}

// The value with two digits of its deviation.
function baseRow(one, k, place) {
  const write = isNumber(one.std) && one.std > 1e-7 && Math.abs(one.value) < 1e5 ? fixed(Math.max(0, 1 - Math.floor(Math.log10(one.std)))) : undefined;
  return [
    element('span', {class: 'expression'}, (one.expression || one.name).replace(/(^| )- ?/g, '$1\u2212 ')),
    number(place + '/' + k + '/value', 'plain', write), number(place + '/' + k + '/std', 'plain', write), typeset(one.unit)
  ];
}

const baseTable = (list, place) => table(['Base parameter', '#Value', '#Std. deviation', 'Unit'], list.map((one, k) => baseRow(one, k, place)), 'base');
