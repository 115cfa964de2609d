// What arms did that held one object: in space, in words, tables and plots; or the map of a sweep.

function newtons(pointer) {
  return number(pointer, 'plain', fixed(3));
}

function askedRows() {
  return result.phases.flatMap((phase, k) => ['force_error', 'steady_error'].filter((what) => isNumber(phase[what].asked)).map((what) => {
    const place = '/phases/' + k + '/' + what;
    const met = phase[what].reached <= phase[what].asked;
    return {met, cells: [phase.phase, what === 'force_error' ? 'force error at any time' : 'force error at rest', newtons(place + '/reached'), newtons(place + '/asked'),
                         element('span', {class: met ? '' : 'warning'}, met ? 'met' : 'not met')]};
  }));
}

// Arms, members between their tips, bodies, and an arrow for the force of each member.
function scenarioStage() {
  const recording = series.recordings[0];
  if (!recording || !recording.time.length || !(series.arms || []).some((a) => a.frames.length)) return null;
  const offset = [];
  series.arms.reduce((sum, arm, k) => (offset[k] = sum) + arm.middle.length, 0);
  const q = (k, row) => jointsAt(recording.q.slice(offset[k], offset[k] + series.arms[k].middle.length), row);
  const tip = (k, row) => recording.tips[k].map((c) => c[row]);
  const largest = Math.max(1e-9, ...recording.members.flatMap((m) => m.force.filter(isNumber).map(Math.abs)));
  const spread = series.arms.flatMap((arm, k) => [origin(arm.base)].concat([0, recording.time.length - 1].flatMap((row) => posesOf(arm, q(k, row)).poses.map(origin))));
  const reach = boxOf(spread).reach;
  return stage({
    title: countOf(series.arms.length, 'arm') + ' and what they hold', time: recording.time, points: spread,
    keys: [key('object', 'measured'), ...(recording.members.length ? [key('force of a member on its arm, longest ' + short(largest) + ' N', 'model')] : [])],
    parts(t) {
      const row = rowAt(recording.time, t);
      const out = series.arms.flatMap((arm, k) => armParts(arm, q(k, row), null, {colour: k % 2 ? 'link-b' : 'link'}));
      for (const m of recording.members) {
        const force = m.force[row] || 0;
        const a = tip(m.from, row);
        if (m.to >= 0) {
          const b = tip(m.to, row);
          const way = minus(b, a);
          const unit = way.map((v) => v / Math.max(1e-9, lengthOf(way)));
          out.push({kind: 'capsule', a, b, r: 0.009 * reach, colour: 'measured'});
          const long = 0.3 * reach * force / largest;
          if (Math.abs(long) > 0.01 * reach) out.push({kind: 'arrow', a, b: plus(a, unit, long), colour: 'model'}, {kind: 'arrow', a: b, b: plus(b, unit, -long), colour: 'model'});
        } else {
          out.push({kind: 'arrow', a: plus(a, m.normal, -0.3 * reach * Math.abs(force) / largest), b: a, colour: 'model'});
        }
      }
      for (const body of recording.bodies) {
        const at = body.at.map((c) => c[row]);
        out.push({kind: 'capsule', a: at, b: plus(at, [0, 0, 1], 1e-6), r: 0.05 * reach, colour: 'measured'});
        for (const k of body.arms) out.push({kind: 'capsule', a: at, b: tip(k, row), r: 0.008 * reach, colour: 'measured'});
      }
      return out;
    }
  });
}

function cooperationPlots() {
  const place = element('div', {id: 'time-plots'});
  let box;
  redraws.push(() => {
    clearTimePlots();
    place.replaceChildren();
    series.recordings[0].plots.forEach((one, k) => {
      // A plot without a title stands beneath the one before and has its time axis.
      if (one.title) {
        box = element('div', {class: 'joint'}, heading(one.title), paragraph('keys', one.curves.map((c) => key(c.name, kCurve[c.style][0]))));
        place.append(box);
      }
      timePlot(box, {...one, title: one.title || 'Off what was wanted', joint: k + 1, recording: series.recordings[0]});
    });
    showMoment(moment);
  });
  return place;
}

function forceBars(asked) {
  const figures = result.phases.map((phase, k) => ({label: phase.phase, place: '/phases/' + k + '/force_error', asked: phase.force_error.asked, reached: phase.force_error.reached}))
                      .filter((f) => isNumber(f.reached));
  const largest = Math.max(1e-9, ...figures.flatMap((f) => [f.reached, f.asked]).filter(isNumber)) * 1.05;
  return figures.length ? rowChart({name: 'verdict', joint: 0, title: 'Largest force error of each phase; the line is what was asked', width: 560, left: 150, right: 80, range: [0, largest],
    rows: figures.map((f) => ({label: f.label.slice(0, 22), title: f.label, value: [drawnForce(f.place + '/reached'), ' N'],
      parts: [{from: 0, to: f.reached, colour: !isNumber(f.asked) ? 'extended' : f.reached <= f.asked ? 'good' : 'bad'}],
      dots: isNumber(f.asked) ? [{at: f.asked, colour: 'text', tick: true}] : []}))}) : null;
}

