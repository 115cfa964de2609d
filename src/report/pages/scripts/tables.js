// Pages that are mostly tables: info, check, payload, compare, fleet, friction.

// ---- info

pages.info = () => {
  const axes = (form) => Object.entries(form).map(([name, share]) => (share === 1 ? '' : short(share) + ' ') + name).join(' + ');
  const bound = (place) => isNumber(valueAt(place)) ? number(place, 'plain') : 'open';
  const friction = !result.effects.some((e) => /friction|viscous/.test(e.effect));
  return {
    title: result.robot, kind: 'Robot', facts: [result.source || ''],
    lead: countOf(result.coordinates.length, 'coordinate') + ', ' + countOf(result.frames.filter((f) => f.body).length, 'body', 'bodies') + ', ' + countOf(result.effects.length, 'effect') + '; torques tell ' +
        countOf(result.base_parameters.length, 'combination') + ' of ' + result.standard_parameters.length + ' parameters.',
    good: [friction ? paragraph('warning', 'The file has no friction, and every real joint has (identify --friction plain).') : null,
      ...(result.impossible || []).map((fault) => paragraph('warning', 'No arm has this: ' + typeset(fault) + '.')),
      paragraph('', 'Gravity ', numbers('/gravity', 'plain'), ' m/s\u00b2. The three lines of a frame are its x, y and z axes; the slider moves one joint after the other through its range.'),
      table(['Joint', '#From', '#To', '#Speed', '#Effort', 'Unit'], result.coordinates.map((c, k) => [
        strong(k + 1 + ' ' + c.name), bound('/coordinates/' + k + '/position/0'), bound('/coordinates/' + k + '/position/1'), bound('/coordinates/' + k + '/velocity'), bound('/coordinates/' + k + '/effort'),
        c.unit + ', ' + c.effort_unit]), 'coordinates')],
    next: [{why: 'A motion that tells its parameters apart:', command: 'veridyn excite ' + fileOfRun(result.robot) + ' -o MOTION.csv --report motion.html'}],
    picture: infoStage(),
    sections: [
      section('frames', 'Frames', null, table(['Frame', 'Parent', 'Joint', 'Variable', 'Body'], result.frames.map((f) => [strong(f.name), f.parent, f.type, axes(f.variable), f.body ? 'yes' : '']), 'frames')),
      section('effects', 'Effects', null, result.effects.length ? table(['Effect', 'Acts on', 'Values'], result.effects.map((e) => [
        strong(words(e.effect)), e.frame ? 'frame ' + e.frame : axes(e.axis), Object.entries(e.values || {}).map(([name, v]) => words(name) + ' ' + short(v, 4)).join(', ')]), 'effects') : null),
      section('parameters', 'What torques can tell', 'Base parameters, and their values where the file has them.', table(['Base parameter', '#Value', 'Unit'], result.base_parameters.map((b, k) => [
        element('span', {class: 'expression'}, b.expression), number('/base_parameters/' + k + '/value', 'plain'), typeset(b.unit)]), 'base'),
        folded('Identifiable alone: ' + result.identifiable_alone.length, paragraph('small', result.identifiable_alone.join(', '))),
        folded('In combination only: ' + result.identifiable_in_combination.length, paragraph('small', result.identifiable_in_combination.join(', '))),
        folded('Not at all: ' + result.unidentifiable.length, paragraph('small', result.unidentifiable.join(', '))))]
  };
};

// ---- check

const kSeverity = {fault: 'bad', warning: 'fair', info: 'good', none: 'good', ok: 'good'};

