// What identify found.

/** 'held out', or 'learned from' where rows of a test recording were fitted to. */
const testName = () => result.test && result.verdict && !result.verdict.held_out ? 'learned from' : 'held out';
const testTitle = () => testName().replace(/^./, (letter) => letter.toUpperCase());

function recordingErrors() {
  const rows = ['test', 'train'].flatMap((part) => (result[part] && result[part].recordings || []).map((recording, k) => [
    strong(fileName(recording.source)), part === 'test' ? testName() : 'training',
    ...series.joints.map((_, i) => percent('/' + part + '/recordings/' + k + '/relative_error/' + i))]));
  return rows.length < 2 ? null : [heading('By recording'), table(['Recording', 'Part', ...series.joints.map((joint, i) => '#' + (i + 1) + ' ' + joint.name)], rows, 'recording-errors')];
}

function identifyNext(rows) {
  const bad = rows.filter((r) => kStates[r.state][0] === 'bad');
  const advice = rows.filter((r) => r.advice && r.state !== 'at_floor').map((r) => ({why: jointName(r.joint) + ': ' + typeset(r.advice)}));
  const command = otherCommand('diagnose', ['--method', '--prior', '--known-mass', '--weights', '--condition', '--signs']);
  if (!result.test || !(result.verdict || {}).held_out) return [{why: 'Record a second motion and hold it out (--test): only that tells how good the model is.'}];
  const why = bad.length ? 'Ask what the model lacks on ' + (bad.length === 1 ? 'joint ' : 'joints ') + jointsOf(bad) + ':' :
      rows.some((r) => r.ratio === null) ? 'Ask whether the model lacks anything:' : 'The model is ready for simulation and control; ask what changes later:';
  return advice.concat(command ? [{why, command}] : []);
}

const kCell = 26;
const kLabels = 230, kShortLabels = 130;  // width of the names beside the cells, and in a narrow window
const kLetter = 7;                        // width of a letter of them

/** Cells in colour: how the errors of the least certain parameters go together. */
function correlationPicture(list) {
  if (!list || !(list.names || []).length || list.names.length < 2) return null;
  const n = list.names.length;
  const labels = fitting(kNarrow, 0) < kNarrow ? kShortLabels : kLabels;
  const width = labels + n * kCell + 70, height = n * kCell + 22;
  const letters = Math.floor(labels / kLetter);
  const brief = (name) => name.length > letters ? name.slice(0, letters - 1) + '\u2026' : name;
  const cells = list.matrix.flatMap((row, i) => row.map((r, k) => drawing(
      'g', {}, drawing('title', {}, list.names[i] + ' and ' + list.names[k] + ': ' + short(r, 2)),
      drawing('rect', {x: labels + k * kCell, y: i * kCell, width: kCell - 1, height: kCell - 1, fill: 'var(--' + (r < 0 ? 'backward' : 'forward') + ')', 'fill-opacity': Math.abs(r).toFixed(2)}),
      Math.abs(r) >= 0.5 && i !== k ? drawing('text', {x: labels + (k + 0.5) * kCell, y: i * kCell + 17, 'text-anchor': 'middle', class: 'tick'}, withMinus(r.toFixed(1)).replace('0.', '.')) : null)));
  const names = list.names.map((name, i) => drawing(
      'g', {}, drawing('text', {x: 0, y: i * kCell + 17, class: 'label'}, i + 1 + '\u2002' + brief(name)),
      drawing('text', {x: width, y: i * kCell + 17, 'text-anchor': 'end', class: 'value'}, '\u00b1' + short(100 * list.relative[i], 2) + ' %'),
      drawing('text', {x: labels + (i + 0.5) * kCell, y: n * kCell + 14, 'text-anchor': 'middle', class: 'tick'}, String(i + 1))));
  const svg = drawing('svg', {viewBox: '0 0 ' + width + ' ' + height, role: 'img', 'aria-label': 'Correlations of the least certain parameters', class: 'chart', style: 'max-width:' + 1.25 * width + 'px'}, names, cells);
  const csv = () => ['', ...list.names].map((name) => '"' + name + '"').join(',') + '\n' + list.matrix.map((row, i) => '"' + list.names[i] + '",' + row.join(',')).join('\n') + '\n';
  let most = [0, 1];
  list.matrix.forEach((row, i) => row.forEach((r, k) => i < k && Math.abs(r) > Math.abs(list.matrix[most[0]][most[1]]) && (most = [i, k])));
  const strongest = list.matrix[most[0]][most[1]];
  return element(
      'figure', {class: 'plot drawn', 'data-plot': 'correlations', 'data-joint': 0, 'data-points': 'cells:' + n * n},
      element('figcaption', {}, 'Correlation of the least certain', saveButtons('correlations', () => svgFile(svg), csv)),
      paragraph('keys', [key('errors alike', 'forward'), key('errors opposite', 'backward')]), svg,
      paragraph('caption', 'Strongest: ' + list.names[most[0]] + ' and ' + list.names[most[1]] + ', ' + withMinus(strongest.toFixed(2)) +
          '. Near \u00b11 the recordings tell a combination of the two and not each of them.'));
}

