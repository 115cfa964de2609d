// Torque over time, one zoomable plot a joint with its error beneath; all share one stretch of
// time.

const kPaperWidth = 690;  // [px] between the margins of A4 and of letter paper
// [px] Each line is seen on the one below it.
const widths = {
  time: {measured: 5, model: 2.6, extended: 1.2},
  error: {model: 1.8, extended: 1.2}
};
const timePlots = [];  // {graph, plot, curves}

function noteTimePlot({graph, plot, curves}) {
  const [from, to] = graph.xAxisRange();
  const points = curves.map(() => 0);
  let gaps = 0;
  for (let row = 0; row < graph.numRows(); ++row) {
    const t = graph.getValue(row, 0);
    if (t < from || t > to) continue;
    if (curves.every((_, k) => !isNumber(graph.getValue(row, k + 1)))) ++gaps;
    curves.forEach((c, k) => {
      if (isNumber(graph.getValue(row, k + 1))) ++points[k];
    });
  }
  plot.dataset.gaps = gaps;
  noteDrawn(plot, plot.querySelector('canvas'), curves.map((c, k) => ({...c, points: points[k]})));
}

/** Shows one stretch of time in all plots; null shows all of it. */
function showTime(range) {
  for (const one of timePlots) {
    one.graph.updateOptions({dateWindow: range});
    noteTimePlot(one);
  }
}

// Moments that the result leaves out, as pale bands behind the curves.
function markLeftOut(joint, recording) {
  const parts =
      (result.left_out || [])
          .filter(
              (part) => part.file === recording.source && (!part.joint || part.joint === joint));
  return (pen, area, graph) => {
    pen.fillStyle = '#f3e3c8';
    for (const part of parts) {
      const [from, to] = [graph.toDomXCoord(part.from), graph.toDomXCoord(part.to)];
      pen.fillRect(from, area.y, to - from, area.h);
    }
  };
}

function readoutText(graph, row, curves, unit) {
  const value = (k) => {
    const v = graph.getValue(row, k + 1);
    return isNumber(v) ? withMinus(v.toPrecision(3)) : '\u2013';
  };
  return 't = ' + graph.getValue(row, 0).toFixed(2) +
      ' s: ' + curves.map((c, k) => c.name + ' ' + value(k)).join(', ') + ' ' + unit;
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

function timePlot(place, kind, joint, recording, curves, unit, readout) {
  const plot = element('div', {class: 'plot ' + kind, 'data-plot': kind, 'data-joint': joint});
  const canvas = element('div', {class: 'canvas'});
  plot.append(canvas);
  place.append(plot);
  const graph = new Dygraph(canvas, rowsOf(recording, curves.map((c) => c.values)), {
    labels: ['time'].concat(curves.map((c) => c.name)),
    colors: curves.map((c) => c.colour),
    series: Object.fromEntries(curves.map((c) => [c.name, {strokeWidth: c.width}])),
    legend: 'never',
    axisLabelFontSize: 12,
    axisLineColor: '#9a9a95',
    gridLineColor: '#e6e6e2',
    highlightCircleSize: 3,
    xRangePad: 2,
    includeZero: kind === 'error',
    axes: {
      x: {drawAxis: kind === 'error'},
      y: {
        axisLabelWidth: 56,
        pixelsPerLabel: kind === 'error' ? 20 : 36,
        axisLabelFormatter: (v) => withMinus(String(Number(v.toPrecision(4))))
      },
    },
    interactionModel: touchTwoFingers(),
    underlayCallback: markLeftOut(joint, recording),
    zoomCallback: (from, to) => showTime([from, to]),
    highlightCallback: (event, x, points, row) => {
      readout.textContent = readoutText(graph, row, curves, unit);
      for (const other of timePlots) {
        if (other.graph !== graph) other.graph.setSelection(row);
      }
    },
    unhighlightCallback: () => {
      readout.textContent = '';
      for (const other of timePlots) other.graph.clearSelection();
    },
  });
  timePlots.push({graph, plot, curves});
  noteTimePlot(timePlots[timePlots.length - 1]);
}

// On paper the plots are scaled as they stand: the style sheet multiplies by this.
function fitTimePlotsToPaper() {
  const place = byId('time-plots');
  if (!place) return;
  place.style.setProperty('--to-paper', (kPaperWidth / Math.max(1, place.clientWidth)).toFixed(3));
}

/** Draws the chosen joints (from 1) of a recording. */
function drawTimePlots(recording, joints) {
  for (const one of timePlots.splice(0)) one.graph.destroy();
  byId('time-plots').replaceChildren();
  for (const joint of joints) {
    const data = recording.joints[joint - 1];
    const unit = series.joints[joint - 1].torque_unit;
    const readout = element('span', {class: 'readout'});
    const names = curvesOf(data);
    const place = element(
        'div', {class: 'joint'}, element('h3', {}, jointName(joint) + ' [' + unit + ']', readout));
    byId('time-plots').append(place);
    timePlot(
        place, 'time', joint, recording, names.map((name) => ({
                                                     name: curveNames[name],
                                                     colour: colours[name],
                                                     width: widths.time[name],
                                                     values: data[name]
                                                   })),
        unit, readout);
    timePlot(
        place, 'error', joint, recording, names.slice(1).map((name) => ({
                                                               name: curveNames[name],
                                                               colour: colours[name],
                                                               width: widths.error[name],
                                                               values: residualOf(data, name)
                                                             })),
        unit, readout);
  }
  fitTimePlotsToPaper();
}

function key(name) {
  return element(
      'span', {class: 'key'}, element('i', {style: 'background:' + colours[name]}),
      curveNames[name] || name);
}
