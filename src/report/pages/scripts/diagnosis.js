// What diagnose found: the verdict, each cause over the residual that it explains, what it gains,
// what was ruled out.

const kSentences = 5;        // findings named at the top
const kPictures = 13;        // of causes
const kNoticeable = 0.5;     // other joints are shown where they change by more than this share of the largest change
const kVisibleStep = 0.005;  // of the joint's error as it stands

// Whether a finding is confirmed in training, and what it explains of the held-out recordings.
function statusWords(finding, k) {
  const share = number('/findings/' + k + '/explains', 'share');
  if (finding.outside) return element('span', {class: 'small'}, 'Left out of the fit.');
  if (finding.status !== 'confirmed')
    return element('strong', {class: 'warning'}, 'Not confirmed: parts of the training recordings that are held out are predicted no better with it (', share, '\u00a0%).');
  if (finding.held_out === 'contradicts')
    return element('strong', {class: 'warning'}, 'The held-out recordings are predicted no better with it (', share, '\u00a0%).');
  return element('span', {class: 'small'}, 'Explains ', share, '\u00a0%.');
}

function worseJoints() {
  return (result.summary ? result.summary.worse_joints : []).map((joint) => paragraph(
      'warning', 'The extended model is worse on ', jointInText(joint), ': ',
      fromTo('/baseline/test/relative_error/' + (joint - 1), '/extended/test/relative_error/' + (joint - 1)), '.'));
}

function explainedByMain() {
  const s = result.summary;
  if (!s || s.main_findings >= result.findings.length) return null;
  return paragraph('', s.main_findings === 1 ? 'The first explains ' : ['The first ', number('/summary/main_findings', 'whole'), ' explain '], number('/summary/explained_by_main', 'share'),
                   '\u00a0% of the removable held-out error, all ', String(result.findings.length), ' of them ', number('/summary/explained_by_all', 'share'), '\u00a0%.');
}

// A verdict of an earlier version is one word; of this one a list, one entry a joint.
function unexplained() {
  const list = verdictList();
  const said = {
    unnamed: ['warning', (joints) => joints + ': part of the error has no known cause.'],
    cannot_tell: ['', (joints) => joints + ': these recordings do not tell what the error above the noise floor comes from.']
  };
  return Object.entries(said).map(([state, [kind, sentence]]) => {
    const joints = list.filter((v) => v.state === state).map((v) => ({joint: v.joint}));
    return joints.length ? paragraph(kind, sentence((joints.length === 1 ? 'Joint ' : 'Joints ') + jointsOf(joints))) : null;
  });
}

function diagnosisLead() {
  const count = result.findings.length;
  if (!count) {
    const said = result.verdict_sentence || '';
    return !said || said === 'none' ? 'Nothing found.' : typeset(said.charAt(0).toUpperCase() + said.slice(1)) + '.';
  }
  return (result.changes_since ? 'Since the model was made, the arm has changed in ' : 'The arm differs from the model in ') + (count === 1 ? 'one point' : count + ' points') + '.';
}

function diagnosisWords() {
  const findings = result.findings;
  const main = findings.filter((finding) => finding.main !== false).length;
  const shown = Math.min(main, kSentences);
  const more = findings.length - shown;
  const remarks = result.data_quality || [];
  const faults = remarks.filter((item) => item.severity === 'fault');
  return [
    findings.length ? element('ol', {}, findings.slice(0, shown).map((f, k) => element('li', {}, typeset(f.sentence), ' ', statusWords(f, k)))) : null,
    more > 0 ? paragraph('', 'And ' + more + ' more in the ', element('a', {href: '#findings'}, 'table of findings'), '.') : null,
    findings.length ? explainedByMain() : null, ...unexplained(),
    verdictParts() || verdictBars(verdictRows()),
    ...(findings.length ? worseJoints() : []),
    ...faults.map((item) => paragraph('warning', fileName(item.file) + ': ' + typeset(item.sentence))),
    ...heldOutWarnings(result.baseline.test, {sources: (result.settings || {}).train}),
    result.provisional ? paragraph('warning', 'Learned from one recording only: the names of causes are provisional.') : null,
    remarks.length > faults.length ? paragraph('small', countOf(remarks.length - faults.length, 'remark') + ' on the ', element('a', {href: '#quality'},
        'quality of ' + countOf(new Set(remarks.map((item) => item.file)).size, 'recording')), '.') : null
  ];
}

