// The motion that excite designed: its limits, its curves, and what a recording of it will tell.

const kLimitColour = '#b0483c';
const motionParts =
    [['q', 'position', ''], ['dq', 'velocity', '/s'], ['ddq', 'acceleration', '/s\u00b2']];
let motionJoint = 1;

function fact(name, ...value) {
  return element('div', {}, element('dt', {}, name), element('dd', {}, ...value));
}

function discriminationWords() {
  const d = result.discrimination;
  if (!d) return [];
  const share = (k) => [number('/discrimination/share_left/' + k, 'percent'), '\u00a0%'];
  return [element(
      'p', {}, 'Of what the rest of the model leaves of ' + words(d.between[0]) + ', ', share(0),
      ' cannot be taken for ' + words(d.between[1]) + '; the other way round ', share(1), '.')];
}

function excitationWords() {
  const lead = element(
      'p', {class: 'lead'}, number('/periods', 'whole'), ' periods of ',
      number('/frequency', 'plain', (f) => significant(1 / f, 4)), '\u00a0s in ',
      number('/harmonics', 'whole'), ' harmonics, ', number('/duration', 'plain'),
      '\u00a0s in all',
      result.slow_seconds ?
          ['; slow passes of one joint after the other follow for ',
           number('/slow_seconds', 'plain'), '\u00a0s.'] :
          '.');
  const facts = [
    ['Base parameters', '/base_parameters', 'whole'],
    ['Condition number, columns of norm one', '/condition_number', 'plain'],
    ['The same of a random motion', '/start_condition_number', 'plain'],
    ['Columns as they are', '/plain_condition_number', 'plain'],
    ['Columns scaled by their range', '/range_condition_number', 'plain'],
    ['Essential parameters', '/essential/count', 'whole'],
    ['Condition number of these', '/essential/condition_number', 'plain'],
    ['Together with given recordings', '/condition_number_with_given', 'plain'],
    ['Search [s]', '/seconds', 'plain']
  ].filter(([, place]) => isNumber(valueAt(place)) &&
               (place !== '/condition_number_with_given' ||
                result.condition_number_with_given !== result.condition_number));
  return [
    lead, ...discriminationWords(),
    element(
        'dl', {class: 'facts-list'},
        facts.map(([name, place, style]) => fact(name, number(place, style))))
  ];
}

function limitRow(limit, k) {
  const place = '/margins/' + k;
  const bound = (side) =>
      isNumber(limit.bounds[side]) ? number(place + '/bounds/' + side, 'plain') : 'open';
  return [
    element('strong', {}, limit.limit),
    [number(place + '/motion/0', 'plain'), ' to ', number(place + '/motion/1', 'plain')],
    [bound(0), ' to ', bound(1)], number(place + '/margin', 'plain'), typeset(limit.unit)
  ];
}

function drawMotion() {
  for (const one of timePlots.splice(0)) one.graph.destroy();
  byId('time-plots').replaceChildren();
  const data = series.motion.joints[motionJoint - 1];
  for (const [part, name, per] of motionParts) {
    const unit = series.joints[motionJoint - 1].unit + per;
    const readout = element('span', {class: 'readout'});
    const place = element(
        'div', {class: 'joint'},
        element('h3', {}, jointName(motionJoint) + ': ' + name + ' [' + unit + ']', readout));
    byId('time-plots').append(place);
    const curves = [{name: name, colour: colours.extended, width: 1.6, values: data[part]}];
    data.limits[part].forEach((limit, side) => {
      if (isNumber(limit)) {
        curves.push({
          name: side ? 'highest' : 'lowest',
          colour: kLimitColour,
          width: 1,
          values: data[part].map(() => limit)
        });
      }
    });
    timePlot(place, 'error', motionJoint, series.motion, curves, unit, readout);
  }
  fitTimePlotsToPaper();
}

function predictionRow(one, k) {
  const place = '/prediction/base_parameters/' + k;
  return [
    element('span', {class: 'expression'}, one.name), number(place + '/value', 'plain'),
    number(place + '/std', 'plain'), percent(place + '/relative_std'), typeset(one.unit)
  ];
}

function fillPrediction() {
  const p = result.prediction;
  if (!p) {
    byId('prediction-note').append('The values of the arm are not known.');
    return;
  }
  byId('prediction-note')
      .append(
          'Predicted standard deviations of the base parameters, relative to the values ' +
              p.values + ': median ',
          percent('/prediction/median_relative_std'), ', mean ',
          percent('/prediction/mean_relative_std'), '. Noise of the torques (' + p.noise.source +
              '): ',
          ...p.noise.share_of_rms_torque.flatMap(
              (_, i) => [i ? ', ' : '', percent('/prediction/noise/share_of_rms_torque/' + i)]),
          ' of the rms torque of each joint, one independent sample in ',
          number('/prediction/noise/seconds_between_independent_samples', 'plain'),
          '\u00a0s. Hardest to tell from each other: ' +
              result.weakest.slice(0, 5).map((w) => w.parameter).join(', ') + '.');
  byId('base-table')
      .append(table(
          [
            {name: 'Base parameter, led by'}, {name: 'Value', kind: 'number'},
            {name: 'Std. deviation', kind: 'number'}, {name: 'Relative', kind: 'number'},
            {name: 'Unit'}
          ],
          p.base_parameters.map(predictionRow), 'base'));
}

function fillExcitation() {
  byId('title').textContent = result.robot;
  byId('facts').append(
      words(result.criterion) + ', searched by ' + result.solver +
      (result.interrupted ? ', interrupted: the best so far' : ''));
  byId('verdict').append(...excitationWords());
  byId('limit-table')
      .append(table(
          [
            {name: 'Limit'}, {name: 'Motion', kind: 'number'}, {name: 'Allowed', kind: 'number'},
            {name: 'Margin', kind: 'number'}, {name: 'Unit'}
          ],
          result.margins.map(limitRow), 'base'));
  fillPrediction();
  const joints = series.joints.map((_, i) => [i + 1, jointName(i + 1)]);
  const whole = element('button', {type: 'button'}, 'Whole motion');
  whole.addEventListener('click', () => showTime(null));
  byId('chooser').append(
      chooser('Joint', [{options: joints}], (value) => {
        motionJoint = Number(value);
        drawMotion();
        noteState();
      }),
      whole);
  drawMotion();
}
