// What calibrate found: numbers, axes and frames in space, and histograms of what is left over.

const spaceColours = {points: '#5b7083', axes: '#b0483c', frames: '#1f6f8b'};
const view = {yaw: -0.6, pitch: 0.45};

// A point of space on the canvas, seen from a direction, all of it in view.
function projection(width, height) {
  const all = series.space.points.flatMap((p) => p.at)
                  .concat(series.space.lines.flatMap((l) => [l.from, l.to]))
                  .concat(series.space.frames.map((f) => f.origin));
  const middle = [0, 1, 2].map((c) => {
    const values = all.map((p) => p[c]);
    return (Math.min(...values) + Math.max(...values)) / 2;
  });
  const reach = Math.max(
      1e-6, ...all.map((p) => Math.hypot(p[0] - middle[0], p[1] - middle[1], p[2] - middle[2])));
  const scale = 0.45 * Math.min(width, height) / reach;
  const [cy, sy, cp, sp] =
      [Math.cos(view.yaw), Math.sin(view.yaw), Math.cos(view.pitch), Math.sin(view.pitch)];
  const place = (p) => {
    const [x, y, z] = [0, 1, 2].map((c) => p[c] - middle[c]);
    const across = cy * x - sy * y;
    const away = sy * x + cy * y;
    return [width / 2 + scale * across, height / 2 - scale * (cp * z + sp * away)];
  };
  return {place, reach};
}

function drawSpace() {
  const plot = document.querySelector('.plot.space');
  const canvas = plot.querySelector('canvas');
  const ratio = window.devicePixelRatio || 1;
  const width = Math.max(200, plot.clientWidth);
  const height = 420;
  canvas.width = width * ratio;
  canvas.height = height * ratio;
  const pen = canvas.getContext('2d', {willReadFrequently: true});
  pen.scale(ratio, ratio);
  pen.font = '12px sans-serif';
  const {place, reach} = projection(width, height);
  const line = (a, b, colour, thickness) => {
    pen.strokeStyle = colour;
    pen.lineWidth = thickness;
    pen.beginPath();
    pen.moveTo(...place(a));
    pen.lineTo(...place(b));
    pen.stroke();
  };
  const name = (at, text) => {
    const [x, y] = place(at);
    pen.fillStyle = '#333333';
    pen.fillText(text, x + 6, y - 6);
  };
  pen.fillStyle = spaceColours.points;
  for (const group of series.space.points) {
    for (const p of group.at) {
      const [x, y] = place(p);
      pen.fillStyle = spaceColours.points;
      pen.fillRect(x - 2, y - 2, 4, 4);
    }
    if (group.at.length) name(group.at[0], group.name);
  }
  for (const one of series.space.lines) {
    line(one.from, one.to, spaceColours.axes, 2);
    name(one.to, one.name);
  }
  for (const frame of series.space.frames) {
    frame.axes.forEach((axis, c) => {
      const length = reach * [0.16, 0.12, 0.08][c];
      line(
          frame.origin, frame.origin.map((o, k) => o + length * axis[k]), spaceColours.frames, 2);
    });
    name(frame.origin, frame.name);
  }
  const curves = [
    {
      name: 'points',
      colour: spaceColours.points,
      points: series.space.points.reduce((n, g) => n + g.at.length, 0)
    },
    {name: 'axes', colour: spaceColours.axes, points: series.space.lines.length},
    {name: 'frames', colour: spaceColours.frames, points: series.space.frames.length}
  ].filter((c) => c.points);
  noteDrawn(plot, canvas, curves);
}

function fillSpace() {
  const canvas = element('canvas', {style: 'display:block;width:100%;height:420px;cursor:grab'});
  byId('space-plot')
      .append(element('div', {class: 'plot space', 'data-plot': 'space', 'data-joint': 0}, canvas));
  const names = {points: 'measured points', axes: 'axes', frames: 'frames'};
  const there = {
    points: series.space.points.length,
    axes: series.space.lines.length,
    frames: series.space.frames.length
  };
  for (const part of Object.keys(names)) {
    if (there[part]) {
      byId('space-keys')
          .append(element(
              'span', {class: 'key'}, element('i', {style: 'background:' + spaceColours[part]}),
              names[part]));
    }
  }
  let last = null;
  canvas.addEventListener('pointerdown', (event) => last = [event.clientX, event.clientY]);
  window.addEventListener('pointerup', () => last = null);
  window.addEventListener('pointermove', (event) => {
    if (!last) return;
    view.yaw += 0.01 * (event.clientX - last[0]);
    view.pitch = Math.min(1.57, Math.max(-1.57, view.pitch + 0.01 * (event.clientY - last[1])));
    last = [event.clientX, event.clientY];
    drawSpace();
  });
  drawSpace();
}