function diagnosisNext() {
  const next = result.next_experiment;
  const model = wordAfter('--model-out');
  const out = [];
  if (next && next.shows) out.push({why: 'Record what shows it best: ' + typeset(next.shows), command: next.trajectory || undefined});
  else if (next && (next.separates || []).length)
    out.push({why: 'Record what separates ' + next.separates.map(words).join(' from ') + ':', command: next.trajectory});
  if (model) out.push({why: 'Look for a change with the next recordings:', command: 'veridyn diagnose ' + model + ' --train NEW.csv --test OTHER.csv'});
  else if (result.findings.length) out.push({why: 'Write the extended model:', command: otherCommand('diagnose') + ' --model-out extended.yaml'});
  return out.length ? out : null;
}

// ---- each cause over what it explains

/** Values of a signal as findings name it: q1, dq1, ddq1, tau1, t. */
function signalOf(recording, name) {
  const parts = /^(ddq|dq|q|tau)(\d+)$/.exec(name);
  if (name === 't') return {values: recording.time, label: 'time [s]'};
  const joint = parts && recording.joints[Number(parts[2]) - 1];
  if (!joint) return null;
  const units = series.joints[Number(parts[2]) - 1];
  const [, quantity, per] = quantities.find((q) => q[0] === parts[1]) || [];
  return {values: joint[parts[1] === 'tau' ? 'model' : parts[1]],
          label: parts[1] === 'tau' ? 'model\u2019s torque [' + units.torque_unit + ']' : quantity + ' of ' + units.name + ' [' + units.unit + per + ']'};
}

// An unnamed cause's curve, one for each side where its second signal has sides; a function of two signals as three
// curves over the first, at the lowest, the middle and the highest value of the second: [[at, value, low, high], ...].
function curvesOfCause(finding) {
  const curve = finding.curve || [];
  const seconds = [...new Set(curve.map((p) => p.at[1] || 0))].sort((p, q) => p - q);
  const along = (second) => curve.filter((p) => (p.at[1] || 0) === second).map((p) => [p.at[0], p.value, p.band[0], p.band[1]]).sort((p, q) => p[0] - q[0]);
  const at = (second, name, colour) => ({name, colour, points: along(second)});
  if (seconds.length > 2) {
    return [[0, 'backward'], [(seconds.length - 1) >> 1, 'extended'], [seconds.length - 1, 'forward']].map(
        ([k, colour]) => at(seconds[k], finding.signals[1] + ' = ' + short(seconds[k]), colour));
  }
  if (seconds.length === 2) return [at(seconds[1], 'forward', 'forward'), at(seconds[0], 'backward', 'backward')];
  return seconds.map((second) => at(second, 'its curve', 'extended'));
}

