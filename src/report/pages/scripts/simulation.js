// What simulate found: a replay, a run under a controller, or the breakaway in ramps of force.

const simulated = {
  colours: {recorded: colours.measured, model: colours.model, simulated: colours.extended},
  widths: {
    time: {recorded: 5, model: 2.6, simulated: 1.2},
    error: {model: 2.2, simulated: 1.2},
  },
};

function drawSimulation() {
  for (const one of timePlots.splice(0)) one.graph.destroy();
  byId('time-plots').replaceChildren();
  const recording = series.recordings[0];
  for (const joint of chosenJoints()) {
    const place = element('div', {class: 'joint'}, element('h3', {}, jointName(joint)));
    byId('time-plots').append(place);
    for (const plot of recording.joints[joint - 1].plots) {
      const readout = element('span', {class: 'readout'});
      place.append(
          element('p', {class: 'caption'}, plot.title + ' [' + typeset(plot.unit) + ']', readout));
      timePlot(
          place, plot.kind, joint, recording,
          plot.curves.map((c) => ({
                            ...c,
                            colour: simulated.colours[c.style],
                            width: simulated.widths[plot.kind][c.style]
                          })),
          plot.unit, readout);
    }
  }
  fitTimePlotsToPaper();
}

function keyOf(name, style) {
  return element(
      'span', {class: 'key'}, element('i', {style: 'background:' + simulated.colours[style]}),
      name);
}

function startSimulationPlots() {
  if (series.joints.length > kStacked) chosen.joint = 1;
  const joints = [[0, 'all']].concat(series.joints.map((_, i) => [i + 1, jointName(i + 1)]));
  const joint = chooser('Joint', [{options: joints}], (value) => {
    chosen.joint = Number(value);
    drawSimulation();
    noteState();
  });
  joint.querySelector('select').value = chosen.joint;
  const whole = element('button', {type: 'button'}, 'Whole run');
  whole.addEventListener('click', () => showTime(null));
  byId('chooser').append(joint, whole);
  const styles = new Map(series.recordings[0].joints.flatMap(
      (j) => j.plots.flatMap((plot) => plot.curves.map((c) => [c.name, c.style]))));
  byId('time-keys').append(...[...styles].map(([name, style]) => keyOf(name, style)));
  drawSimulation();
}

// ---- ramps

const rampPlots = [];  // {plot, ramps, unit}

function drawRamps({plot, ramps}) {
  const canvas = plot.querySelector('canvas');
  const size = {width: canvas.clientWidth, height: canvas.clientHeight};
  const density = window.devicePixelRatio || 1;
  canvas.width = Math.round(size.width * density);
  canvas.height = Math.round(size.height * density);
  const pen = canvas.getContext('2d');
  pen.scale(density, density);
  const all = ramps.flatMap((r) => [...r.recorded, ...r.simulated]);
  const marks = ramps.flatMap((r) => [r.at.recorded, r.at.simulated]).filter(isNumber);
  const xRange = rangeOf([all.map((p) => p[0]).concat(marks)]);
  const yRange = rangeOf([all.map((p) => p[1])]);
  const x = (v) => kMargin.left +
      (size.width - kMargin.left - kMargin.right) * (v - xRange[0]) / (xRange[1] - xRange[0]);
  const y = (v) => size.height - kMargin.bottom -
      (size.height - kMargin.top - kMargin.bottom) * (v - yRange[0]) / (yRange[1] - yRange[0]);
  drawAxes(pen, size, xRange, yRange, x, y);
  const drawn = ['recorded', 'simulated'].map((name) => {
    pen.strokeStyle = pen.fillStyle = simulated.colours[name];
    pen.lineWidth = 1.3;
    let points = 0;
    for (const ramp of ramps) {
      pen.beginPath();
      ramp[name].forEach(([a, b], k) => k ? pen.lineTo(x(a), y(b)) : pen.moveTo(x(a), y(b)));
      pen.stroke();
      points += ramp[name].length;
      if (isNumber(ramp.at[name]))
        pen.fillRect(
            x(ramp.at[name]) - 1, name === 'recorded' ? kMargin.top : kMargin.top + 10, 2, 9);
    }
    return {name, colour: simulated.colours[name], points};
  });
  noteDrawn(plot, canvas, drawn);
}

function startRampPlots() {
  const ramps = series.ramps.map(
      (curves, k) => ({
        ...curves,
        direction: result.ramps[k].direction,
        at: {recorded: result.ramps[k].recorded.effort, simulated: result.ramps[k].simulated.effort}
      }));
  byId('ramp-keys').append(keyOf('recorded', 'recorded'), keyOf('simulated', 'simulated'));
  for (const [direction, name] of [[1, 'Forwards'], [-1, 'Backwards']]) {
    const mine = ramps.filter((ramp) => ramp.direction === direction);
    if (!mine.length) continue;
    const plot = element(
        'div', {class: 'plot ramps', 'data-plot': 'ramps', 'data-joint': result.joint},
        element(
            'p', {class: 'caption'},
            name + ': way [' + series.way_unit + '] over effort [' + typeset(result.unit) + ']'),
        element('canvas'));
    byId('ramp-plots').append(plot);
    rampPlots.push({plot, ramps: mine});
  }
  rampPlots.forEach(drawRamps);
}

