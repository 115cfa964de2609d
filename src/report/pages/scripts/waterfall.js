// What each finding gains: per joint a staircase from the model as it stands to the extended model.

const kRow = 24;
const kBars = {
  left: 158,
  right: 312
};
const kChart = 360;          // width in units of the drawing, about pixels
const kVisibleStep = 0.005;  // of the joint's error as it stands

function shortened(text, length) {
  return text.length > length ? text.slice(0, length - 1) + '\u2026' : text;
}

// Rows of one joint: {label, from, to} with the places of the numbers in the result.
function waterfallRows(joint) {
  const i = joint - 1;
  const start = '/baseline/test/relative_error/' + i;
  const end = '/extended/test/relative_error/' + i;
  const steps = result.findings.map((finding, k) => {
    const gain = '/findings/' + k + '/gain/test_relative_error/';
    return {
      label: finding.rank + ' ' + words(finding.effect),
      from: gain + 'before/' + i,
      to: gain + 'after/' + i,
      kind: 'step'
    };
  });
  if (steps.length) {
    steps.unshift({label: 'fitted for the search', from: start, to: steps[0].from, kind: 'refit'});
    steps.push({
      label: 'fitted with conditions',
      from: steps[steps.length - 1].to,
      to: end,
      kind: 'refit'
    });
  }
  const isVisible = (row) =>
      Math.abs(valueAt(row.to) - valueAt(row.from)) > kVisibleStep * valueAt(start);
  const rows = [{label: 'as it stands', to: start, kind: 'model'}].concat(steps.filter(isVisible));
  rows.push({label: 'extended', to: end, kind: 'extended'});
  rows.push({label: 'noise floor', to: '/noise_floor/relative_error/' + i, kind: 'floor'});
  return rows.filter((row) => isNumber(valueAt(row.to)));
}

function waterfallText(x, y, className, children) {
  return drawing('text', {x: x, y: y, class: className}, children);
}

// The same marks as number() makes, inside a drawing.
function drawnNumber(pointer) {
  return drawing(
      'tspan', {class: 'n', 'data-from': pointer, 'data-scale': 100},
      styles.percent.write(100 * valueAt(pointer)));
}

function waterfallRow(row, at, x) {
  const y = at * kRow;
  const to = x(valueAt(row.to));
  const from = row.from ? x(valueAt(row.from)) : kBars.left;
  const left = Math.min(from, to);
  const kind = row.kind !== 'step' ? row.kind : to <= from ? 'gain' : 'loss';
  return drawing(
      'g', {}, waterfallText(0, y + 16, 'label', [shortened(row.label, 26)]),
      drawing('title', {}, row.label), drawing('rect', {
        x: left,
        y: y + 5,
        width: Math.max(1.5, Math.abs(to - from)),
        height: kRow - 10,
        class: kind
      }),
      waterfallText(kChart, y + 16, 'value', [drawnNumber(row.to)]));
}

function waterfall(joint) {
  const rows = waterfallRows(joint);
  const values = rows.flatMap((row) => [row.from, row.to]).filter(Boolean).map(valueAt);
  const largest = Math.max(1e-12, ...values);
  const x = (v) => kBars.left + (kBars.right - kBars.left) * v / largest;
  const floor = valueAt('/noise_floor/relative_error/' + (joint - 1));
  const height = rows.length * kRow + 2;
  const lines = isNumber(floor) ?
      drawing('line', {x1: x(floor), x2: x(floor), y1: 0, y2: height, class: 'floor-line'}) :
      null;
  const chart = drawing(
      'svg', {
        viewBox: '0 0 ' + kChart + ' ' + height,
        role: 'img',
        class: 'waterfall',
        'aria-label':
            jointName(joint) + ': held-out error from the model as it stands to the extended model'
      },
      lines, rows.map((row, k) => waterfallRow(row, k, x)));
  return element(
      'figure', {
        class: 'plot',
        'data-plot': 'waterfall',
        'data-joint': joint,
        'data-points': 'rows:' + rows.length
      },
      element('figcaption', {}, jointName(joint)), chart);
}

function fillWaterfalls() {
  byId('waterfalls').replaceChildren(...series.joints.map((_, i) => waterfall(i + 1)));
  if (!result.findings.length) byId('gains').remove();
}