// The residual of the model as it stands against the variable of the cause, with what the extended
// model adds there; an unnamed cause as its own curve with its band.
function causePicture(finding, k) {
  const recording = series.recordings.find((r) => r.time.length);
  const joint = finding.joint || 1;
  const data = recording && recording.joints[joint - 1];
  if (!data || (!data.extended && !finding.curve)) return null;
  const units = series.joints[joint - 1];
  const residual = residualOf(data, 'model');
  const unnamed = finding.effect === 'unnamed';
  const signal = signalOf(recording, unnamed ? (finding.signals || ['q' + joint])[0] : series.causes[k] || 'q' + joint);
  if (!signal) return null;
  const curves = unnamed ? curvesOfCause(finding) : [];
  const range = rangeOf([signal.values, ...curves.map((c) => c.points.map((p) => p[0]))]);
  const added = data.extended ? difference(data.extended, data.model) : [];
  const marks = byDirection(signal.values, residual, data.dq, range).filter((m) => m.kind === 'dots');
  if (curves.length) {
    for (const c of curves)
      marks.push({kind: 'band', name: c.name + ', 95 %', colour: c.colour, points: c.points.map((p) => [p[0], p[2], p[3]])},
                 {kind: 'line', name: c.name, colour: c.colour, width: 2.4, points: c.points.map((p) => [p[0], p[1]])});
  } else {
    for (const mean of byDirection(signal.values, added, data.dq, range).filter((m) => m.kind === 'line'))
      marks.push({...mean, name: 'the extended model adds, ' + mean.name.split(',')[0], silent: false});
  }
  return chart({
    name: 'cause', joint, title: (k + 1) + '\u2002' + words(finding.effect) + ', ' + jointInText(finding.joint), x: {name: signal.label, range},
    y: {name: units.torque_unit}, width: 420, height: 240, marks, note: unnamed && finding.shape ? typeset(finding.shape) : null});
}

// ---- tables

function heldOutChange(finding, k) {
  const {before, after} = finding.gain.test_relative_error;
  const change = before.map((b, i) => Math.abs(b - after[i]));
  const most = Math.max(...change);
  const place = '/findings/' + k + '/gain/test_relative_error/';
  return element('ul', {class: 'changes'}, before.map((_, i) => i).filter((i) => i === finding.joint - 1 || change[i] > kNoticeable * most).map(
      (i) => element('li', {}, element('span', {class: 'name'}, series.joints[i] ? series.joints[i].name : i + 1), ' ', fromTo(place + 'before/' + i, place + 'after/' + i))));
}

// Rivals with one reason are named together.
function rivalList(finding) {
  const name = (rival) => strong(words(rival.effect) + ' (' + (rival.frame ? rival.frame : shortJoint(rival.joint)) + ')');
  return groupBy(finding.rivals || [], (rival) => rival.why).map((group) => paragraph(
      'rivals', group.length > 1 ? 'Rivals: ' : 'Rival: ', group.flatMap(({item}, k) => [k ? ', ' : '', name(item)]), ': ' + typeset(group[0].item.why) + '.'));
}

function findingRow(finding, k) {
  const place = '/findings/' + k;
  const where = [finding.frame ? 'frame ' + finding.frame : jointInText(finding.joint), finding.recording && fileName(finding.recording)].filter(Boolean).join(', ');
  const phrase = finding.phrase ? finding.phrase.charAt(0).toUpperCase() + finding.phrase.slice(1) + '.' : finding.sentence;
  const extra = finding.effect === 'unnamed' && finding.signals ? ' Depends on ' + listed(finding.signals) + '.' : '';
  return [
    element('div', {}, element('strong', {class: 'cause'}, number(place + '/rank', 'whole'), '\u2002' + words(finding.effect)), element('span', {class: 'where'}, ', ' + where),
            paragraph('', typeset(finding.remark ? phrase + ' ' + finding.remark : phrase) + extra), rivalList(finding)),
    element('ul', {class: 'parameters'}, Object.keys(finding.parameters || {}).map((name) => element(
        'li', {}, element('span', {class: 'name'}, words(name)), ' ', sizeWithInterval(place + '/parameters/' + pointerKey(name))))),
    number(place + '/p_value', 'chance'), finding.gain ? heldOutChange(finding, k) : null,
    finding.outside ? '' : element('span', {class: finding.status === 'confirmed' ? 'change' : 'warning'}, number(place + '/explains', 'share'), '\u00a0%',
                                   finding.status === 'confirmed' ? '' : ' (not confirmed)')
  ];
}

