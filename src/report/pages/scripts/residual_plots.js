// What a model leaves, against the motion: one canvas for each joint, model and quantity of motion.

const kSteps = 25;        // of the horizontal axis, for the means
const kFewest = 5;        // samples for a mean
const kPlotHeight = 170;  // [px]
const kMargin = {
  left: 50,
  right: 6,
  top: 6,
  bottom: 20
};
const quantities =
    [['q', 'position', ''], ['dq', 'velocity', '/s'], ['ddq', 'acceleration', '/s\u00b2']];

function rangeOf(lists) {
  let low = Infinity;
  let high = -Infinity;
  for (const values of lists) {
    for (const v of values) {
      if (v === null) continue;
      if (v < low) low = v;
      if (v > high) high = v;
    }
  }
  if (!(high > low)) return [low - 1, low + 1];
  const pad = 0.03 * (high - low);
  return [low - pad, high + pad];
}

/** Round numbers in a range, at most `most` of them. */
function ticks([low, high], most) {
  const rough = (high - low) / most;
  const power = Math.pow(10, Math.floor(Math.log10(rough)));
  const step = [1, 2, 5, 10].map((m) => m * power).find((s) => s >= rough);
  const decimals = Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
  const out = [];
  for (let k = Math.ceil(low / step); k * step <= high; ++k) {
    out.push({
      at: k * step,
      text: withMinus((k * step + 0).toFixed(decimals).replace(/^-(0\.?0*)$/, '$1'))
    });
  }
  return out;
}

function drawAxes(pen, size, xRange, yRange, x, y) {
  pen.font = '11px system-ui, sans-serif';
  pen.fillStyle = '#55554f';
  pen.lineWidth = 1;
  pen.strokeStyle = '#e6e6e2';
  const line = (x1, y1, x2, y2) => {
    pen.beginPath();
    pen.moveTo(x1, y1);
    pen.lineTo(x2, y2);
    pen.stroke();
  };
  pen.textAlign = 'right';
  pen.textBaseline = 'middle';
  for (const tick of ticks(yRange, 5)) {
    line(kMargin.left, y(tick.at), size.width - kMargin.right, y(tick.at));
    pen.fillText(tick.text, kMargin.left - 5, y(tick.at));
  }
  pen.textAlign = 'center';
  pen.textBaseline = 'top';
  for (const tick of ticks(xRange, Math.max(2, Math.floor(size.width / 55)))) {
    line(x(tick.at), kMargin.top, x(tick.at), size.height - kMargin.bottom);
    pen.fillText(tick.text, x(tick.at), size.height - kMargin.bottom + 5);
  }
  pen.strokeStyle = '#8c8c86';
  if (yRange[0] < 0 && yRange[1] > 0) line(kMargin.left, y(0), size.width - kMargin.right, y(0));
}

/** Mean of the points in each step of the range: [[middle of the step, mean], ...]. */
function means(points, [low, high]) {
  const sums = Array.from({length: kSteps}, () => [0, 0]);
  for (const [a, b] of points) {
    const sum =
        sums[Math.min(kSteps - 1, Math.max(0, Math.floor(kSteps * (a - low) / (high - low))))];
    sum[0] += 1;
    sum[1] += b;
  }
  return sums.map(
      ([count, sum],
       k) => [low + (k + 0.5) * (high - low) / kSteps, count >= kFewest ? sum / count : null]);
}

function drawMeans(pen, list, colour, x, y) {
  pen.beginPath();
  let drawing = false;
  for (const [a, b] of list) {
    if (b !== null) drawing ? pen.lineTo(x(a), y(b)) : pen.moveTo(x(a), y(b));
    drawing = b !== null;
  }
  // A pale edge keeps the line apart from its own points.
  pen.lineJoin = 'round';
  pen.strokeStyle = '#ffffff';
  pen.lineWidth = 4.5;
  pen.stroke();
  pen.strokeStyle = colour;
  pen.lineWidth = 2.2;
  pen.stroke();
}