// ---- words and tables

function breakawayTable() {
  const unit = '\u00a0' + typeset(result.unit);
  const effort = (place) => [number(place, 'plain', (v) => withMinus(v.toFixed(3))), unit];
  const rows = result.ramps.map((ramp, k) => {
    const place = '/ramps/' + k;
    return [
      number(place + '/rest_from', 'plain', (v) => v.toFixed(2)),
      ramp.direction > 0 ? 'forwards' : 'backwards', effort(place + '/recorded/effort'),
      effort(place + '/simulated/effort')
    ];
  });
  const medians = ['forward', 'backward'].map(
      (side) =>
          [element('strong', {}, 'median'), side + 's', effort('/' + side + '/recorded'),
           effort('/' + side + '/simulated')]);
  return table(
      [
        {name: 'At rest from [s]', kind: 'number'}, {name: 'Direction'},
        {name: 'Recorded', kind: 'number'}, {name: 'Simulated', kind: 'number'}
      ],
      medians.concat(rows), 'breakaway');
}

function runTable() {
  const places = [
    ['Torque, simulated [%]', '/torque/relative_error', 'percent'],
    ['Torque, model alone [%]', '/torque/prediction_relative_error', 'percent'],
    ['Motion, rms', '/motion/rms_error', 'milli'],
    ['Motion, largest', '/motion/max_error', 'milli'],
    ['Off the set point, largest', '/largest_deviation', 'milli']
  ].filter(([, place]) => Array.isArray(valueAt(place)) && valueAt(place).some(isNumber));
  const milli = (place, i) => {
    const shown = number(place + '/' + i, 'milli');
    return [shown, '\u00a0m' + series.joints[i].unit];
  };
  return table(
      [{name: 'Joint'}].concat(places.map(([name]) => ({name, kind: 'number'}))),
      series.joints.map(
          (joint, i) => [element('strong', {}, i + 1 + ' ' + joint.name)].concat(places.map(
              ([, place, style]) =>
                  style === 'percent' ? number(place + '/' + i, 'percent') : milli(place, i)))),
      'errors');
}

// What the run comes to, in a few lines.
function simulationWords(ramps) {
  if (ramps) {
    if (!result.ramps.length) return [element('p', {class: 'lead'}, 'No ramps were found.')];
    return ['forward', 'backward']
        .filter((side) => isNumber(valueAt('/' + side + '/recorded')))
        .map((side) => {
          const effort = (which) =>
              [number('/' + side + '/' + which, 'plain', (v) => withMinus(v.toFixed(3))),
               '\u00a0' + typeset(result.unit)];
          return element(
              'p', {class: 'lead'}, words(result.coordinate) + ' slides ' + side + 's at ',
              effort('recorded'), ' in the recording, at ', effort('simulated'),
              ' in the simulation (medians).');
        });
  }
  if (result.torque)
    return errorsInWords('Simulated torque, off the recorded one:', '/torque/relative_error/');
  return [];
}

function fillSimulation() {
  byId('title').textContent = result.robot;
  const ramps = Boolean(series.ramps);
  const source = ramps ? series.source : series.recordings[0].source;
  byId('facts').append(
      result.torque ? 'Replay of ' + fileName(source) :
          ramps     ? 'Breakaway of ' + result.coordinate + ' in ' + fileName(source) :
                      'Under a controller along ' + fileName(source));
  for (const node of document.querySelectorAll(ramps ? '.with-time' : '.with-ramps')) node.remove();
  byId('errors-title').textContent = ramps ? 'Effort at which it slides' : 'Errors per joint';
  byId('errors-note').textContent = ramps ?
      'The joint slides when it is faster than the speed of the run\u2019s settings; the model starts each ' +
          'ramp at rest under the recorded effort and is pushed with the recorded one.' :
      result.torque ?
      'Torque: recorded minus simulated, in % of the recorded torque, both low-passed. Model ' +
          'alone: the torque that the model asks for at the recorded motion, without simulation.' :
      'How far the simulated arm was from its set points.';
  byId('verdict').append(...simulationWords(ramps));
  if (result.complete === false)
    byId('verdict').append(
        element('p', {class: 'warning'}, 'Incomplete: the run ' + result.stopped.why));
  byId('error-table').append(ramps ? breakawayTable() : runTable());
  if (ramps) {
    startRampPlots();
  } else {
    startSimulationPlots();
  }
}