pages.check = () => {
  const faults = result.data_quality.filter((f) => f.severity === 'fault').length;
  const warnings = result.data_quality.filter((f) => f.severity === 'warning').length;
  const shares = result.recordings.flatMap((r) => r.findings.filter((f) => isNumber(f.share) && f.share > 0).map((f) => ({r, f}))).slice(0, 16);
  return {
    title: result.recordings.length === 1 ? fileName(result.recordings[0].file) : countOf(result.recordings.length, 'recording'), kind: 'Recordings',
    facts: [[...new Set(result.recordings.map((r) => r.format))].join(', ')],
    lead: faults ? countOf(faults, 'fault') + (warnings ? ' and ' + countOf(warnings, 'warning') : '') + '.' : warnings ? countOf(warnings, 'warning') + ', no fault.' : 'Nothing is wrong with the data.',
    state: faults ? 'bad' : 'good',
    good: [
      shares.length ? rowChart({name: 'verdict', joint: 0, title: 'Share of the rows that each finding touches', width: 560, left: 230, right: 70, range: [0, 1], marks: [0, 0.5, 1].map((at) => ({at, text: 100 * at + ' %'})),
        rows: shares.map(({r, f}) => ({label: (words(f.finding) + (f.joint ? ', ' + f.joint : '') + (result.recordings.length > 1 ? ', ' + fileName(r.file) : '')).slice(0, 38), title: f.sentence,
                                       parts: [{from: 0, to: f.share, colour: kSeverity[f.severity] || 'fair'}], value: short(100 * f.share, 2) + ' %'}))}) : null,
      table(['Recording', '#Rows', '#Seconds', '#Rate [Hz]', '#Repeats'], result.recordings.map((r, k) => {
        const place = '/recordings/' + k;
        return [strong(fileName(r.file)), number(place + '/rows', 'whole'), number(place + '/duration', 'plain'), number(place + '/rate', 'plain'), number(place + '/repeats', 'whole')];
      }), 'recordings')],
    next: [{why: faults ? 'Mend the faults first; what can be mended by options is in docs/recordings.md.' : 'Identify from them:', command: faults ? undefined :
        'veridyn identify ROBOT --train ' + result.recordings[0].file + ' --test ' + ((result.recordings[1] || {}).file || 'OTHER.csv') + ' --report model.html'}],
    sections: [section('findings', 'What was seen', null, result.data_quality.length ? table(['Recording', 'Weight', 'Finding'], result.data_quality.map((f) => [
      fileName(f.file), element('span', {class: f.severity === 'fault' ? 'warning' : ''}, f.severity), typeset(f.sentence)]), 'quality') : paragraph('', 'Nothing to remark.'))]
  };
};

// ---- payload

pages.payload = () => {
  const link = result.links[0];
  const entry = (k, part, name) => sizeWithInterval('/links/' + k + '/' + part + (name ? '/' + name : ''));
  const change = (result.relative_error.before || []).map((_, i) => i);
  const largest = Math.max(1e-9, ...['before', 'after'].flatMap((w) => result.relative_error[w]).filter(isNumber));
  return {
    title: result.robot, kind: 'Payload', facts: [countOf(result.links.length, 'link') + ' asked'],
    lead: result.verdict === 'payload' && link ? 'A load on ' + link.frame + ' explains ' + short(100 * link.explained, 2) + ' % of what the model left.' : 'No load is there beyond chance.', state: 'good',
    good: [link ? paragraph('', 'Mass ', entry(0, 'mass'), '.') : null, result.reason ? paragraph('', typeset(result.reason)) : null,
      change.length ? rowChart({name: 'verdict', joint: 0, title: 'Error before, and with the load', width: 560, left: 110, right: 150, range: [0, largest], keys: [key('before', 'model'), key('with the load', 'extended')],
        rows: change.map((i) => ({label: 'Joint ' + (i + 1), parts: [{from: 0, to: result.relative_error.before[i] || 0, colour: 'model', thin: true}, {from: 0, to: result.relative_error.after[i] || 0, colour: 'extended'}],
                                  value: [drawnNumber('/relative_error/before/' + i), ' \u2192 ', drawnNumber('/relative_error/after/' + i), ' %']}))}) : null],
    next: ['Add the load to the model as a body with these values, or tell the controller: control compensates what the model has.'], picture: armView(),
    sections: [section('links', 'By link', 'With 95 % intervals; the first is the most likely, and of those that explain as much the one nearest to the load.', table(['Link', '#Mass', '#Centre x', '#Centre y', '#Centre z', '#Explains'], result.links.map((l, k) => [
      strong(l.frame), entry(k, 'mass'), entry(k, 'com', 'x'), entry(k, 'com', 'y'), entry(k, 'com', 'z'), [number('/links/' + k + '/explained', 'share'), '\u00a0%']]), 'links'))]
  };
};

// ---- compare

