// Numbers of the page's text. Every one is fetched from the result by its place there (a JSON
// pointer) and carries that place as data-from, so that what is shown can be checked.

const result = JSON.parse(byId('result').textContent);

/** The value at a JSON pointer; undefined where there is none. */
function valueAt(pointer) {
  let value = result;
  for (const key of pointer.split('/').slice(1)) {
    if (value === null || value === undefined) return undefined;
    value = value[key.replace(/~1/g, '/').replace(/~0/g, '~')];
  }
  return value;
}

function pointerKey(key) {
  return String(key).replace(/~/g, '~0').replace(/\//g, '~1');
}

function isNumber(value) {
  return typeof value === 'number' && Number.isFinite(value);
}

function withMinus(text) {
  return text.replace(/-/g, '\u2212');
}

// 1.2e-7 as 1.2 x 10^-7.
function powerOfTen(value, digits) {
  const [mantissa, exponent] = value.toExponential(digits).split('e');
  return [withMinus(mantissa) + '\u202f\u00d7\u202f10', element('sup', {}, withMinus(String(Number(exponent))))];
}

// As many digits as are significant, never an exponent where plain digits are shorter.
function significant(value, digits) {
  const size = Math.abs(value);
  if (size !== 0 && (size < 1e-4 || size >= 1e6)) return powerOfTen(value, digits - 1);
  const decimals = size === 0 ? 0 : digits - 1 - Math.floor(Math.log10(size));
  return withMinus(value.toFixed(Math.min(Math.max(decimals, 0), 12)));
}

/** Plain text of a number for drawings. */
function short(value, digits) {
  if (!isNumber(value)) return '\u2013';
  return withMinus(String(Number(value.toPrecision(digits || 3))));
}

const fixed = (digits) => (v) => withMinus(v.toFixed(digits));

const styles = {
  percent: {scale: 100, write: (v) => fixed(Math.abs(v) < 9.995 ? 2 : 1)(v)},
  share: {scale: 100, write: (v) => fixed(Math.abs(v) < 0.95 ? 1 : 0)(v)},
  chance: {scale: 1, write: (v) => v === 0 || v === 1 ? String(v) : v < 1e-3 ? powerOfTen(v, 0) : significant(v, 2)},
  plain: {scale: 1, write: (v) => significant(v, 4)},
  milli: {scale: 1000, write: (v) => significant(v, 2)},
  whole: {scale: 1, write: fixed(0)},
  kilo: {scale: 1e-3, write: fixed(0)},
};

/** The number at a pointer, in one of the styles, or with a writer of its own. */
function number(pointer, style, write) {
  const how = styles[style];
  const value = valueAt(pointer);
  const text = isNumber(value) ? (write || how.write)(value * how.scale) : '\u2013';
  return element('span', {class: 'n', 'data-from': pointer, 'data-scale': how.scale}, text);
}

/** Numbers of a list at a pointer, with commas between. */
function numbers(pointer, style, write) {
  return (valueAt(pointer) || []).flatMap((_, k) => [k ? ', ' : '', number(pointer + '/' + k, style, write)]);
}

/** A value and the ends of its interval, all with two digits of the interval's half width. */
function sizeWithInterval(place) {
  const ends = [valueAt(place + '/ci95/0'), valueAt(place + '/ci95/1')];
  const half = isNumber(ends[0]) && isNumber(ends[1]) ? Math.abs(ends[1] - ends[0]) / 2 : 0;
  const largest = Math.max(Math.abs(valueAt(place + '/value')), Math.abs(ends[0]), Math.abs(ends[1]));
  const write = half >= 1e-4 && largest < 1e5 ?
      fixed(Math.min(Math.max(1 - Math.floor(Math.log10(half)), 0), 8)) : undefined;
  const unit = valueAt(place + '/unit');
  return [
    element('span', {class: 'value'}, number(place + '/value', 'plain', write), unit && unit !== '1' ? '\u00a0' + typeset(unit) : ''),
    ' ',
    element('span', {class: 'interval'}, '(', number(place + '/ci95/0', 'plain', write), ' to ', number(place + '/ci95/1', 'plain', write), ')')
  ];
}

/** A share as "12.3 %". */
function percent(pointer) {
  return element('span', {class: 'change'}, number(pointer, 'percent'), '\u00a0%');
}

/** A share before and after, as "12.3 -> 4.5 %". */
function fromTo(before, after) {
  return element('span', {class: 'change'}, number(before, 'percent'), '\u00a0\u2192\u00a0', percent(after));
}

/** Numbers by name, in a list of small facts; those that are not there are passed over. */
function factList(facts) {
  const there = facts.filter(([, place]) => isNumber(valueAt(place)));
  return there.length ? element('dl', {class: 'facts-list'}, there.map(([name, place, style]) => named(name, number(place, style || 'plain')))) : null;
}
