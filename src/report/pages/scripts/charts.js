// Drawings with two axes, as vector graphics: lines, bands, dots, bars. Colours are names of the
// style sheet; every drawing can be saved as SVG and as CSV.

const kChart = {left: 54, right: 12, top: 10, bottom: 36};
const kNarrow = 600;  // [px] of a window in which drawings are made narrower, so that their words stay readable
const kAround = 50;   // [px] left and right of a drawing there

/** The width to draw in: as asked, or that of a narrow window but not less than `least`. */
function fitting(width, least) {
  const there = document.documentElement.clientWidth;
  return there < kNarrow ? Math.min(width, Math.max(least, there - kAround)) : width;
}

/** Round numbers in a range, at most `most` of them. */
function ticks([low, high], most) {
  const rough = (high - low) / most;
  const power = Math.pow(10, Math.floor(Math.log10(rough)));
  const step = [1, 2, 5, 10].map((m) => m * power).find((s) => s >= rough * (1 - 1e-9));
  const decimals = Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
  const out = [];
  for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; ++k) {
    out.push({at: k * step, text: withMinus((k * step).toFixed(decimals).replace(/^-(0\.?0*)$/, '$1'))});
  }
  return out;
}

const kDecades = [1, 2, 5];

function logTicks([low, high]) {
  const out = [];
  for (let e = Math.floor(Math.log10(low)); e <= Math.log10(high); ++e) {
    for (const m of kDecades) {
      const at = m * Math.pow(10, e);
      if (at >= low * 0.999 && at <= high * 1.001) out.push({at, text: short(at)});
    }
  }
  return out;
}

function pathOf(points, x, y) {
  let out = '';
  let drawing = false;
  for (const [a, b] of points) {
    const there = isNumber(a) && isNumber(b);
    if (there) out += (drawing ? 'L' : 'M') + x(a).toFixed(1) + ' ' + y(b).toFixed(1);
    drawing = there;
  }
  return out;
}

const kMarks = {
  line: (m, x, y) => drawing('path', {
    d: pathOf(m.points, x, y), fill: 'none', stroke: 'var(--' + m.colour + ')', 'stroke-width': m.width || 1.6,
    'stroke-linejoin': 'round', 'stroke-dasharray': m.dash
  }),
  // [x, low, high]: between two curves.
  band: (m, x, y) => {
    const there = m.points.filter((p) => p.every(isNumber));
    const edge = there.map((p) => [p[0], p[1]]).concat(there.map((p) => [p[0], p[2]]).reverse());
    return drawing('path', {d: pathOf(edge, x, y) + 'Z', fill: 'var(--' + m.colour + ')', 'fill-opacity': 0.22});
  },
  dots: (m, x, y) => drawing('path', {
    d: m.points.filter((p) => isNumber(p[0]) && isNumber(p[1])).map(([a, b]) => 'M' + x(a).toFixed(1) + ' ' + y(b).toFixed(1) + 'h0').join(''),
    stroke: 'var(--' + m.colour + ')', 'stroke-width': m.width || 1.8, 'stroke-linecap': 'round', 'stroke-opacity': m.opacity || 0.35
  }),
  // [from, to, value]: from zero up.
  bars: (m, x, y) => drawing('g', {fill: 'var(--' + m.colour + ')'}, m.points.map(
      ([a, b, v]) => drawing('rect', {x: x(a).toFixed(1), width: Math.max(1, x(b) - x(a) - 1).toFixed(1), y: y(v).toFixed(1), height: Math.max(0, y(0) - y(v)).toFixed(1)}))),
};

