// What arms did that held one object, in words, tables and plots; or the map of a sweep.

function newtons(pointer) { return number(pointer, 'plain', (v) => withMinus(v.toFixed(3))); }

function askedRows() {
  return result.phases.flatMap((phase, k) => ['force_error', 'steady_error'].flatMap((what) => {
    if (!isNumber(phase[what].asked)) return [];
    const place = '/phases/' + k + '/' + what;
    const met = phase[what].reached <= phase[what].asked;
    return [[
      phase.phase, what === 'force_error' ? 'force error at any time' : 'force error at rest',
      newtons(place + '/reached'), newtons(place + '/asked'),
      element('span', {class: met ? '' : 'warning'}, met ? 'met' : 'not met')
    ]];
  }));
}

function curveKey(curve) {
  return element(
      'span', {class: 'key'}, element('i', {style: 'background:' + curve.colour}), curve.name);
}

function fillRun() {
  const asked = askedRows();
  const missed = asked.filter((row) => row[4].textContent !== 'met').length;
  const lead = !asked.length ? 'No bounds were asked for.' :
      missed                 ? missed + ' of ' + asked.length + ' bounds not met.' :
                               'All ' + asked.length + ' bounds met.';
  byId('verdict').append(element('p', {class: 'lead'}, lead));
  if (result.status !== 'done') {
    byId('verdict').append(element(
        'p', {class: 'warning'},
        (isNumber(result.held_at) ? 'At ' + result.held_at.toFixed(3) + ' s the controller ' :
                                    'The run stopped: it ') +
            result.reason + '.'));
  }
  if (asked.length) {
    byId('verdict').append(table(
        [
          {name: 'Phase'}, {name: 'Figure'}, {name: 'Reached [N]', kind: 'number'},
          {name: 'Asked [N]', kind: 'number'}, {name: ''}
        ],
        asked, 'asked'));
  }
  byId('verdict').append(element(
      'p', {class: 'small'}, 'Largest force at any time: ', newtons('/largest_force'), ' N.'));
  byId('phases-title').textContent = 'Phases';
  byId('phases-note').textContent =
      'True force against the force wanted [N]: its largest error in the phase, the largest and the mean in ' +
      'the last fifth, what it went beyond a new set point, and its swing from least to largest ' +
      'in the last fifth. Energy made: the most that the arms gave to the object about its ' +
      'point of rest after the phase’s commands had ended.';
  const rows = result.phases.flatMap((phase, k) => phase.members.map((member, m) => {
    const place = '/phases/' + k + '/members/' + m + '/';
    return [
      phase.phase, member.member, newtons(place + 'wanted_force'), newtons(place + 'largest_error'),
      newtons(place + 'steady_error'), newtons(place + 'mean_error'), newtons(place + 'overshoot'),
      newtons(place + 'oscillation'), number(place + 'generated_energy', 'milli')
    ];
  }));
  const head = ['Wanted', 'Largest', 'At rest', 'Mean', 'Overshoot', 'Swing', 'Made [mJ]'];
  byId('phase-tables')
      .append(table(
          [{name: 'Phase'}, {name: 'Member'}].concat(
              head.map((name) => ({name: name, kind: 'number'}))),
          rows, 'phases'));
  // A plot without a title stands beneath the one before and has its time axis.
  let place, readout;
  series.plots.forEach((one, k) => {
    if (one.title) {
      readout = element('span', {class: 'readout'});
      place = element(
          'div', {class: 'joint'}, element('h3', {}, one.title + ' [' + one.unit + ']', readout),
          element('p', {class: 'keys'}, one.curves.map(curveKey)));
      byId('time-plots').append(place);
    }
    timePlot(place, one.kind, k + 1, series, one.curves, one.unit, readout);
  });
  fitTimePlotsToPaper();
}

// A map for every rate of the loops: stiffness down, delay across.
function fillSweep() {
  const stable = result.points.filter((p) => p.stable).length;
  byId('verdict').append(
      element('p', {class: 'lead'}, stable + ' of ' + result.points.length + ' points are stable.'),
      element(
          'p', {class: 'small'}, 'Where a point is stable, the arms made at most ',
          number('/generated_energy_where_stable', 'milli'), ' mJ at the object.'));
  byId('phases-title').textContent = 'Stable region';
  byId('phases-note').textContent =
      'Largest force error [N] in the phases that ask for a bound, by the stiffness of the object ' +
      'and the delay of the force sensor. A cross: not stable, more than ' + result.stable_error +
      ' N of error or swing at rest, or ended by a bound.';
  result.rate.forEach((rate, r) => {
    const columns = [{name: 'Stiffness [N/m]'}].concat(
        result.delay.map((d) => ({
                           name: withMinus(String(Number((1e3 * d).toPrecision(3)))) + ' ms',
                           kind: 'number'
                         })),
        [{name: 'Stable up to [ms]', kind: 'number'}]);
    const rows = result.stiffness.map(
        (stiffness, s) => [String(stiffness)].concat(
            result.delay.map((_, d) => {
              const k = s + result.stiffness.length * (d + result.delay.length * r);
              const point = result.points[k];
              return element(
                  'span', {class: point.stable ? 'stable' : 'unstable', title: point.ended},
                  point.stable ? newtons('/points/' + k + '/force_error') : '×');
            }),
            [number(
                '/stable_region/' + (s + r * result.stiffness.length) + '/delay_up_to', 'milli')]));
    byId('phase-tables')
        .append(element('h3', {}, 'Loops at ' + rate + ' Hz'), table(columns, rows, 'sweep'));
  });
  byId('over-time').remove();
}

function fillCooperation() {
  byId('title').textContent = result.scenario;
  byId('facts').append(
      (result.source ? result.source + '; ' : '') + 'simulated by ' + result.engine);
  if (result.points) {
    fillSweep();
  } else {
    fillRun();
  }
}