pages.compare = () => {
  const all = ['joints', 'parameters'].flatMap((list) => result[list].map((d, k) => ({...d, place: '/' + list + '/' + k})));
  const found = all.filter((d) => d.significant);
  const shown = (found.length ? found : all).slice().sort((a, b) => Math.abs(b.t || 0) - Math.abs(a.t || 0)).slice(0, 14);
  const reach = Math.max(3, ...shown.map((d) => Math.abs(d.t || 0))) * 1.05;
  const what = (d) => d.effect ? words(d.effect) + ' of ' + d.coordinate : d.name || words(d.quantity) + (d.coordinate ? ' of ' + d.coordinate : '');
  const row = (d) => [element('span', {title: d.sentence}, d.significant ? strong(what(d)) : what(d)), number(d.place + '/before', 'plain'), number(d.place + '/after', 'plain'),
    [number(d.place + '/ci95/0', 'plain'), ' to ', number(d.place + '/ci95/1', 'plain')], number(d.place + '/p_corrected', 'chance'), typeset(d.unit)];
  const columns = ['What', '#Before', '#After', '#Difference, 95 %', '#p, corrected', 'Unit'];
  return {
    title: result.robot, kind: 'Comparison', facts: [result.before.robot + ' (' + listed(result.before.recordings) + ') and ' + result.after.robot + ' (' + listed(result.after.recordings) + ')'],
    lead: result.verdict === 'same' ? 'Nothing differs beyond chance.' : result.verdict === 'differ' ? countOf(found.length, 'difference') + ' beyond chance.' : 'The files do not tell: they lack statistics.',
    state: result.verdict === 'same' ? 'good' : 'bad',
    good: [found.length ? element('ol', {}, found.slice(0, 5).map((d) => element('li', {}, typeset(d.sentence)))) : null, ...[result.before.note, result.after.note].filter(Boolean).map((n) => paragraph('small', typeset(n)))],
    next: result.verdict === 'differ' ? [{why: 'Ask the recordings themselves what changed:', command: 'veridyn diagnose BEFORE.yaml --train NEW.csv --test OTHER.csv --report changed.html'}] : null,
    picture: shown.length ? rowChart({name: 'differences', joint: 0, title: 'Difference in standard deviations of itself', width: 520, left: 210, right: 60, range: [-reach, reach],
      marks: [{at: 0, text: '0', kind: 'zero'}, {at: -reach, text: short(-reach, 2)}, {at: reach, text: short(reach, 2)}],
      rows: shown.map((d) => ({label: what(d).slice(0, 34), title: d.sentence, dots: [{at: d.t || 0, colour: d.significant ? 'bad' : 'good'}], parts: [{from: (d.t || 0) - 2, to: (d.t || 0) + 2, colour: 'quiet', thin: true}],
                               value: short(d.t, 2)}))}) : null,
    sections: [
      section('joints', 'By joint', null, result.joints.length ? table(columns, all.filter((d) => d.place.startsWith('/joints')).map(row), 'joints') : null),
      section('torque', 'Torque of the difference', 'What the difference comes to in torque over the motion.', (result.torque || []).length ? table(['Joint', '#Before', '#After', '#Difference', '#By chance', 'Unit'],
        result.torque.map((t, k) => [strong(t.joint + ' ' + t.coordinate), ...['before', 'after', 'difference', 'by_chance'].map((n) => number('/torque/' + k + '/' + n, 'plain')), typeset(t.unit)]), 'torque') : null),
      section('parameters', 'Base parameters', null, table(columns, all.filter((d) => d.place.startsWith('/parameters')).map(row), 'base')),
      section('structure', 'Not built alike', null, result.structure.length ? element('ul', {}, result.structure.map((s) => element('li', {}, typeset(s.sentence)))) : null)]
  };
};

// ---- fleet

pages.fleet = () => {
  const errors = result.members.map((m) => Math.max(...(m.relative_error || []).filter(isNumber)));
  const odd = new Set(result.outliers.map((o) => o.arm).concat(result.other_bodies.map((o) => o.arm)));
  return {
    title: result.robot, kind: 'Fleet', facts: [countOf(result.arms, 'arm') + ', ', number('/rows', 'whole'), ' rows'],
    lead: odd.size ? listed([...odd]) + (odd.size === 1 ? ' stands' : ' stand') + ' out.' : 'No arm stands out.', state: odd.size ? 'bad' : 'good',
    good: [result.reason ? paragraph('warning', typeset(result.reason)) : null, element('ul', {}, result.outliers.slice(0, 6).map((o) => element('li', {}, o.arm + ': ' + words(o.what) + (o.joint ? ', joint ' + o.joint : '') +
        ' is ' + short(o.value) + ', the fleet\u2019s median ' + short(o.median) + ' (' + short(o.deviations, 2) + ' deviations).')))],
    next: odd.size ? [{why: 'Diagnose the arm that stands out against the fleet\u2019s model:', command: 'veridyn diagnose FLEET.yaml --train ARM.csv --test OTHER.csv'}] : null,
    picture: rowChart({name: 'members', joint: 0, title: 'Largest error of each arm under the fleet\u2019s bodies', width: 520, left: 140, right: 80, range: [0, Math.max(1e-9, ...errors.filter(isNumber))],
      rows: result.members.map((m, k) => ({label: m.arm.slice(0, 20), parts: isNumber(errors[k]) ? [{from: 0, to: errors[k], colour: odd.has(m.arm) ? 'bad' : 'good'}] : [], value: short(100 * errors[k], 3) + ' %'}))}),
    sections: [
      section('spreads', 'What each arm has for itself', 'Median over the fleet and robust spread.', table(['Parameter', '#Median', '#Spread', 'Unit'], result.spreads.map((s, k) => [
        s.name, number('/spreads/' + k + '/median', 'plain'), number('/spreads/' + k + '/spread', 'plain'), typeset(s.unit)]), 'spreads')),
      section('members', 'Arms', 'Error of each joint under the fleet\u2019s bodies.', table(['Arm', '#Rows', '#Error per joint [%]'], result.members.map((m, k) => [
        strong(m.arm), number('/members/' + k + '/rows', 'whole'), numbers('/members/' + k + '/relative_error', 'percent')]), 'members')),
      section('parameters', 'Base parameters of the fleet', null, baseTable(result.base_parameters, '/base_parameters'), grid(parameterDots(result.base_parameters)))]
  };
};