function drawnForce(pointer) {
  return drawing('tspan', {class: 'n', 'data-from': pointer, 'data-scale': 1}, isNumber(valueAt(pointer)) ? fixed(3)(valueAt(pointer)) : '\u2013');
}

function cooperationRun() {
  const asked = askedRows();
  const missed = asked.filter((row) => !row.met).length;
  const held = result.status !== 'done';
  const phaseRows = result.phases.flatMap((phase, k) => phase.members.map((member, m) => {
    const place = '/phases/' + k + '/members/' + m + '/';
    return [phase.phase, member.member, ...['wanted_force', 'largest_error', 'steady_error', 'mean_error', 'overshoot', 'oscillation'].map((what) => newtons(place + what)),
            number(place + 'generated_energy', 'milli')];
  }));
  return {
    lead: !asked.length ? (held ? 'The run ended early.' : 'The run went to its end; no bounds were asked for.') : missed ? missed + ' of ' + asked.length + ' bounds not met.' : 'All ' + asked.length + ' bounds met.',
    state: missed || held ? 'bad' : 'good',
    good: [
      held ? paragraph('warning', (isNumber(result.held_at) ? 'At ' + result.held_at.toFixed(3) + ' s the controller ' : 'The run stopped: it ') + result.reason + '.') : null,
      forceBars(asked), asked.length ? table(['Phase', 'Figure', '#Reached [N]', '#Asked [N]', ''], asked.map((row) => row.cells), 'asked') : null,
      paragraph('small', 'Largest force at any time: ', newtons('/largest_force'), ' N.')],
    next: [{why: 'How much delay, stiffness and gain this leaves room for:', command: 'veridyn stability ' + fileOfRun('SCENARIO.yaml') + ' --report stability.html'}],
    picture: scenarioStage(),
    sections: [
      section('over-time', 'Over time', 'Drag across a plot to zoom, all follow; a double click shows all again. Forces are positive where a member pulls.', series.recordings.length ? cooperationPlots() : null),
      section('phases', 'Phases', 'True force against the force wanted [N]: its largest error in the phase, the largest and the mean in the last fifth, what it went beyond a new set ' +
                  'point, and its swing from least to largest in the last fifth. Energy made: the most that the arms gave to the object about its point of rest after the phase\u2019s ' +
                  'commands had ended.',
              table(['Phase', 'Member', '#Wanted', '#Largest', '#At rest', '#Mean', '#Overshoot', '#Swing', '#Made [mJ]'], phaseRows, 'phases'))]
  };
}

// A map for every rate of the loops: stiffness down, delay across.
function cooperationSweep() {
  const stable = result.points.filter((p) => p.stable).length;
  const maps = result.rate.map((rate, r) => {
    const rows = result.stiffness.map((stiffness, s) => [
      String(stiffness), ...result.delay.map((_, d) => {
        const k = s + result.stiffness.length * (d + result.delay.length * r);
        const point = result.points[k];
        return element('span', {class: point.stable ? 'stable' : 'unstable', title: point.ended}, point.stable ? newtons('/points/' + k + '/force_error') : '\u00d7');
      }),
      number('/stable_region/' + (s + r * result.stiffness.length) + '/delay_up_to', 'milli')]);
    return [heading('Loops at ' + rate + ' Hz'), table(['Stiffness [N/m]', ...result.delay.map((d) => '#' + short(1e3 * d) + ' ms'), '#Stable up to [ms]'], rows, 'sweep')];
  });
  return {
    lead: stable + ' of ' + result.points.length + ' points are stable.', state: stable === result.points.length ? 'good' : 'bad',
    good: [paragraph('', 'Where a point is stable, the arms made at most ', number('/generated_energy_where_stable', 'milli'), ' mJ at the object.')], next: null,
    sections: [section('phases', 'Stable region', 'Largest force error [N] in the phases that ask for a bound, by the stiffness of the object and the delay of the force sensor. A cross: ' +
        'not stable, more than ' + result.stable_error + ' N of error or swing at rest, or ended by a bound.', maps)]
  };
}

pages.cooperate = () => ({
  title: result.scenario, kind: 'Cooperation', facts: [(result.source ? result.source + '; ' : '') + 'simulated by ' + result.engine],
  ...(result.points ? cooperationSweep() : cooperationRun())
});