/** @param groups  [{name, colour, points: [[x, y], ...]}] */
function drawScatter(plot, xRange, yRange, groups) {
  const canvas = plot.querySelector('canvas');
  const size = {width: canvas.clientWidth, height: kPlotHeight};
  const density = window.devicePixelRatio || 1;
  canvas.width = Math.round(size.width * density);
  canvas.height = Math.round(size.height * density);
  const pen = canvas.getContext('2d');
  pen.scale(density, density);
  const x = (v) => kMargin.left +
      (size.width - kMargin.left - kMargin.right) * (v - xRange[0]) / (xRange[1] - xRange[0]);
  const y = (v) => size.height - kMargin.bottom -
      (size.height - kMargin.top - kMargin.bottom) * (v - yRange[0]) / (yRange[1] - yRange[0]);
  drawAxes(pen, size, xRange, yRange, x, y);
  const drawn = groups.map((group) => {
    pen.fillStyle = group.colour;
    pen.globalAlpha = 0.3;
    for (const [a, b] of group.points) pen.fillRect(x(a) - 0.8, y(b) - 0.8, 1.6, 1.6);
    pen.globalAlpha = 1;
    return {name: group.name, colour: group.colour, points: group.points.length};
  });
  for (const group of groups) drawMeans(pen, means(group.points, xRange), group.colour, x, y);
  noteDrawn(plot, canvas, drawn);
}

// Points of a residual by the direction in which the joint moves.
function byDirection(x, residual, speed) {
  const groups = [{name: 'forward', points: []}, {name: 'backward', points: []}];
  residual.forEach((r, k) => {
    if (r === null || x[k] === null || !speed[k]) return;
    groups[speed[k] > 0 ? 0 : 1].points.push([x[k], r]);
  });
  return groups.map((group) => ({...group, colour: colours[group.name]}));
}

function residualRow(recording, joint, mover, name, yRange) {
  const motion = recording.joints[mover - 1];
  const residual = residualOf(recording.joints[joint - 1], name);
  const units = series.joints[mover - 1];
  return quantities.map(([key, quantity, per]) => {
    const caption = (name === 'extended'               ? 'Extended: ' :
                         result.command === 'identify' ? '' :
                                                         'As it stands: ') +
        quantity + ' [' + units.unit + per + ']';
    const plot = element(
        'div', {
          class: 'plot residual',
          'data-plot': 'residual',
          'data-joint': joint,
          'data-model': name,
          'data-against': key
        },
        element('p', {class: 'caption'}, caption), element('canvas'));
    const draw = () => drawScatter(
        plot, rangeOf([motion[key]]), yRange, byDirection(motion[key], residual, motion.dq));
    return {plot, draw};
  });
}

let residualPlots = [];  // {plot, draw}

/**
 * Draws the chosen joints (from 1), against their own motion or that of joint `against` (from 1;
 * 0: their own).
 */
function drawResidualPlots(recording, joints, against) {
  const place = byId('residual-plots');
  place.replaceChildren();
  residualPlots = [];
  for (const joint of joints) {
    const mover = against || joint;
    const data = recording.joints[joint - 1];
    const names = curvesOf(data).slice(1);
    const yRange = rangeOf(names.map((name) => residualOf(data, name)));
    const parts = names.flatMap((name) => residualRow(recording, joint, mover, name, yRange));
    const title = jointName(joint) + ': residual [' + series.joints[joint - 1].torque_unit +
        '] against the motion of ' +
        (mover === joint ? 'the joint' : jointName(mover).toLowerCase());
    place.append(
        element('h3', {}, title),
        element('div', {class: 'residual-grid models-' + names.length}, parts.map((p) => p.plot)));
    residualPlots.push(...parts);
  }
  redrawResidualPlots();
}

function redrawResidualPlots() {
  for (const one of residualPlots) one.draw();
}
