// Pages of motions: excite, simulate, watch, kinematics, info.

const kLittleUsed = 0.2;  // share of a range below which a joint hardly moves

/** Plots that come ready with a recording. */
function givenPlots(recording, joint) {
  return recording.joints[joint - 1].plots;
}

const timeNote = 'Drag across a plot to zoom, all plots follow; a double click shows all again. Over a plot the arm stands as it did then.';

// ---- excite

function usedShares() {
  return result.joints.map((joint, i) => {
    const given = (result.used || [])[i];
    const data = series.recordings[0].joints[i];
    const reach = (values) => Math.max(...values) - Math.min(...values);
    const share = (value, most) => isNumber(most) && most > 0 ? value / most : null;
    const most = (values) => Math.max(...values.map(Math.abs));
    const {position, velocity} = joint.limits || {};
    return given || {range: position ? share(reach(data.q), position[1] - position[0]) : null, velocity: share(most(data.dq), velocity)};
  });
}

function usedBars(used) {
  const rows = used.flatMap((u, i) => ['range', 'velocity', 'effort'].filter((what) => isNumber(u[what])).map((what) => ({
    label: shortJoint(i + 1) + ', ' + what, value: short(100 * u[what], 2) + ' %',
    parts: [{from: 0, to: Math.min(1, u[what]), colour: u[what] < kLittleUsed && what !== 'effort' ? 'bad' : 'extended'}]})));
  return rows.length ? rowChart({name: 'used', joint: 0, title: 'Share of the limits that the motion uses', width: 560, left: 170, right: 70, range: [0, 1],
    marks: [0, 0.5, 1].map((at) => ({at, text: 100 * at + ' %'})), rows}) : null;
}

function discriminationWords() {
  const d = result.discrimination;
  const share = (k) => [number('/discrimination/share_left/' + k, 'percent'), '\u00a0%'];
  return d ? paragraph('', 'Of what the rest of the model leaves of ' + words(d.between[0]) + ', ', share(0), ' cannot be taken for ' + words(d.between[1]) + '; the other way round ', share(1), '.') : null;
}

function predictionWords(p) {
  return ['Predicted standard deviations of the base parameters, relative to the values ' + p.values + ': median ', percent('/prediction/median_relative_std'), ', mean ',
    percent('/prediction/mean_relative_std'), '. Noise of the torques (' + p.noise.source + '): ',
    ...p.noise.share_of_rms_torque.flatMap((_, i) => [i ? ', ' : '', percent('/prediction/noise/share_of_rms_torque/' + i)]),
    ' of the rms torque of each joint, one independent sample in ', number('/prediction/noise/seconds_between_independent_samples', 'plain'),
    '\u00a0s. Hardest to tell from each other: ' + result.weakest.slice(0, 5).map((w) => w.parameter).join(', ') + '.'];
}

function motionPlots(recording, joint) {
  const data = recording.joints[joint - 1];
  return quantities.map(([part, name, per]) => ({
    kind: 'error', title: name[0].toUpperCase() + name.slice(1), unit: series.joints[joint - 1].unit + per,
    curves: [{name, style: 'extended', values: data[part]}].concat((data.limits || {})[part] ? data.limits[part].map((limit, side) => ({
      name: side ? 'highest' : 'lowest', style: 'limit', values: data[part].map(() => limit)})).filter((c) => isNumber(c.values[0])) : [])}));
}

