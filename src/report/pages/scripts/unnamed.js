// What every joint's held-out error is made of, and curves of findings without a name.

const kStates = {
  at_floor: 'at its floor',
  named: 'named',
  unnamed: 'depends on what has no name',
  cannot_tell: 'these recordings cannot tell'
};

function fillJointVerdicts() {
  if (!result.verdict || !result.verdict.length) return;
  byId('joint-verdicts')
      .append(table(
          [
            {name: 'Joint'}, {name: 'Held out, %', kind: 'number'}, {name: 'Floor, %', kind: 'number'},
            {name: 'With names', kind: 'number'}, {name: 'Without', kind: 'number'},
            {name: 'Left', kind: 'number'}, {name: 'Verdict'}
          ],
          result.verdict.map((v, k) => {
            const place = '/verdict/' + k + '/';
            const cell = (name) => number(place + name, 'share');
            return [
              shortJoint(v.joint), cell('held_out'), cell('floor'), cell('named'), cell('unnamed'),
              cell('left'), kStates[v.state] + (v.why ? ': ' + v.why : '')
            ];
          })));
}

// One line with its band for every value of the second signal.
function shapeCurve(finding) {
  if (!finding.curve || !finding.curve.length) return '';
  const width = 280, height = 130, edge = 8;
  const lines = new Map();
  for (const p of finding.curve) {
    const key = p.at.length > 1 ? p.at[1] : 0;
    if (!lines.has(key)) lines.set(key, []);
    lines.get(key).push(p);
  }
  const xs = finding.curve.map((p) => p.at[0]);
  const ys = finding.curve.flatMap((p) => p.band);
  const across = (x) => edge + (width - 2 * edge) * (x - Math.min(...xs)) / (Math.max(...xs) - Math.min(...xs) || 1);
  const up = (y) => height - edge - (height - 2 * edge) * (y - Math.min(...ys)) / (Math.max(...ys) - Math.min(...ys) || 1);
  const path = (points) => points.map(([x, y], k) => (k ? 'L' : 'M') + across(x).toFixed(1) + ' ' + up(y).toFixed(1)).join('');
  const marks = [];
  for (const points of lines.values()) {
    const there = points.map((p) => [p.at[0], p.band[1]]);
    const back = points.map((p) => [p.at[0], p.band[0]]).reverse();
    marks.push(drawing('path', {d: path([...there, ...back]) + 'Z', fill: 'currentColor', opacity: 0.12}));
    marks.push(drawing('path', {d: path(points.map((p) => [p.at[0], p.value])), fill: 'none', stroke: 'currentColor'}));
  }
  return element(
      'figure', {}, drawing('svg', {viewBox: '0 0 ' + width + ' ' + height, width, height, role: 'img'}, marks),
      element(
          'figcaption', {class: 'small'},
          finding.unit + ' over ' + finding.signals.map((s, k) => s + ' [' + finding.curve_units[k] + ']').join(', ') +
              ', from ' + Math.min(...xs).toPrecision(3) + ' to ' + Math.max(...xs).toPrecision(3) + '; band: 95 %'));
}