// Per joint a staircase from the model as it stands to the extended model.
function waterfall(joint) {
  const i = joint - 1;
  const start = '/baseline/test/relative_error/' + i;
  const end = '/extended/test/relative_error/' + i;
  const steps = result.findings.filter((finding) => finding.gain).map((finding) => {
    const gain = '/findings/' + result.findings.indexOf(finding) + '/gain/test_relative_error/';
    return {label: finding.rank + ' ' + words(finding.effect), from: gain + 'before/' + i, to: gain + 'after/' + i};
  });
  if (steps.length) {
    steps.unshift({label: 'fitted for the search', from: start, to: steps[0].from, colour: 'refit'});
    steps.push({label: 'fitted with conditions', from: steps[steps.length - 1].to, to: end, colour: 'refit'});
  }
  const rows = [{label: 'as it stands', to: start, colour: 'model'}]
                   .concat(steps.filter((row) => Math.abs(valueAt(row.to) - valueAt(row.from)) > kVisibleStep * valueAt(start)),
                           [{label: 'extended', to: end, colour: 'extended'}, {label: 'noise floor', to: '/noise_floor/relative_error/' + i, colour: 'quiet'}])
                   .filter((row) => isNumber(valueAt(row.to)));
  const largest = Math.max(1e-12, ...rows.flatMap((row) => [row.from, row.to]).filter(Boolean).map(valueAt));
  const floor = valueAt('/noise_floor/relative_error/' + i);
  return rowChart({
    name: 'waterfall', joint, title: jointName(joint), width: 400, left: 180, right: 62, range: [0, largest], marks: isNumber(floor) ? [{at: floor, kind: 'floor-line'}] : [],
    rows: rows.map((row) => {
      const from = row.from ? valueAt(row.from) : 0;
      return {label: row.label.length > 26 ? row.label.slice(0, 25) + '\u2026' : row.label, title: row.label, value: drawnNumber(row.to),
              parts: [{from, to: valueAt(row.to), colour: row.colour || (valueAt(row.to) <= from ? 'gain' : 'bad')}]};
    })});
}

function notSupported() {
  const list = result.not_supported || [];
  if (!list.length) return null;
  const joints = [...new Set(list.map((item) => item.joint))].sort((a, b) => a - b);
  return [
    heading('Not supported'), paragraph('note', 'Effects that were asked and not accepted, with the p of the best evidence for each on each joint; the reason shows under the pointer.'),
    table(['Effect', ...joints.map((joint) => '#' + shortJoint(joint))], groupBy(list, (item) => item.effect).map((group) => [strong(words(group[0].item.effect)), ...joints.map((joint) => {
      const cells = group.filter(({item}) => item.joint === joint);
      return cells.length ? element('span', {}, cells.flatMap(({k, item}, at) => [at ? ', ' : '', element('span', {title: item.why}, number('/not_supported/' + k + '/p_value', 'chance'))])) : null;
    })]), 'excluded')
  ];
}

function cannotTell() {
  const groups = groupBy(result.cannot_tell || [], (item) => item.effect + '\n' + item.why);
  return groups.length ? [heading('Cannot be told'), table(['Effect', 'Joint', 'Why'], groups.map(
      (group) => [strong(words(group[0].item.effect)), group.map(({item}) => shortJoint(item.joint)).join(', '), typeset(group[0].item.why)]), 'cannot-tell')] : null;
}

function leftOut() {
  const list = result.excluded_intervals || [];
  return list.length ? [
    heading('Left out'), paragraph('note', 'Moments that belong to a recording and not to the arm; no fit and no error counts them. The plots over time mark them.'),
    table(['Recording', 'Joint', 'Time', 'Why'], list.map((part, k) => [strong(fileName(part.file)), shortJoint(part.joint),
        element('span', {}, number('/excluded_intervals/' + k + '/from', 'plain', fixed(2)), ' to ', number('/excluded_intervals/' + k + '/to', 'plain', fixed(2)), '\u00a0s'), typeset(part.why)]), 'left-out')] : null;
}