pages.excite = () => {
  const used = usedShares();
  const idle = used.map((u, i) => isNumber(u.range) && u.range < kLittleUsed && !(u.velocity >= kLittleUsed) ? i + 1 : 0).filter(Boolean);
  const over = result.margins.filter((m) => isNumber(m.margin) && m.margin < 0);
  const bound = (place, value) => isNumber(value) ? number(place, 'plain') : 'open';
  const output = wordAfter('-o') || 'TRAJECTORY.csv';
  return {
    title: result.robot, kind: 'Excitation',
    facts: [words(result.criterion) + ', searched by ' + result.solver + (result.interrupted ? ', interrupted: the best so far' : '')],
    lead: over.length ? 'The motion leaves its limits: ' + listed(over.map((m) => m.limit)) + '.' :
        idle.length ? (idle.length === 1 ? 'Joint ' : 'Joints ') + listed(idle.map(String)) + ' hardly move' + (idle.length === 1 ? 's' : '') + '; all limits are kept.' :
                      'Every joint moves, and all limits are kept.',
    state: over.length || idle.length ? 'bad' : 'good',
    good: [
      paragraph('', number('/periods', 'whole'), ' periods of ', number('/frequency', 'plain', (f) => significant(1 / f, 4)), '\u00a0s in ', number('/harmonics', 'whole'), ' harmonics, ',
                number('/duration', 'plain'), '\u00a0s in all', result.slow_seconds ? ['; slow passes of one joint after the other follow for ', number('/slow_seconds', 'plain'), '\u00a0s.'] : '.',
                ' Condition number ', number('/condition_number', 'plain'), ' against ', number('/start_condition_number', 'plain'), ' of a random motion, for ',
                number('/base_parameters', 'whole'), ' base parameters.'),
      discriminationWords(), ...(result.warnings || []).map((w) => paragraph('warning', typeset(w))), usedBars(used)],
    next: [{why: 'Record it on the arm (it starts and stops at rest), or try it in simulation:', command: 'veridyn simulate ' + fileOfRun(result.robot) + ' --trajectory ' + output + ' -o RECORDING.csv'},
           {why: 'Then:', command: 'veridyn identify ' + fileOfRun(result.robot) + ' --train RECORDING.csv --test OTHER.csv --report model.html'}],
    picture: armView(),
    sections: [
      section('over-time', 'Motion', 'From rest to rest; thin lines are the limits. ' + timeNote, timePanel(motionPlots, null, 1)),
      section('limits', 'Limits', 'What the motion reaches, on its samples and between them, beside what is allowed. The margin is the distance to the nearer bound.',
              table(['Limit', '#Motion', '#Allowed', '#Margin', 'Unit'], result.margins.map((limit, k) => {
                const place = '/margins/' + k;
                return [strong(limit.limit), [number(place + '/motion/0', 'plain'), ' to ', number(place + '/motion/1', 'plain')],
                        [bound(place + '/bounds/0', limit.bounds[0]), ' to ', bound(place + '/bounds/1', limit.bounds[1])], number(place + '/margin', 'plain'), typeset(limit.unit)];
              }), 'base')),
      section('parameters', 'What it will identify', result.prediction ? null : 'The values of the arm are not known.', result.prediction ? [
        paragraph('note', predictionWords(result.prediction)),
        table(['Base parameter, led by', '#Value', '#Std. deviation', '#Relative', 'Unit'], result.prediction.base_parameters.map((one, k) => {
          const place = '/prediction/base_parameters/' + k;
          return [element('span', {class: 'expression'}, one.name), number(place + '/value', 'plain'), number(place + '/std', 'plain'), percent(place + '/relative_std'), typeset(one.unit)];
        }), 'base'),
        grid(parameterDots(result.prediction.base_parameters))] : null),
      section('numerics', 'Numerics', null, folded('Condition numbers', factList([
        ['Columns as they are', '/plain_condition_number'], ['Columns scaled by their range', '/range_condition_number'], ['Essential parameters', '/essential/count', 'whole'],
        ['Condition number of these', '/essential/condition_number'],
        result.condition_number_with_given !== result.condition_number ? ['Together with given recordings', '/condition_number_with_given'] : ['', '/none'],
        ['Search [s]', '/seconds']])))
    ]
  };
};

// ---- simulate

function runTable() {
  const places = [['Torque, simulated [%]', '/torque/relative_error', 'percent'], ['Torque, model alone [%]', '/torque/prediction_relative_error', 'percent'],
    ['Motion, rms', '/motion/rms_error', 'milli'], ['Motion, largest', '/motion/max_error', 'milli'], ['Off the set point, largest', '/largest_deviation', 'milli']]
    .filter(([, place]) => Array.isArray(valueAt(place)) && valueAt(place).some(isNumber));
  return table(['Joint', ...places.map(([name]) => '#' + name)], series.joints.map((joint, i) => [strong(i + 1 + ' ' + joint.name), ...places.map(
      ([, place, style]) => style === 'percent' ? number(place + '/' + i, 'percent') : [number(place + '/' + i, 'milli'), '\u00a0m' + joint.unit])]), 'errors');
}