function axisParts(spec, size, x, y, xRange, yRange) {
  const {width, height} = size;
  const bottom = height - kChart.bottom;
  const text = (px, py, anchor, words, kind) => drawing('text', {x: px, y: py, 'text-anchor': anchor, class: kind || 'tick'}, words);
  const line = (x1, y1, x2, y2, kind) => drawing('line', {x1, y1, x2, y2, class: kind || 'grid'});
  const across = spec.x.ticks || (spec.x.log ? logTicks(xRange) : ticks(xRange, Math.max(2, Math.floor(width / 75))));
  const up = spec.y.ticks || ticks(yRange, Math.max(2, Math.floor(height / 50)));
  const parts = across.flatMap((t) => [line(x(t.at), kChart.top, x(t.at), bottom), text(x(t.at), bottom + 14, 'middle', t.text)]);
  for (const t of up) parts.push(line(kChart.left, y(t.at), width - kChart.right, y(t.at)), text(kChart.left - 6, y(t.at) + 4, 'end', t.text));
  if (yRange[0] < 0 && yRange[1] > 0) parts.push(line(kChart.left, y(0), width - kChart.right, y(0), 'zero'));
  if (xRange[0] < 0 && xRange[1] > 0 && !spec.x.log) parts.push(line(x(0), kChart.top, x(0), bottom, 'zero'));
  parts.push(text(width - kChart.right, height - 5, 'end', spec.x.name, 'axis'));
  return parts;
}

function csvOf(spec) {
  const rows = [[spec.x.name, 'curve', spec.y.name, 'to'].join(',')];
  for (const mark of spec.marks)
    for (const [a, b, c] of mark.points) rows.push([a, '"' + mark.name + '"', b, c].map((v) => v === null || v === undefined ? '' : v).join(','));
  return rows.join('\n') + '\n';
}

/** A drawing as a file of its own: colours of the style sheet become numbers. */
function svgFile(svg) {
  const copy = svg.cloneNode(true);
  copy.setAttribute('xmlns', 'http://www.w3.org/2000/svg');
  const style = drawing('style', {}, 'text{font:11.5px sans-serif;fill:' + colour('text') + '}.grid{stroke:' + colour('line') +
      '}.zero{stroke:' + colour('quiet') + '}');
  copy.prepend(style);
  return new XMLSerializer().serializeToString(copy).replace(/var\(--([a-z-]+)\)/g, (_, name) => colour(name));
}

/** Buttons that save a figure; `svg` and `csv` are made when they are pressed. */
function saveButtons(name, svg, csv) {
  const file = ((result.robot || result.scenario || 'veridyn') + '-' + name).replace(/[^a-z0-9]+/gi, '-').toLowerCase();
  return element(
      'span', {class: 'tools'}, button('SVG', () => saveAs(file + '.svg', 'image/svg+xml', svg()), 'Save ' + name + ' as SVG'),
      button('CSV', () => saveAs(file + '.csv', 'text/csv', csv()), 'Save the numbers of ' + name + ' as CSV'));
}

/** The drawing alone. @param spec  {x: {name, range, log, ticks}, y: the same, marks, width, height, equal} */
function chartDrawing(spec) {
  const size = {width: fitting(spec.width || 520, 0), height: spec.height || 250};
  const parts = (k) => spec.marks.flatMap((m) => m.points.flatMap((p) => m.kind === 'bars' ? (k ? [p[2], 0] : [p[0], p[1]]) : k ? p.slice(1) : [p[0]]));
  let xRange = spec.x.range || (spec.x.log ? [Math.min(...parts(0)), Math.max(...parts(0))] : rangeOf([parts(0)]));
  let yRange = spec.y.range || rangeOf([parts(1)]);
  const scale = (range, log, from, to) => {
    const f = log ? Math.log10 : Number;
    return (v) => from + (to - from) * (f(v) - f(range[0])) / (f(range[1]) - f(range[0]));
  };
  const x = scale(xRange, spec.x.log, kChart.left, size.width - kChart.right);
  const y = scale(yRange, false, size.height - kChart.bottom, kChart.top);
  const marks = spec.marks.filter((m) => m.points.length);
  return drawing(
      'svg', {viewBox: '0 0 ' + size.width + ' ' + size.height, role: 'img', 'aria-label': spec.title, class: 'chart', style: 'max-width:' + 1.3 * size.width + 'px'},
      axisParts(spec, size, x, y, xRange, yRange), marks.map((m) => drawing('g', {}, drawing('title', {}, m.name), kMarks[m.kind](m, x, y))),
      spec.extra ? spec.extra(x, y, size) : null);
}

