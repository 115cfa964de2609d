// Eigenvalues in the unit circle, a root locus, a map of two parameters and step responses, as drawings.

const kTicks = 5;  // along each side of a map
const kPlane = {size: 460, margin: 30, reach: 1.15};

function planePoint([re, im]) {
  const scale = (kPlane.size / 2 - kPlane.margin) / kPlane.reach;
  const clip = (v) => Math.max(-kPlane.reach, Math.min(kPlane.reach, v));
  return [kPlane.size / 2 + scale * clip(re), kPlane.size / 2 - scale * clip(im)];
}

function dot(value, radius, colour, opacity) {
  const [x, y] = planePoint(value);
  return drawing('circle', {cx: x.toFixed(2), cy: y.toFixed(2), r: radius, fill: colour, 'fill-opacity': opacity});
}

function drawPlane() {
  const middle = kPlane.size / 2;
  const one = planePoint([1, 0])[0] - middle;
  const line = (x1, y1, x2, y2) => drawing('line', {x1, y1, x2, y2, stroke: '#dcdcd7'});
  const parts = [
    line(0, middle, kPlane.size, middle), line(middle, 0, middle, kPlane.size),
    drawing('circle', {cx: middle, cy: middle, r: one, fill: 'none', stroke: '#5a5a55'})
  ];
  if (result.locus) {
    const last = Math.max(1, result.locus.eigenvalues.length - 1);
    result.locus.eigenvalues.forEach(
        (values, k) => values.forEach((v) => parts.push(dot(v, 1.6, '#0f6ab4', 0.15 + 0.85 * k / last))));
  }
  for (const value of result.eigenvalues) parts.push(dot(value, 3.2, '#cf5b13', 1));
  const drawn = 'eigenvalues:' + result.eigenvalues.length +
      (result.locus ? ' locus:' + result.locus.eigenvalues.reduce((sum, values) => sum + values.length, 0) : '');
  const plot = element('div', {class: 'plot plane', 'data-plot': 'plane', 'data-points': drawn}, drawing('svg', {viewBox: '0 0 460 460', width: '100%', style: 'max-width:34rem', role: 'img', 'aria-label': 'Eigenvalues'}, parts));
  byId('plane-plot').append(plot);
  byId('plane-note').textContent = 'In discrete time, of ' + result.eigenvalue_cycles + ' cycle' +
      (result.eigenvalue_cycles === 1 ? '' : 's') + ' of ' + (1e3 * result.period).toPrecision(3) +
      ' ms at the worst point of rest (orange); the loop is stable where all lie within the circle.' +
      (result.locus ? ' Blue: over ' + words(result.locus.parameter) + ' from ' +
               result.locus.values[0].toPrecision(3) + ' (pale) to ' +
               result.locus.values[result.locus.values.length - 1].toPrecision(3) + '.' :
                      '');
}

function drawMap() {
  const map = result.map;
  if (!map) {
    byId('map').remove();
    return;
  }
  const size = {left: 70, bottom: 40, width: 640, height: 420};
  const wide = (size.width - size.left) / map.a_values.length;
  const high = (size.height - size.bottom) / map.b_values.length;
  const parts = [];
  map.stable.forEach((row, j) => row.forEach((stable, i) => {
    parts.push(drawing('rect', {
      x: (size.left + i * wide).toFixed(2),
      y: (size.height - size.bottom - (j + 1) * high).toFixed(2),
      width: (wide + 0.3).toFixed(2),
      height: (high + 0.3).toFixed(2),
      fill: stable ? '#0f6ab4' : '#e8b48f',
      'fill-opacity': stable ? Math.min(0.9, 0.15 + 12 * (1 - map.radius[j][i])).toFixed(2) : 1
    }));
  }));
  const label = (x, y, value, anchor) => drawing('text', {x, y, 'font-size': 11, 'text-anchor': anchor, fill: '#1d1d1b'}, value);
  const short = (v) => Number(v.toPrecision(3)).toString();
  const bottom = size.height - size.bottom;
  const named = (name, unit) => words(name) + (unit && unit !== '1' ? ' [' + unit + ']' : '');
  for (let k = 0; k < kTicks; ++k) {
    const i = Math.round(k * (map.a_values.length - 1) / (kTicks - 1));
    const j = Math.round(k * (map.b_values.length - 1) / (kTicks - 1));
    parts.push(
        label(size.left + (i + 0.5) * wide, bottom + 16, short(map.a_values[i]), k === kTicks - 1 ? 'end' : k ? 'middle' : 'start'),
        label(size.left - 6, Math.max(12, bottom - (j + 0.5) * high + 4), short(map.b_values[j]), 'end'));
  }
  parts.push(
      label((size.left + size.width) / 2, bottom + 34, named(map.a, map.a_unit), 'middle'),
      drawing('text', {x: 0, y: 0, 'font-size': 11, 'text-anchor': 'middle', fill: '#1d1d1b', transform: 'translate(14 ' + bottom / 2 + ') rotate(-90)'}, named(map.b, map.b_unit)));
  byId('map-note').textContent = 'Blue: stable, darker where motion dies away faster; orange: not stable.';
  byId('map-plot').append(element('div', {class: 'plot map', 'data-plot': 'map', 'data-points': 'cells:' + map.a_values.length * map.b_values.length}, drawing('svg', {viewBox: '0 0 640 420', width: '100%', role: 'img', 'aria-label': 'Stability map'}, parts)));
}

