// Parts that every page is made of: elements, tables, folded parts, words as they are set here.

function byId(id) {
  return document.getElementById(id);
}

function fill(node, attributes, children) {
  for (const [name, value] of Object.entries(attributes || {})) {
    if (value !== undefined && value !== null) node.setAttribute(name, value);
  }
  node.append(...children.flat(Infinity).filter((child) => child !== undefined && child !== null && child !== false));
  return node;
}

function element(tag, attributes, ...children) {
  return fill(document.createElement(tag), attributes, children);
}

function drawing(tag, attributes, ...children) {
  return fill(document.createElementNS('http://www.w3.org/2000/svg', tag), attributes, children);
}

const paragraph = (kind, ...children) => element('p', kind ? {class: kind} : {}, ...children);
const strong = (...children) => element('strong', {}, ...children);
const heading = (text, ...rest) => element('h3', {}, text, ...rest);
const named = (name, ...value) => element('div', {}, element('dt', {}, name), element('dd', {}, ...value));

const kLongTable = 14;  // rows; a longer table shows as many and a button for the others

/**
 * A table; it scrolls by itself where the page is narrow, and a long one is folded.
 * @param columns  names, or {name, kind}; a name that begins with '#' is a column of numbers, set to the right.
 * @param rows     lists of cells (nodes or text), one per column; null leaves a cell empty.
 */
function table(columns, rows, className) {
  const heads = columns.map(
      (c) => typeof c !== 'string' ? c : c[0] === '#' ? {name: c.slice(1), kind: 'number'} : {name: c});
  const head = heads.map((c) => element('th', {scope: 'col', class: c.kind}, c.name));
  const folded = rows.length > kLongTable + 2;
  const body = rows.map((cells, r) => element('tr', {class: folded && r >= kLongTable ? 'more' : null}, cells.map((cell, k) => {
    const kind = (heads[k].kind || '') + (cell === null ? ' empty' : '');
    return element('td', {class: kind || null, 'data-label': heads[k].name}, cell);
  })));
  const made = element('table', {class: className}, element('thead', {}, element('tr', {}, head)), element('tbody', {}, body));
  const box = element('div', {class: 'table', tabindex: 0, role: 'region', 'aria-label': className || 'table'}, made);
  if (!folded) return box;
  const all = element('button', {type: 'button', class: 'all-rows', 'aria-expanded': 'false'}, 'All ' + rows.length + ' rows');
  all.addEventListener('click', () => {
    made.classList.add('whole');
    all.remove();
    noteState();
  });
  return [box, all];
}

/** Groups of [value, text] as a select; `choose` is called with the value that the reader picks. */
function chooser(label, groups, choose) {
  const select = element('select', {}, groups.map((group) => {
    const options = group.options.map(([value, text]) => element('option', {value}, text));
    return group.name ? element('optgroup', {label: group.name}, options) : options;
  }));
  select.addEventListener('change', () => choose(select.value));
  return element('label', {}, label + ' ', select);
}

function button(text, press, label) {
  const made = element('button', {type: 'button', 'aria-label': label, title: label}, text);
  made.addEventListener('click', press);
  return made;
}

function folded(title, ...children) {
  return element('details', {}, element('summary', {}, title), ...children);
}

/** A sentence of the result as it is set here: minus signs, powers, numbers that stay with their units. */
function typeset(sentence) {
  const powers = {1: '\u00b9', 2: '\u00b2', 3: '\u00b3', 4: '\u2074'};
  return String(sentence)
      .replace(/\^([1-4])\b/g, (_, power) => powers[power])
      .replace(/(^|[\s(])-(?=\d)/g, '$1\u2212')
      .replace(/(\d) (?=[A-Za-z\u00b5%]{1,4}\b|%)/g, '$1\u00a0')
      .replace(/N m\b/g, 'N\u00a0m');
}

/** A word of the results as people write it; what stands behind a colon or in brackets is the user's name. */
function words(name) {
  return String(name).replace(/^[^:(]*/, (own) => own.replace(/_/g, ' '));
}

function fileName(path) {
  return String(path).split('/').pop();
}

function countOf(count, one, many) {
  return count + '\u00a0' + (count === 1 ? one : many || one + 's');
}

function listed(names) {
  return names.length < 2 ? names.join('') : names.slice(0, -1).join(', ') + ' and ' + names[names.length - 1];
}

/** [[{item, k}, ...], ...]: items of one key together, with their places in the list. */
function groupBy(list, keyOf) {
  const groups = new Map();
  list.forEach((item, k) => {
    const name = keyOf(item);
    if (!groups.has(name)) groups.set(name, []);
    groups.get(name).push({item, k});
  });
  return [...groups.values()];
}

/** Figures side by side, or nothing. */
function grid(figures) {
  const there = figures.flat().filter(Boolean);
  return there.length ? element('div', {class: 'charts'}, there) : null;
}

function saveAs(name, kind, text) {
  const link = element('a', {href: URL.createObjectURL(new Blob([text], {type: kind})), download: name});
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 1000);
  document.documentElement.dataset.saved = name + ' ' + text.length;
}