/** A figure: title, keys, drawing, and what it takes to save it. */
function chart(spec) {
  const marks = spec.marks.filter((m) => m.points.length);
  const svg = chartDrawing(spec);
  const keys = marks.filter((m) => m.name && !m.silent).map((m) => key(m.name, m.colour));
  return element(
      'figure', {class: 'plot drawn', 'data-plot': spec.name, 'data-joint': spec.joint,
                 'data-points': marks.filter((m) => !m.silent).map((m) => (m.name || m.kind) + ':' + m.points.length).join(' ')},
      element('figcaption', {}, spec.title, spec.y.name ? element('span', {class: 'unit'}, ' [' + typeset(spec.y.name) + ']') : null,
              saveButtons(spec.title, () => svgFile(svg), () => csvOf(spec))),
      keys.length > 1 || spec.keys ? paragraph('keys', keys) : null, svg, spec.note ? paragraph('caption', spec.note) : null);
}

// ---- rows with bars: verdicts, shares, staircases, intervals

const kRow = 26;
const kShortestBars = 90;  // [px] of the longest bar in a narrow window

/**
 * Rows of one thing each: {label, parts: [{from, to, colour}], dots, ticks, value}.
 * @param spec  {name, joint, title, rows, range, log, marks: [{at, text}], left, right, note}
 */
function rowChart(spec) {
  const left = spec.left || 120;
  const width = fitting(spec.width, left + (spec.right || 150) + kShortestBars);
  const right = width - (spec.right || 150);
  const f = spec.log ? Math.log10 : Number;
  const x = (v) => left + (right - left) * (f(Math.min(Math.max(v, spec.range[0]), spec.range[1])) - f(spec.range[0])) / (f(spec.range[1]) - f(spec.range[0]));
  const height = spec.rows.length * kRow + (spec.marks ? 20 : 2);
  const grid = (spec.marks || []).flatMap((m) => [
    drawing('line', {x1: x(m.at), x2: x(m.at), y1: 0, y2: spec.rows.length * kRow, class: m.kind || 'grid'}),
    m.text ? drawing('text', {x: x(m.at), y: spec.rows.length * kRow + 14, 'text-anchor': 'middle', class: 'tick'}, m.text) : null
  ]);
  const rows = spec.rows.map((row, k) => {
    const y = k * kRow;
    return drawing(
        'g', {}, drawing('title', {}, row.title || row.label), drawing('text', {x: 0, y: y + 17, class: 'label'}, row.label),
        (row.parts || []).map((p) => drawing('rect', {
          x: Math.min(x(p.from), x(p.to)).toFixed(1), width: Math.max(1.5, Math.abs(x(p.to) - x(p.from))).toFixed(1),
          y: y + (p.thin ? 11 : 6), height: p.thin ? 3 : kRow - 12, fill: 'var(--' + p.colour + ')', rx: p.thin ? 0 : 2})),
        (row.dots || []).map((d) => d.tick ?
          drawing('line', {x1: x(d.at), x2: x(d.at), y1: y + 4, y2: y + kRow - 4, stroke: 'var(--' + d.colour + ')', 'stroke-width': 2.2}) :
          drawing('circle', {cx: x(d.at).toFixed(1), cy: y + 12.5, r: 4, fill: 'var(--' + d.colour + ')'})),
        drawing('text', {x: width, y: y + 17, 'text-anchor': 'end', class: 'value'}, row.value));
  });
  const svg = drawing('svg', {viewBox: '0 0 ' + width + ' ' + height, role: 'img', 'aria-label': spec.title, class: 'chart', style: 'max-width:' + 1.25 * width + 'px'}, grid, rows);
  const csv = () => 'row,from,to\n' + spec.rows.flatMap((r) => (r.parts || []).map((p) => '"' + r.label + '",' + p.from + ',' + p.to)).join('\n') + '\n';
  return element(
      'figure', {class: 'plot drawn', 'data-plot': spec.name, 'data-joint': spec.joint, 'data-points': 'rows:' + spec.rows.length},
      element('figcaption', {}, spec.title, saveButtons(spec.title, () => svgFile(svg), csv)), spec.keys ? paragraph('keys', spec.keys) : null, svg,
      spec.note ? paragraph('caption', spec.note) : null);
}

// The same marks as number() makes, inside a drawing.
function drawnNumber(pointer, style) {
  const how = styles[style || 'percent'];
  const value = valueAt(pointer);
  return drawing('tspan', {class: 'n', 'data-from': pointer, 'data-scale': how.scale}, isNumber(value) ? how.write(value * how.scale) : '\u2013');
}