function drawSteps() {
  if (!series.steps || !series.steps.forces.length) {
    byId('steps').remove();
    return;
  }
  const {time, forces} = series.steps;
  for (const {member, force} of forces) {
    const finite = force.filter(isNumber).map((v) => Math.max(-10, Math.min(10, v)));
    const low = Math.min(-0.2, ...finite), high = Math.max(1, ...finite);
    const x = (k) => 40 + 590 * time[k] / time[time.length - 1];
    const y = (v) => 10 + 180 * (high - v) / (high - low);
    const path = force.map((v, k) => (k ? 'L' : 'M') + x(k).toFixed(1) + ' ' + y(Math.max(low, Math.min(high, v || 0))).toFixed(1));
    const text = (px, py, value) => drawing('text', {x: px, y: py, 'font-size': 11, 'text-anchor': 'end', fill: '#5a5a55'}, value);
    byId('step-plots').append(element('div', {class: 'plot steps', 'data-plot': 'steps', 'data-points': 'force:' + force.length}, element('h3', {}, member), drawing('svg', {viewBox: '0 0 640 215', width: '100%', role: 'img', 'aria-label': 'Step response'},
        drawing('line', {x1: 40, x2: 630, y1: y(0), y2: y(0), stroke: '#dcdcd7'}),
        drawing('path', {d: path.join(''), fill: 'none', stroke: '#0f6ab4', 'stroke-width': 1.4}),
        drawing('line', {x1: 40, x2: 630, y1: y(1), y2: y(1), stroke: '#dcdcd7', 'stroke-dasharray': '4 3'}),
        text(36, y(1) + 4, '1 N'), text(36, y(0) + 4, '0'), text(630, 212, time[time.length - 1].toPrecision(2) + ' s'))));
  }
}

function margin(value, unit) {
  return isNumber(value) ? withMinus(Number(value.toPrecision(3)).toString()) + unit : 'none found';
}

function fillStability() {
  byId('title').textContent = result.scenario;
  byId('facts').append(result.source || '');
  const m = result.margins;
  byId('verdict').append(
      element('p', {class: 'lead'}, result.stable ? 'The loop is stable.' : 'The loop is not stable.'),
      element('p', {}, 'Margins of the force readings: gain ' + margin(m.gain, '') + ', phase ' + margin(m.phase_deg, '°') + ', delay ' +
          (isNumber(m.delay_s) ? margin(1e3 * m.delay_s, ' ms') : 'none found') + '.'));
  if (isNumber(result.largest_stable_stiffness)) {
    byId('verdict').append(element('p', {}, 'Stable for objects from ' + margin(result.smallest_stable_stiffness, ' N/m') + ' to ' +
        margin(result.largest_stable_stiffness, ' N/m') + (result.stiffness_bounded ? '.' : ', the end of the search.')));
  }
  const advice = result.recommendation;
  if (advice) {
    byId('verdict').append(element('p', {}, advice.found ?
        'Gains for ' + advice.phase_deg + '°: crossover ' + advice.crossover.toPrecision(3) + ' 1/s, gain ' + advice.law.gain.toPrecision(3) +
            ' m/(N s), damping of the law ' + advice.law.damping.toPrecision(3) + ' s, of the impedance ' + advice.impedance_damping.toPrecision(3) + ' N s/m.' :
        'No gains found for ' + advice.phase_deg + '°.'));
  }
  const bounds = result.bounds;
  if (bounds) {
    byId('verdict').append(element('p', {}, bounds.unstable + ' of ' + bounds.samples + ' arms with parameters at the corners of their intervals are not stable.'));
  }
  drawPlane();
  drawMap();
  drawSteps();
  byId('point-table').append(table(
      [{name: 'Phase'}, {name: 'Time [s]', kind: 'number'}, {name: 'Largest modulus per cycle', kind: 'number'}, {name: ''}],
      result.points.map((p) => [p.phase, p.time.toFixed(2), p.radius.toFixed(6), p.stable ? 'stable' : element('span', {class: 'warning'}, 'not stable')]), 'points'));
}