function drawHistogram(histogram, k) {
  const canvas = element('canvas', {style: 'display:block;width:100%;height:170px'});
  const plot =
      element('div', {class: 'plot histogram', 'data-plot': 'histogram', 'data-joint': k + 1}, canvas);
  byId('histograms')
      .append(element('div', {}, element('h3', {}, histogram.name + ' [' + histogram.unit + ']'), plot));
  const ratio = window.devicePixelRatio || 1;
  const width = Math.max(150, plot.clientWidth);
  const height = 170;
  canvas.width = width * ratio;
  canvas.height = height * ratio;
  const pen = canvas.getContext('2d', {willReadFrequently: true});
  pen.scale(ratio, ratio);
  const most = Math.max(1, ...histogram.counts);
  const step = (width - 20) / histogram.counts.length;
  pen.fillStyle = spaceColours.frames;
  histogram.counts.forEach((count, bin) => {
    const h = (height - 30) * count / most;
    pen.fillRect(10 + bin * step, height - 20 - h, Math.max(1, step - 1), h);
  });
  pen.fillStyle = '#333333';
  pen.font = '11px sans-serif';
  const text = (value) => withMinus(String(Number(value.toPrecision(3))));
  pen.textAlign = 'left';
  pen.fillText(text(histogram.low), 10, height - 6);
  pen.textAlign = 'right';
  pen.fillText(text(histogram.high), width - 10, height - 6);
  noteDrawn(
      plot, canvas,
      [{name: 'errors', colour: spaceColours.frames, points: histogram.counts.length}]);
}

const millimetres = (place) => number(place, 'milli', (v) => withMinus(v.toFixed(3)));
const plainly = (place) => number(place, 'plain', (v) => withMinus(v.toFixed(4)));
const three = (place, write) => [0, 1, 2].flatMap((c) => [c ? ', ' : '', write(place + '/' + c)]);

function fillAxes() {
  const columns = [
    {name: 'Between'}, {name: 'Direction', kind: 'number'}, {name: '\u00b1 deg', kind: 'number'},
    {name: 'Point [mm]', kind: 'number'}, {name: '\u00b1 mm', kind: 'number'}
  ];
  const rows = result.axes.map((axis, k) => {
    const place = '/axes/' + k;
    return [
      axis.between.join(', '), three(place + '/direction', plainly), plainly(place + '/interval_deg'),
      three(place + '/point', millimetres), millimetres(place + '/interval_m')
    ];
  });
  byId('calibration-tables').append(table(columns, rows, 'base'));
  if (!result.links.length) return;
  const links = result.links.map((link, k) => {
    const place = '/links/' + k;
    return [
      link.axes.map((a) => a + 1).join(', ') + ' on ' + link.body, millimetres(place + '/distance'),
      [millimetres(place + '/interval/0'), ' to ', millimetres(place + '/interval/1')],
      millimetres(place + '/plane_parallel_distance'), plainly(place + '/twist_deg')
    ];
  });
  byId('calibration-tables')
      .append(
          element('h3', {}, 'Links between successive axes'),
          table(
              [
                {name: 'Axes'}, {name: 'Distance [mm]', kind: 'number'},
                {name: '95 %', kind: 'number'}, {name: 'Plane-parallel [mm]', kind: 'number'},
                {name: 'Twist [deg]', kind: 'number'}
              ],
              links, 'base'));
}

function fillCentre() {
  const rows = [['rcm', 'Centre, cameras'], ['tip', 'Centre, body'], ['rms', 'RMS over frames']].map(
      ([key, name]) => [name, ...[0, 1, 2].map((c) => millimetres('/' + key + '/' + c)), [
        [0, 1, 2].flatMap((c) => [c ? ', ' : '', millimetres('/' + key + '_interval/' + c)])
      ]]);
  byId('calibration-tables')
      .append(table(
          [
            {name: '[mm]'}, {name: 'x', kind: 'number'}, {name: 'y', kind: 'number'},
            {name: 'z', kind: 'number'}, {name: '\u00b1 95 %', kind: 'number'}
          ],
          rows, 'base'));
}

function fillConstants() {
  const rows = result.constants.map((c, k) => {
    const place = '/constants/' + k;
    const ends = c.identifiable || c.changed ?
        [plainly(place + '/interval/0'), ' to ', plainly(place + '/interval/1')] :
        words(c.why);
    const name = c.name + (c.frame ? ' of ' + c.frame : '');
    return [
      c.changed ? element('strong', {}, name) : name, number(place + '/file', 'plain'),
      number(place + '/found', 'plain'), ends, c.unit
    ];
  });
  byId('calibration-tables')
      .append(table(
          [
            {name: 'Constant'}, {name: 'File', kind: 'number'}, {name: 'Found', kind: 'number'},
            {name: '95 %'}, {name: 'Unit'}
          ],
          rows, 'base'));
}

function fillPoses() {
  const rows = ['transform', 'tool', 'target'].filter((pose) => result[pose]).map((pose) => {
    const place = '/' + pose;
    return [
      words(pose), three(place + '/translation', millimetres), millimetres(place + '/interval_m'),
      [0, 1, 2, 3].flatMap((c) => [c ? ', ' : '', plainly(place + '/quaternion/' + c)]),
      plainly(place + '/interval_deg')
    ];
  });
  byId('calibration-tables')
      .append(table(
          [
            {name: 'Pose'}, {name: 'Translation [mm]', kind: 'number'},
            {name: '\u00b1 mm', kind: 'number'}, {name: 'Quaternion w, x, y, z', kind: 'number'},
            {name: '\u00b1 deg', kind: 'number'}
          ],
          rows, 'base'));
}

function fillCalibration() {
  byId('title').textContent = series.title;
  byId('facts').append(series.facts);
  byId('verdict').append(element('p', {class: 'lead'}, typeset(series.verdict)));
  if (result.comparison) byId('verdict').append(element('p', {}, typeset(result.comparison)));
  if (result.part === 'axis') fillAxes();
  if (result.part === 'rcm') fillCentre();
  if (result.part === 'links') fillConstants();
  if (result.part === 'handeye') fillPoses();
  fillSpace();
  series.histograms.forEach(drawHistogram);
}
