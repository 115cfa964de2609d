// Signals over time, one zoomable plot each; all share one stretch of time and one moment.

const kPaperWidth = 690;  // [px] between the margins of A4 and of letter paper
const kStacked = 4;       // joints shown at once before one is chosen for a start
const kDrawnPoints = 1500;  // of a curve that is a drawing
const kSameColour = 60;   // distance of red, green and blue together
const kVisible = 40;      // of 255
const timePlots = [];     // {graph, plot, curves, unit, title}
let moment = null;        // [s] that the arm and all plots show

// For tests: pixels in a curve's colour that were really drawn.
function pixelsOf(canvas, hex) {
  const wanted = [1, 3, 5].map((at) => parseInt(hex.slice(at, at + 2), 16));
  const copy = element('canvas', {width: canvas.width, height: canvas.height});
  const pen = copy.getContext('2d', {willReadFrequently: true});
  pen.drawImage(canvas, 0, 0);
  const data = pen.getImageData(0, 0, copy.width, copy.height).data;
  let count = 0;
  for (let k = 0; k < data.length; k += 4) {
    const away = Math.abs(data[k] - wanted[0]) + Math.abs(data[k + 1] - wanted[1]) + Math.abs(data[k + 2] - wanted[2]);
    if (data[k + 3] > kVisible && away < kSameColour) ++count;
  }
  return count;
}

function noteTimePlot({graph, plot, curves}) {
  const [from, to] = graph.xAxisRange();
  const points = curves.map(() => 0);
  let gaps = 0;
  for (let row = 0; row < graph.numRows(); ++row) {
    const t = graph.getValue(row, 0);
    if (t < from || t > to) continue;
    if (curves.every((_, k) => !isNumber(graph.getValue(row, k + 1)))) ++gaps;
    curves.forEach((c, k) => points[k] += isNumber(graph.getValue(row, k + 1)) ? 1 : 0);
  }
  const canvas = plot.querySelector('canvas');
  plot.dataset.gaps = gaps;
  plot.dataset.points = curves.map((c, k) => c.name + ':' + points[k]).join(' ');
  plot.dataset.pixels = curves.map((c) => c.name + ':' + pixelsOf(canvas, c.colour)).join(' ');
}

/** Shows one stretch of time in all plots; null shows all of it. */
function showTime(range) {
  for (const one of timePlots) {
    one.graph.updateOptions({dateWindow: range});
    noteTimePlot(one);
  }
}

/** Marks a moment in all plots; the arm follows by itself. */
function showMoment(t) {
  moment = t;
  for (const {graph, plot} of timePlots) {
    const [from, to] = graph.xAxisRange();
    const line = plot.querySelector('.moment');
    line.hidden = t === null || t < from || t > to;
    if (!line.hidden) line.style.left = graph.toDomXCoord(t) + 'px';
  }
}

// Moments that the result leaves out, as pale bands behind the curves.
function markLeftOut(joint, recording) {
  const parts = (result.excluded_intervals || []).filter((part) => part.file === recording.source && (!part.joint || part.joint === joint));
  return (pen, area, graph) => {
    pen.fillStyle = colour('left-out');
    for (const part of parts) {
      const [from, to] = [graph.toDomXCoord(part.from), graph.toDomXCoord(part.to)];
      pen.fillRect(from, area.y, to - from, area.h);
    }
  };
}

function readoutText(graph, row, curves, unit) {
  const value = (k) => short(graph.getValue(row, k + 1));
  return 't = ' + graph.getValue(row, 0).toFixed(2) + ' s: ' + curves.map((c, k) => c.name + ' ' + value(k)).join(', ') + ' ' + unit;
}

// One finger scrolls the page, two zoom the plot.
function touchTwoFingers() {
  const usual = Dygraph.defaultInteractionModel;
  const model = Object.assign({}, usual);
  for (const event of ['touchstart', 'touchmove', 'touchend']) {
    model[event] = (e, graph, context) => {
      if (e.touches.length > 1 || event === 'touchend') usual[event](e, graph, context);
    };
  }
  return model;
}

// The same plot as a drawing, for files and paper.
function timeSpec({graph, curves, unit, title}) {
  const [from, to] = graph.xAxisRange();
  const points = (k) => Array.from({length: graph.numRows()}, (_, row) => [graph.getValue(row, 0), graph.getValue(row, k + 1)])
                            .filter(([t]) => t >= from && t <= to);
  return {title, x: {name: 'time [s]', range: [from, to]}, y: {name: unit}, width: kPaperWidth, height: 220,
          marks: curves.map((c, k) => ({kind: 'line', name: c.name, colour: c.style, width: c.width, points: points(k)}))};
}