// ---- friction: curves that a command has already made, {joint, curve: {velocity, torque, interval}, verdicts}

pages.friction = () => {
  const joints = result.joints || [];
  const curves = joints.map((j, k) => ({joint: j.joint || k + 1, speeds: j.speeds || [], breakaways: j.breakaways || [], ...(j.curve || {})})).filter((c) => Array.isArray(c.velocity) && c.velocity.length);
  const figure = (c, size) => chart({
    name: 'friction', joint: c.joint, title: jointName(c.joint), x: {name: 'velocity'}, y: {name: (series.joints[c.joint - 1] || {}).torque_unit || 'torque'}, ...size, marks: [
      {kind: 'band', name: '95 %', colour: 'extended', points: (c.interval || []).map((band, k) => Array.isArray(band) ? [c.velocity[k], band[0], band[1]] : [c.velocity[k], c.torque[k] - band, c.torque[k] + band])},
      {kind: 'line', name: 'friction', colour: 'extended', width: 2.2, points: c.velocity.map((v, k) => [v, c.torque[k]])},
      {kind: 'dots', name: 'constant speeds', colour: 'measured', width: 6, opacity: 0.9, points: c.speeds.map((s) => [s.velocity, s.torque])},
      {kind: 'dots', name: 'breakaways', colour: 'bad', width: 5, points: c.breakaways.map((b) => [0, b.torque])}]});
  // Kinds of friction beyond viscous and Coulomb, by the state of their verdict.
  const kinds = (joint, ...states) => (joint.verdicts || []).filter((v) => states.includes(v.state));
  const list = (found) => found.map((v) => words(v.effect)).join(', ');
  const more = joints.filter((j) => kinds(j, 'confirmed').length);
  const open = joints.filter((j) => kinds(j, 'cannot_tell', 'not_confirmed').length);
  const lead = more.length ? 'More than viscous and Coulomb friction on ' + more.map((j) => jointName(j.joint)).join(', ') + '.'
    : joints.length ? 'Viscous and Coulomb friction describe ' + (open.length ? 'what these recordings can tell.' : 'every joint that moves.') : 'No joint moves.';
  const summary = (j) => [strong(jointName(j.joint)), ': ', list(kinds(j, 'confirmed')) || 'viscous and Coulomb friction',
    kinds(j, 'not_confirmed').length ? '; found, not confirmed: ' + list(kinds(j, 'not_confirmed')) : '',
    kinds(j, 'cannot_tell').length ? '; cannot be told: ' + list(kinds(j, 'cannot_tell')) : ''];
  const tested = joints.flatMap((j, at) => (j.verdicts || []).map((v, k) => [strong(jointName(j.joint)), words(v.effect), words(v.state),
    v.p_value === null ? '' : number('/joints/' + at + '/verdicts/' + k + '/p_value', 'chance'), typeset(v.sentence.slice(v.sentence.indexOf(': ') + 2))]));
  return {
    title: result.robot || 'Friction', kind: 'Friction', facts: [countOf(curves.length, 'joint')], lead,
    good: element('ul', {}, joints.map((j) => element('li', {}, summary(j)))),
    next: [{why: 'Identify the whole arm with these causes:', command: 'veridyn diagnose ' + (result.robot || 'ROBOT') + ' --train RECORDING.csv --test OTHER.csv'}],
    picture: curves.length ? figure(curves[0], {width: 520, height: 300}) : null,
    sections: [section('curves', 'All joints', null, grid(curves.slice(1).map((c) => figure(c, {width: 420, height: 240})))),
      section('kinds', 'Kinds of friction that were tested', 'Beside viscous and Coulomb friction, on held-out parts of the recordings.', table(['Joint', 'Kind', 'Verdict', '#p', 'Why'], tested, 'kinds'))]
  };
};
