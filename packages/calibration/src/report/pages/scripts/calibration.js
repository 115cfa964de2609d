// What calibrate found: numbers, axes and frames in space, and histograms of what is left over.

function spaceStage() {
  const {points, lines, frames} = series.space;
  const all = points.flatMap((p) => p.at).concat(lines.flatMap((l) => [l.from, l.to]), frames.map((f) => f.origin));
  if (!all.length) return null;
  const reach = boxOf(all).reach;
  const arm = (series.arms || [])[0];
  const recording = series.recordings[0];
  const moving = arm && recording && recording.q;
  const keys = [[points, 'measured points', 'quiet'], [lines, 'axes', 'model'], [frames, 'frames: x, the longest, y and z', 'extended']];
  return stage({
    title: 'In space', time: moving ? recording.time : [], points: all.concat(moving ? posesOf(arm, jointsAt(recording.q, 0)).poses.map(origin) : []), clock: (t) => 'pose ' + (Math.round(t) + 1),
    keys: keys.filter(([list]) => list.length).map(([, name, style]) => key(name, style)),
    parts: (t) => [
      ...points.map((p) => ({kind: 'points', points: p.at, colour: 'quiet', width: 3.5})), ...points.filter((p) => p.at.length).map((p) => ({kind: 'label', a: p.at[0], text: p.name})),
      ...lines.map((l) => ({kind: 'line', points: [l.from, l.to], colour: 'model', width: 3})), ...lines.map((l) => ({kind: 'label', a: l.to, text: l.name})),
      ...frames.flatMap((f) => f.axes.map((axis, c) => ({kind: 'line', points: [f.origin, plus(f.origin, axis, reach * [0.3, 0.22, 0.15][c])], colour: 'extended', width: 3}))),
      ...frames.map((f) => ({kind: 'label', a: f.origin, text: f.name})), ...(moving ? armParts(arm, jointsAt(recording.q, rowAt(recording.time, t))) : [])]
  });
}

const millimetres = (place) => number(place, 'milli', fixed(3));
const plainly = (place) => number(place, 'plain', fixed(4));
const three = (place, write) => [0, 1, 2].flatMap((c) => [c ? ', ' : '', write(place + '/' + c)]);
const ends = (place, write) => [write(place + '/0'), ' to ', write(place + '/1')];

const calibrationTables = {
  axis: () => [
    table(['Between', '#Direction', '#\u00b1 deg', '#Point [mm]', '#\u00b1 mm'], result.axes.map((axis, k) => {
      const place = '/axes/' + k;
      return [axis.between.join(', '), three(place + '/direction', plainly), plainly(place + '/interval_deg'), three(place + '/point', millimetres), millimetres(place + '/interval_m')];
    }), 'base'),
    result.links.length ? [heading('Links between successive axes'), table(['Axes', '#Distance [mm]', '#95 %', '#Plane-parallel [mm]', '#Twist [deg]'], result.links.map((link, k) => {
      const place = '/links/' + k;
      return [link.axes.map((a) => a + 1).join(', ') + ' on ' + link.body, millimetres(place + '/distance'), ends(place + '/interval', millimetres), millimetres(place + '/plane_parallel_distance'),
              plainly(place + '/twist_deg')];
    }), 'base')] : null],
  rcm: () => table(['[mm]', '#x', '#y', '#z', '#\u00b1 95 %'], [['rcm', 'Centre, cameras'], ['tip', 'Centre, body'], ['rms', 'RMS over frames']].map(
      ([key, name]) => [name, ...[0, 1, 2].map((c) => millimetres('/' + key + '/' + c)), three('/' + key + '_interval', millimetres)]), 'base'),
  links: () => table(['Constant', '#File', '#Found', '#95 %', 'Unit'], result.constants.map((c, k) => {
    const place = '/constants/' + k;
    const name = c.name + (c.frame ? ' of ' + c.frame : '');
    return [c.changed ? strong(name) : name, number(place + '/file', 'plain'), number(place + '/found', 'plain'), c.identifiable || c.changed ? ends(place + '/interval', plainly) : words(c.why), c.unit];
  }), 'constants'),
  handeye: () => table(['Pose', '#Translation [mm]', '#\u00b1 mm', '#Quaternion w, x, y, z', '#\u00b1 deg'], ['transform', 'tool', 'target'].filter((pose) => result[pose]).map((pose) => {
    const place = '/' + pose;
    return [words(pose), three(place + '/translation', millimetres), millimetres(place + '/interval_m'), numbers(place + '/quaternion', 'plain', fixed(4)), plainly(place + '/interval_deg')];
  }), 'base')
};

const calibrationNext = {
  axis: () => 'Write distances and twists into the robot file, then check the poses: veridyn calibrate links.',
  rcm: () => 'Use the centre as the origin of the arm\u2019s base.',
  links: () => result.model ? {why: 'Identify with the calibrated robot:', command: 'veridyn identify ' + result.model + ' --train RECORDING.csv --test OTHER.csv'} :
                              {why: 'Write the robot with these constants:', command: (series.command || '') + ' --robot-out CALIBRATED.yaml'},
  handeye: () => 'Use the pose where both systems meet; take the pairs again when a camera was moved.'
};

pages.calibrate = () => ({
  title: series.title, kind: 'Calibration', facts: [series.facts], lead: typeset(series.verdict), state: result.status === 'done' ? 'good' : 'bad',
  good: [result.comparison ? paragraph('', typeset(result.comparison)) : null, result.reason ? paragraph('warning', typeset(result.reason)) : null, calibrationTables[result.part]()],
  next: calibrationNext[result.part](), picture: spaceStage(),
  sections: [section('left-over', 'Left over', 'How often an error of each size is left between the model and what was measured, outliers left out. Intervals above hold in 95 of 100 cases; frames whose ' +
      'errors are alike count as one.', element('div', {class: 'charts'}, series.histograms.map((h) => {
    const step = (h.high - h.low) / h.counts.length;
    return chart({name: 'histogram', joint: 0, title: h.name, x: {name: h.unit, range: [h.low, h.high]}, y: {name: 'count'}, width: 400, height: 210,
                  marks: [{kind: 'bars', name: 'errors', colour: 'extended', points: h.counts.map((n, k) => [h.low + k * step, h.low + (k + 1) * step, n])}]});
  })))]
});
