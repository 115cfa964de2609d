// The arm as lines between its frames and the tip's places, coloured by conditioning, in three views.

function conditionColour(condition) {
  if (!isNumber(condition)) return '#cf5b13';
  const share = Math.max(0, Math.min(1, Math.log10(condition) / 2));
  const mix = [[15, 106, 180], [207, 91, 19]];
  return 'rgb(' + mix[0].map((v, i) => Math.round(v + share * (mix[1][i] - v))).join(',') + ')';
}

function armView(title, across, up) {
  const all = result.arms.flatMap((a) => a.points).concat(result.points);
  const range = (axis) => [Math.min(...all.map((p) => p[axis])), Math.max(...all.map((p) => p[axis]))];
  const [left, right] = range(across), [low, high] = range(up);
  const reach = Math.max(right - left, high - low, 1e-3);
  const scale = 300 / reach;
  const x = (p) => (25 + scale * (p[across] - (left + right) / 2 + reach / 2)).toFixed(1);
  const y = (p) => (325 - scale * (p[up] - (low + high) / 2 + reach / 2)).toFixed(1);
  const parts = result.points.map((p) => drawing('circle', {cx: x(p), cy: y(p), r: 1.5, fill: conditionColour(p[3]), 'fill-opacity': 0.7}));
  result.arms.forEach((arm, k) => arm.points.forEach((point, i) => {
    const parent = arm.parents[i];
    if (parent < 0) return;
    parts.push(drawing('line', {
      x1: x(arm.points[parent]), y1: y(arm.points[parent]), x2: x(point), y2: y(point),
      stroke: k ? '#b9b9b2' : '#1d1d1b', 'stroke-width': 2.2, 'stroke-linecap': 'round'
    }));
  }));
  const axis = 'xyz';
  return element('div', {class: 'plot arm', 'data-plot': title, 'data-points': 'tips:' + result.points.length + ' arms:' + result.arms.length}, element('p', {class: 'caption'}, title + ': ' + axis[across] + ' to the right, ' + axis[up] + ' up, ' + reach.toPrecision(3) + ' m wide'),
                 drawing('svg', {viewBox: '0 0 350 350', width: '100%', style: 'max-width:30rem', role: 'img', 'aria-label': title}, parts));
}

function fillKinematics() {
  byId('title').textContent = result.robot;
  byId('facts').append('Frame ' + result.frame + ', ' + result.postures + ' postures, ' + result.solver);
  const finite = result.points.map((p) => p[3]).filter(isNumber).sort((a, b) => a - b);
  byId('verdict').append(element('p', {class: 'lead'}, result.not_reached ? result.not_reached + ' of ' + result.postures + ' poses not reached.' :
      'Condition of the position Jacobian: ' + (finite.length ? finite[0].toPrecision(3) + ' to ' + finite[finite.length - 1].toPrecision(3) : 'singular throughout') + '.'));
  byId('arm-plots').append(armView('Front', 0, 2), armView('Side', 1, 2), armView('Above', 0, 1));
}