function torqueBars() {
  const place = '/torque/relative_error';
  const values = valueAt(place) || [];
  const largest = Math.max(1e-9, ...values.filter(isNumber));
  return values.length ? rowChart({name: 'verdict', joint: 0, title: 'Simulated torque, off the recorded one', width: 560, left: 110, right: 90, range: [0, largest],
    rows: series.joints.map((_, i) => ({label: shortJoint(i + 1), parts: [{from: 0, to: values[i] || 0, colour: 'extended'}], value: [drawnNumber(place + '/' + i), ' %']}))}) : null;
}

function simulatePage() {
  const run = result.torque || result.largest_deviation;
  const source = series.recordings[0].source;
  const replay = Boolean(result.torque);
  const off = result.largest_deviation || [];
  const farthest = off.some(isNumber) ? Math.max(...off.filter(isNumber)) : null;
  const worst = replay ? Math.max(...result.torque.relative_error.filter(isNumber)) : 0;
  return {
    title: result.robot, kind: 'Simulation', facts: [replay ? 'Replay of ' + fileName(source) : 'Under a controller along ' + fileName(source)],
    lead: result.complete === false ? 'The run stopped early.' : replay ? 'The simulated torques follow the recorded ones to ' + short(100 * worst, 2) + ' % on every joint.' :
        'The arm ran to the end' + (farthest === null ? '.' : ', at most ' + short(1e3 * farthest, 2) + ' m' + series.joints[off.indexOf(farthest)].unit + ' off its set points.'),
    state: result.complete === false ? 'bad' : 'good',
    good: [result.complete === false ? paragraph('warning', 'Incomplete: the run ' + result.stopped.why) : null, replay ? torqueBars() : null, run ? runTable() : null],
    next: replay ? [{why: 'If a joint is off, ask what the model lacks:', command: 'veridyn diagnose MODEL --train ' + source + ' --test OTHER.csv'}] :
                   [{why: 'Identify from what was recorded:', command: 'veridyn identify ' + fileOfRun(result.robot) + ' --train ' + (wordAfter('-o') || 'RECORDING.csv') + ' --test OTHER.csv'}],
    picture: armView(),
    sections: [section('over-time', 'Motion and torque over time', timeNote + (replay ? ' Torque: recorded minus simulated, both low-passed. Model alone: the torque that the model asks for at ' +
                       'the recorded motion, without simulation.' : ''), timePanel(givenPlots, null, 1))]
  };
}

function breakawayPage() {
  const unit = '\u00a0' + typeset(result.unit);
  const effort = (place) => [number(place, 'plain', fixed(3)), unit];
  const rows = result.ramps.map((ramp, k) => [number('/ramps/' + k + '/rest_from', 'plain', fixed(2)), ramp.direction > 0 ? 'forwards' : 'backwards',
                                              effort('/ramps/' + k + '/recorded/effort'), effort('/ramps/' + k + '/simulated/effort')]);
  const medians = ['forward', 'backward'].map((side) => [strong('median'), side + 's', effort('/' + side + '/recorded'), effort('/' + side + '/simulated')]);
  const sides = ['forward', 'backward'].filter((side) => isNumber(valueAt('/' + side + '/recorded')));
  const figures = [[1, 'Forwards'], [-1, 'Backwards']].map(([direction, name]) => {
    const ramps = series.ramps.filter((_, k) => result.ramps[k].direction === direction);
    const join = (which) => ramps.flatMap((r) => r[which].concat([[null, null]]));
    return ramps.length ? chart({name: 'ramps', joint: result.joint, title: name, x: {name: 'effort [' + result.unit + ']'}, y: {name: series.way_unit}, width: 480, height: 280, marks: [
      {kind: 'line', name: 'recorded', colour: 'measured', width: 3, points: join('recorded')}, {kind: 'line', name: 'simulated', colour: 'extended', points: join('simulated')}]}) : null;
  });
  return {
    title: result.robot, kind: 'Breakaway', facts: ['Breakaway of ' + result.coordinate + ' in ' + fileName(series.source)],
    lead: sides.length ? result.coordinate + ' begins to slide at ' + listed(sides.map((side) => short(valueAt('/' + side + '/recorded')) + ' ' + result.unit)) + '.' : 'No ramps were found.',
    good: sides.map((side) => paragraph('', 'It slides ' + side + 's at ', effort('/' + side + '/recorded'), ' in the recording, at ', effort('/' + side + '/simulated'), ' in the simulation (medians).')),
    next: [{why: 'Where the two differ, the model lacks friction that grows at rest; ask which:', command: 'veridyn diagnose MODEL --train ' + series.source + ' --test OTHER.csv'}],
    picture: figures.find(Boolean),
    sections: [section('ramps', 'Way over effort', 'Each line is one ramp, from its rest on until the joint began to slide: the way that it crept over the effort that pushed it.', figures.slice(1)),
      section('errors', 'Effort at which it slides', 'The joint slides when it is faster than the speed of the run\u2019s settings; the model starts each ramp at rest under the recorded effort and is pushed with the recorded one.',
              table(['#At rest from [s]', 'Direction', '#Recorded', '#Simulated'], medians.concat(rows), 'breakaway'))]
  };
}

