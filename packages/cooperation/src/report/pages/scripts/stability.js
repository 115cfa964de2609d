// Eigenvalues in the unit circle, a root locus, a map of two parameters and step responses.

const kPlaneReach = 1.15;

function eigenvaluePlane() {
  const clip = (values) => values.map(([re, im]) => [re, im].map((v) => Math.max(-kPlaneReach, Math.min(kPlaneReach, v))));
  const circle = Array.from({length: 181}, (_, k) => [Math.cos(k * Math.PI / 90), Math.sin(k * Math.PI / 90)]);
  const locus = result.locus ? clip(result.locus.eigenvalues.flat()) : [];
  const range = [-kPlaneReach, kPlaneReach];
  return chart({
    name: 'plane', joint: 0, title: 'Eigenvalues', x: {name: 'real part', range}, y: {name: 'imaginary part', range}, width: 470, height: 450,
    marks: [{kind: 'line', name: 'unit circle', colour: 'quiet', silent: true, points: circle},
            {kind: 'dots', name: 'locus', colour: 'extended', width: 3, opacity: 0.6, points: locus},
            {kind: 'dots', name: 'eigenvalues', colour: 'model', width: 7, opacity: 1, points: clip(result.eigenvalues)}],
    note: 'In discrete time, of ' + countOf(result.eigenvalue_cycles, 'cycle') + ' of ' + short(1e3 * result.period) + ' ms at the worst point of rest; the loop is stable where all lie within the circle.' +
        (result.locus ? ' The locus goes over ' + words(result.locus.parameter) + ' from ' + short(result.locus.values[0]) + ' to ' + short(result.locus.values[result.locus.values.length - 1]) + '.' : '')
  });
}

const kCells = 5;  // names along each side of a map

function stabilityMap() {
  const map = result.map;
  if (!map) return null;
  const named = (name, unit) => words(name) + (unit && unit !== '1' ? ' [' + unit + ']' : '');
  const picks = (values) => [...new Set(Array.from({length: kCells}, (_, k) => Math.round(k * (values.length - 1) / (kCells - 1))))].map((k) => ({at: k + 0.5, text: short(values[k])}));
  const cells = (x, y) => map.stable.flatMap((row, j) => row.map((stable, i) => drawing('rect', {
    x: x(i).toFixed(2), y: y(j + 1).toFixed(2), width: (x(1) - x(0) + 0.3).toFixed(2), height: (y(0) - y(1) + 0.3).toFixed(2), fill: 'var(--' + (stable ? 'extended' : 'pale-model') + ')',
    'fill-opacity': stable ? Math.min(0.9, 0.15 + 12 * (1 - map.radius[j][i])).toFixed(2) : 1})));
  const columns = map.a_values.length, rows = map.b_values.length;
  return chart({
    name: 'map', joint: 0, title: 'Stable region', x: {name: named(map.a, map.a_unit), range: [0, columns], ticks: picks(map.a_values)},
    y: {name: named(map.b, map.b_unit), range: [0, rows], ticks: picks(map.b_values)}, width: 640, height: 400, extra: cells, note: 'Blue: stable, darker where motion dies away faster; pale orange: not stable.',
    marks: [{kind: 'dots', name: 'cells', colour: 'extended', opacity: 0.001, points: Array.from({length: columns * rows}, (_, k) => [k % columns + 0.5, Math.floor(k / columns) + 0.5])}]
  });
}

function stepCharts() {
  const {time, forces} = series.steps || {forces: []};
  return forces.map(({member, force}) => chart({
    name: 'steps', joint: 0, title: member, x: {name: 'time [s]'}, y: {name: 'N'}, width: 420, height: 220, marks: [
      {kind: 'line', name: 'wanted', colour: 'measured', silent: true, dash: '4 3', points: [[time[0], 1], [time[time.length - 1], 1]]},
      {kind: 'line', name: 'force', colour: 'extended', points: force.map((v, k) => [time[k], isNumber(v) ? Math.max(-10, Math.min(10, v)) : null])}]}));
}

pages.stability = () => {
  const margin = (value, unit) => isNumber(value) ? short(value) + unit : 'none found';
  const m = result.margins;
  const advice = result.recommendation;
  const bounds = result.bounds;
  return {
    title: result.scenario, kind: 'Stability', facts: [result.source || ''],
    lead: result.stable ? 'The loop is stable.' : 'The loop is not stable.', state: result.stable ? 'good' : 'bad',
    good: [
      paragraph('', 'Margins of the force readings: gain ' + margin(m.gain, '') + ', phase ' + margin(m.phase_deg, '\u00b0') + ', delay ' + (isNumber(m.delay_s) ? margin(1e3 * m.delay_s, ' ms') : 'none found') + '.'),
      isNumber(result.largest_stable_stiffness) ? paragraph('', 'Stable for objects from ' + margin(result.smallest_stable_stiffness, ' N/m') + ' to ' + margin(result.largest_stable_stiffness, ' N/m') +
          (result.stiffness_bounded ? '.' : ', the end of the search.')) : null,
      advice ? paragraph('', advice.found ? 'Gains for ' + advice.phase_deg + '\u00b0: crossover ' + short(advice.crossover) + ' 1/s, gain ' + short(advice.law.gain) + ' m/(N s), damping of the law ' +
          short(advice.law.damping) + ' s, of the impedance ' + short(advice.impedance_damping) + ' N s/m.' : 'No gains found for ' + advice.phase_deg + '\u00b0.') : null,
      bounds ? paragraph('', bounds.unstable + ' of ' + bounds.samples + ' arms with parameters at the corners of their intervals are not stable.') : null],
    next: [{why: result.stable ? 'Run the scenario in full, with friction and noise:' : 'Look for gains that are stable:',
            command: result.stable ? 'veridyn cooperate ' + fileOfRun('SCENARIO.yaml') + ' --report run.html' : 'veridyn stability ' + fileOfRun('SCENARIO.yaml') + ' --recommend 45'}],
    picture: eigenvaluePlane(),
    sections: [
      section('map', 'Map', null, stabilityMap()),
      section('steps', 'Step responses', 'True force in a member [N] after all wanted forces rose by 1 N at once, in the linear loop.', grid(stepCharts())),
      section('points', 'Points of rest', 'Where arms would stand along the motion, with the forces wanted there.', table(['Phase', '#Time [s]', '#Largest modulus per cycle', ''],
          result.points.map((p) => [p.phase, fixed(2)(p.time), fixed(6)(p.radius), p.stable ? 'stable' : element('span', {class: 'warning'}, 'not stable')]), 'points'))]
  };
};