/** @param curves  [{name, style, values}], style out of kCurve */
function timePlot(place, {kind, joint, recording, title, curves: wanted, unit}) {
  const curves = wanted.map((c) => {
    const [name, width] = kCurve[c.style];
    return {...c, style: name, colour: colour(name), width: kind === 'error' ? Math.min(width, 1.8) : width};
  });
  if (!window.Dygraph) {  // built where the plot library was not installed: drawings without zoom
    const step = Math.ceil(recording.time.length / kDrawnPoints);
    const points = (values) => recording.time.map((t, k) => [t, values[k]]).filter((_, k) => k % step === 0);
    place.append(chart({name: kind, joint, title, x: {name: 'time [s]'}, y: {name: unit}, width: kPaperWidth, height: 220,
                        marks: curves.map((c) => ({kind: 'line', name: c.name, colour: c.style, width: c.width, points: points(c.values)}))}));
    return;
  }
  const readout = element('span', {class: 'readout', 'aria-live': 'off'});
  const canvas = element('div', {class: 'canvas'});
  const plot = element('div', {class: 'plot ' + kind, 'data-plot': kind, 'data-joint': joint, role: 'img',
                               'aria-label': title + ' over time'}, canvas, element('i', {class: 'moment', hidden: ''}));
  const one = {plot, curves, unit, title};
  place.append(paragraph('caption', title + ' [' + typeset(unit) + ']', readout, saveButtons(title, () => svgFile(chartDrawing(timeSpec(one))), () => csvOf(timeSpec(one)))), plot);
  one.graph = new Dygraph(canvas, rowsOf(recording, curves.map((c) => c.values)), {
    labels: ['time'].concat(curves.map((c) => c.name)),
    colors: curves.map((c) => c.colour),
    series: Object.fromEntries(curves.map((c) => [c.name, {strokeWidth: c.width}])),
    legend: 'never',
    axisLabelFontSize: 12,
    axisLineColor: colour('quiet'),
    gridLineColor: colour('line'),
    highlightCircleSize: 3,
    xRangePad: 2,
    includeZero: kind === 'error',
    axes: {
      y: {axisLabelWidth: 56, pixelsPerLabel: kind === 'error' ? 20 : 36, axisLabelFormatter: (v) => withMinus(String(Number(v.toPrecision(4))))},
    },
    interactionModel: touchTwoFingers(),
    underlayCallback: markLeftOut(joint, recording),
    zoomCallback: (from, to) => showTime([from, to]),
    highlightCallback: (event, x, points, row) => {
      readout.textContent = readoutText(one.graph, row, curves, unit);
      for (const arm of arms) arm.show(x);
      showMoment(x);
    },
    unhighlightCallback: () => readout.textContent = '',
  });
  timePlots.push(one);
  noteTimePlot(one);
}

function clearTimePlots() {
  for (const one of timePlots.splice(0)) one.graph.destroy();
}

// On paper plots over time are drawings.
window.addEventListener('beforeprint', () => {
  for (const one of timePlots) one.plot.append(element('div', {class: 'paper'}, chartDrawing(timeSpec(one))));
  for (const part of document.querySelectorAll('details')) part.open = true;
});
window.addEventListener('afterprint', () => document.querySelectorAll('.paper').forEach((node) => node.remove()));

/**
 * A part of the page with plots over time: choosers of recording and joint, keys, plots.
 * @param plotsOf  (recording, joint from 1) => [{kind, title, unit, curves}]
 * @param more     drawn after them with the same choice: {choosers, draw(recording, joints)}
 */
function timePanel(plotsOf, more, about) {
  const recordings = series.recordings.filter((r) => r.time.length);
  if (!recordings.length) return null;
  const chosen = {recording: 0, joint: series.joints.length > kStacked ? about || 1 : 0};
  const plots = element('div', {id: 'time-plots'});
  const keys = paragraph('keys');
  const box = element('div', {class: 'chooser', id: 'chooser'});
  const draw = () => {
    const recording = recordings[chosen.recording];
    const joints = chosen.joint || !series.joints.length ? [chosen.joint || 1] : series.joints.map((_, i) => i + 1);
    clearTimePlots();
    plots.replaceChildren();
    const seen = new Map();
    for (const joint of joints) {
      const place = element('div', {class: 'joint'}, series.joints.length ? heading(jointName(joint)) : null);
      plots.append(place);
      for (const plot of plotsOf(recording, joint)) {
        plot.curves.forEach((c) => seen.set(c.name, kCurve[c.style][0]));
        timePlot(place, {...plot, joint, recording});
      }
    }
    keys.replaceChildren(...[...seen].map(([name, style]) => key(name, style)));
    if (more) more.draw(recording, joints);
    showMoment(moment);
  };
  redraws.push(draw);
  const choose = (what) => (value) => {
    chosen[what] = Number(value);
    draw();
    if (what === 'recording') for (const arm of arms) arm.choose(recordings[chosen.recording]);
    noteState();
  };
  const groups = groupBy(recordings, (r) => r.role).map((group) => ({name: group[0].item.role, options: group.map(({item, k}) => [k, fileName(item.source)])}));
  if (recordings.length > 1) box.append(chooser('Recording', groups, choose('recording')));
  if (series.joints.length > 1) {
    const joint = chooser('Joint', [{options: [[0, 'all']].concat(jointOptions())}], choose('joint'));
    joint.querySelector('select').value = chosen.joint;
    box.append(joint);
  }
  if (more) box.append(...more.choosers(draw));
  box.append(button('All of the time', () => showTime(null)));
  if (series.left_out) box.append(element('span', {class: 'small'}, series.left_out + ' more recordings are not in this page.'));
  return [box, keys, plots];
}