pages.simulate = () => series.ramps ? breakawayPage() : simulatePage();

// ---- watch: while the arm runs the page follows it

const kReload = 2000;  // [ms]

pages.watch = () => {
  const seconds = (place) => number(place, 'plain', fixed(2));
  const alarms = result.sources.reduce((sum, source) => sum + source.alarms, 0);
  const watched = result.sources.reduce((sum, source) => sum + source.seconds - source.learned - source.blind, 0);
  const blind = result.sources.reduce((sum, source) => sum + source.blind, 0);
  const said = (event) => event.sentence.replace(/^[0-9.]+ s: /, '');  // the time has a column of its own
  const last = result.sources.flatMap((source) => source.events).filter((event) => ['named', 'refined', 'present', 'withdrawn'].includes(event.event)).pop();
  const named = last && last.event !== 'withdrawn' ? last : null;
  const events = result.sources.flatMap((source, s) => source.events.map((event, e) => {
    const place = '/sources/' + s + '/events/' + e;
    return [fileName(source.source), seconds(place + '/time'), seconds(place + '/since'), event.event, typeset(said(event))];
  }));
  if (result.running && location.protocol === 'http:') {
    new EventSource('/events').onmessage = () => fetch('/').then(() => location.reload(), () => 0);  // it may have ended
  } else if (result.running) {
    setTimeout(() => location.reload(), kReload);
  }
  return {
    title: result.robot, kind: 'Watch', facts: [result.running ? 'running; this page follows it' : 'ended'],
    lead: alarms === 0 && !named ? (blind > 0 ? 'Nothing changed in what could be watched.' : 'Nothing changed.') : alarms < 2 && named ? said(named)[0].toUpperCase() + said(named).slice(1) : countOf(alarms, 'change') + ' in ' + countOf(result.sources.length, 'source') + '.', state: alarms || named || blind > 0 ? 'bad' : 'good',
    good: [paragraph('', countOf(result.sources.length, 'source') + ' watched for ' + short(watched, 3) + ' s after ' +
                     short(result.sources.reduce((sum, s) => sum + s.learned, 0), 3) + ' s in which it learned today\u2019s friction and offsets' + (blind > 0 ? '; ' + short(blind, 3) + ' s could not be watched.' : '.')),
           events.length ? table(['Source', '#Said at [s]', '#Since [s]', 'State', 'What'], events, 'events') : null],
    next: alarms || named ? [{why: 'Ask what changed, with intervals:', command: 'veridyn diagnose MODEL --train RECORDING.csv --test OTHER.csv'}] : null,
    picture: armView(),
    sections: [section('over-time', 'Torque over time', 'Means of a tenth of a second, of the source that was watched last. What is known by then (today\u2019s friction and offsets, changes that were ' +
                       'named) is part of the model.', timePanel(givenPlots, null, 1))]
  };
};

// ---- kinematics