function filledRows(place) {
  return element('span', {}, ' Of the rows ', number(place + '/share', 'share'), '\u00a0% are filled in; what they showed was ', number(place + '/lateness', 'milli'), '\u00a0ms old on average.');
}

function qualityTable() {
  const groups = groupBy(result.data_quality || [], (item) => item.file);
  if (!groups.length) return (result.excluded_intervals || []).length ? null : paragraph('', 'Nothing to remark.');
  return table(['Recording', 'Remarks'], groups.map((group) => [strong(fileName(group[0].item.file)), element('ul', {class: 'remarks'}, group.map(
      ({item, k}) => element('li', {}, typeset(item.sentence), item.filled_rows ? filledRows('/data_quality/' + k + '/filled_rows') : null)))]), 'quality');
}

pages.diagnose = () => {
  const floor = '/noise_floor/relative_error';
  const extended = result.findings.length > 0;
  const first = extended && (result.findings.find((f) => f.joint && !f.outside) || result.findings[0]);
  const part = (name) => extended && result.extended.test[name] && '/extended/test/' + name + '/relative_error';
  return {
    title: result.robot, kind: 'Diagnosis',
    facts: [number('/hypotheses', 'whole'), ' hypotheses tested in ', number('/seconds', 'plain', fixed(1)), ' s'],
    lead: diagnosisLead(), state: extended ? 'bad' : 'good', good: diagnosisWords(), next: diagnosisNext(),
    picture: [first ? causePicture(first, result.findings.indexOf(first)) : null, armView('diagnose')],
    sections: [
      section('causes', 'Each cause over what it explains', 'Dots: what the model as it stands leaves, against the variable of the cause; lines: what the extended model adds there.',
              grid(result.findings.slice(0, kPictures).map((f, k) => f.outside || f === first ? null : causePicture(f, k)))),
      frictionSection(),
      section('findings', 'Findings', 'In the order in which they were found. Sizes are those of the model with all findings, with 95 % intervals; p is the chance of such evidence ' +
                  'without the cause. A finding explains this share of the held-out error above the noise floor. Rivals are causes that these recordings cannot tell from the finding.',
              extended ? table(['Cause', {name: 'Size (95 %)', kind: 'size'}, '#p', {name: 'Held-out error', kind: 'size'}, '#Explains'], result.findings.map(findingRow), 'findings') :
                         paragraph('', 'None: the recordings support no further effect.')),
      section('gains', 'What each finding gains', 'Held-out error of each joint in %, from the model as it stands down to the extended model. Findings that leave a joint\u2019s error as it ' +
                  'was are not drawn there. The search fits without physical conditions, the models at both ends with them; a grey step is that difference.',
              extended ? element('div', {class: 'charts'}, series.joints.map((_, i) => waterfall(i + 1))) : null),
      section('errors', 'Error per joint', 'Root mean square of measured minus modelled torque, in % of the measured torque. Held-out recordings took no part in any fit. The noise ' +
                  'floor is how much the torque of the training recordings differs between repeats of one motion: about the best that a model can do.',
              errorTable([{name: 'Held out, baseline', place: '/baseline/test/relative_error', kind: 'model'},
                          extended && {name: 'Held out, extended', place: '/extended/test/relative_error', kind: 'extended'},
                          part('repaired') && {name: 'Extended, late rows repaired', place: part('repaired')},
                          part('without_excluded') && {name: 'Extended, without excluded rows', place: part('without_excluded')},
                          {name: 'Noise floor', place: floor}, {name: 'Training, baseline', place: '/baseline/train/relative_error'},
                          extended && {name: 'Training, extended', place: '/extended/train/relative_error'}], floor), verdictTable()),
      ...torqueSections(first && first.joint),
      section('excluded', 'Ruled out, and what cannot be told', null, cannotTell(), notSupported()),
      section('quality', 'Quality of the recordings', null, leftOut(), qualityTable())
    ]
  };
};