pages.identify = () => {
  const file = new Map((series.file || []).filter((one) => isNumber(one.value)).map((one) => [one.name, one.value]));
  const rows = verdictRows();
  const worst = rows.reduce((a, b) => (b.ratio || valueAt(b.error) || 0) > (a.ratio || valueAt(a.error) || 0) ? b : a, rows[0]);
  const floor = '/noise_floor/relative_error';
  return {
    title: result.robot, kind: 'Identification',
    facts: [String(result.base_parameters.length), ' base parameters from ', number('/rows', 'whole'), ' rows by ' + words(result.method) + ' least squares; ' +
                (result.feasible ? 'every body is physically possible' : 'not every body is physically possible') + '.'],
    lead: (result.verdict || {}).sentence ? typeset(result.verdict.sentence) + '.' : verdictSentence(rows), state: rows.some((r) => kStates[r.state][0] === 'bad') ? 'bad' : 'good',
    good: [verdictBars(rows), result.status !== 'done' ? paragraph('warning', result.reason) : null, ...heldOutWarnings(result.test, result.train)],
    next: identifyNext(rows),
    picture: worst ? torquePicture(worst.joint) : null,
    sections: [
      section('errors', 'Error per joint', 'Root mean square of measured minus modelled torque, in % of the measured torque. Held out: took no part in the fit; moving: ' +
                  'only samples at which the joint is faster than 2 % of its largest speed. The noise floor is how much the torque of the training recordings differs between ' +
                  'repeats of one motion: about the best that a model can do.',
              errorTable([{name: testTitle(), place: '/test/relative_error', kind: 'extended'}, {name: testTitle() + ', moving', place: '/test/moving/relative_error'},
                          {name: testTitle() + ', largest', place: '/test/max_error'}, {name: 'Training', place: '/train/relative_error', kind: result.test ? undefined : 'extended'},
                          {name: 'Noise floor', place: floor}], floor),
              recordingErrors()),
      frictionSection(),
      section('parameters', 'Parameters', 'Friction, rotor and offset of each joint; then the combinations of inertial and effect parameters that torques determine, with ' +
                  'standard deviations that respect autocorrelation, and their 95 % intervals as bars' + (file.size ? '; orange ticks: the robot file.' : '.'),
              jointTable(result.standard_parameters || [], '/standard_parameters'), baseTable(result.base_parameters, '/base_parameters'),
              grid(parameterDots(result.base_parameters, file)), grid([correlationPicture(series.correlations)])),
      ...torqueSections(worst && worst.joint),
      section('numerics', 'Numerics', null, folded('How well the equations are posed', factList([
        ['Condition number, columns scaled', '/condition_number'], ['Condition number, as they are', '/condition_number_unscaled'], ['Rank gap', '/rank_gap'],
        ['Rows that count after autocorrelation', '/effective_samples'], ['Weighted sum of squares', '/objective'], ['The same without conditions', '/unconstrained_objective'],
        ['Duality gap', '/duality_gap']]),
        (result.active_constraints || []).length ? paragraph('small', 'At the edge of what is possible: ' + result.active_constraints.join(', ') + '.') : null))
    ]
  };
};