function conditionColour(condition) {
  const share = isNumber(condition) ? Math.max(0, Math.min(1, Math.log10(condition) / 2)) : 1;
  return mixed(colour('extended'), colour('model'), share);
}

function postureStage() {
  const arm = series.arms[0];
  const recording = series.recordings[0];
  const groups = groupBy(result.points, (p) => isNumber(p[3]) ? Math.min(8, Math.floor(4 * Math.log10(Math.max(1, p[3])))) : 8);
  const clouds = () => groups.map((g) => ({kind: 'points', points: g.map(({item}) => item), colour: conditionColour(g[0].item[3]), width: 3.5}));
  const at = (k) => armParts(arm, jointsAt(recording.q, k));
  return stage({
    title: 'The arm and its tip', time: recording.time, clock: recording.timed ? null : (t) => 'posture ' + (Math.round(t) + 1),
    keys: [key('well conditioned', 'extended'), key('close to a singularity', 'model')],
    points: result.points.concat([origin(arm.base)], samplesOf(arm, recording.q)),
    parts: (t) => clouds().concat(at(rowAt(recording.time, t)))
  });
}

pages.kinematics = () => {
  const finite = result.points.map((p) => p[3]).filter(isNumber).sort((a, b) => a - b);
  const decades = new Map();
  finite.forEach((c) => decades.set(Math.floor(4 * Math.log10(c)), (decades.get(Math.floor(4 * Math.log10(c))) || 0) + 1));
  return {
    title: result.robot, kind: 'Kinematics', facts: ['Frame ' + result.frame + ', ' + countOf(result.postures, 'posture') + ', ' + result.solver],
    lead: result.not_reached ? result.not_reached + ' of ' + result.postures + ' poses not reached.' :
        'Condition of the position Jacobian: ' + (finite.length ? short(finite[0]) + ' to ' + short(finite[finite.length - 1]) : 'singular throughout') + '.',
    state: result.not_reached ? 'bad' : 'good',
    good: finite.length > 1 ? chart({name: 'condition', joint: 0, title: 'How often each condition number occurs', x: {name: 'condition number, logarithm to base 10'}, y: {name: 'postures'}, width: 480, height: 220,
      marks: [{kind: 'bars', name: 'postures', colour: 'extended', points: [...decades].map(([d, n]) => [d / 4, (d + 1) / 4, n])}], note: 'Beyond 2, the tip can hardly move in one direction.'}) : null,
    next: [{why: 'A motion that stays clear of singular postures and tells the parameters apart:', command: 'veridyn excite ' + fileOfRun(result.robot) + ' -o MOTION.csv --report motion.html'}],
    picture: postureStage(), sections: []
  };
};

// ---- info

const kSweepSeconds = 3;

// One joint after the other through its range and back.
function sweep(arm) {
  const rows = 60;
  const time = [], columns = arm.middle.map(() => []);
  arm.middle.forEach((_, joint) => {
    for (let k = 0; k < rows; ++k) {
      time.push((joint + k / rows) * kSweepSeconds);
      const [low, high] = arm.range[joint];
      arm.middle.forEach((m, i) => columns[i].push(i === joint ? m + 0.5 * (high - low) * Math.sin(2 * Math.PI * k / rows) : m));
    }
  });
  return {time, columns};
}

function infoStage() {
  const arm = series.arms[0];
  const {time, columns} = sweep(arm);
  const look = {axes: true};
  return stage({
    title: 'The arm as the file has it', own: true, time, keys: [key('x', 'model'), key('y', 'forward'), key('z', 'extended')],
    points: time.filter((_, k) => k % 15 === 0).flatMap((t) => posesOf(arm, jointsAt(columns, rowAt(time, t))).poses.map(origin)),
    clock: (t) => series.joints[Math.min(arm.middle.length - 1, Math.floor(t / kSweepSeconds))].name,
    parts: (t) => armParts(arm, jointsAt(columns, rowAt(time, t)), null, look),
    controls: (draw) => {
      const axes = element('input', {type: 'checkbox', checked: ''});
      axes.addEventListener('change', () => {
        look.axes = axes.checked;
        draw();
      });
      return element('label', {class: 'small'}, axes, ' frames and their names');
    }
  });
}
