// Small helpers that make parts of the page.

function byId(id) {
  return document.getElementById(id);
}

function fill(node, attributes, children) {
  for (const [name, value] of Object.entries(attributes || {})) {
    if (value !== undefined && value !== null) node.setAttribute(name, value);
  }
  node.append(...children.flat(Infinity).filter((child) => child !== undefined && child !== null));
  return node;
}

function element(tag, attributes, ...children) {
  return fill(document.createElement(tag), attributes, children);
}

function drawing(tag, attributes, ...children) {
  return fill(document.createElementNS('http://www.w3.org/2000/svg', tag), attributes, children);
}

/**
 * A table whose rows become blocks on a narrow page, each cell with its column's name before it.
 * @param columns  [{name, kind}]; kind "number" is set to the right.
 * @param rows     lists of cells (nodes or text), one per column; null leaves a cell empty.
 */
function table(columns, rows, className) {
  const head =
      element('tr', {}, columns.map((c) => element('th', {scope: 'col', class: c.kind}, c.name)));
  const body = rows.map((cells) => element('tr', {}, cells.map((cell, k) => {
                          const place = {class: columns[k].kind, 'data-label': columns[k].name};
                          if (cell === null) place.class = (place.class || '') + ' empty';
                          return element('td', place, cell);
                        })));
  return element(
      'table', {class: className}, element('thead', {}, head), element('tbody', {}, body));
}

/** [[label, node], ...] as a select; `choose` is called with the value that the user picks. */
function chooser(label, groups, choose) {
  const select = element('select', {}, groups.map((group) => {
    const options = group.options.map(([value, text]) => element('option', {value: value}, text));
    return group.name ? element('optgroup', {label: group.name}, options) : options;
  }));
  select.addEventListener('change', () => choose(select.value));
  return element('label', {}, label + ' ', select);
}

/**
 * A sentence of the result as it is set here: minus signs, powers, numbers that stay with their
 * units.
 */
function typeset(sentence) {
  const powers = {1: '\u00b9', 2: '\u00b2', 3: '\u00b3', 4: '\u2074'};
  return String(sentence)
      .replace(/\^([1-4])\b/g, (_, power) => powers[power])
      .replace(/(^|[\s(])-(?=\d)/g, '$1\u2212')
      .replace(/(\d) (?=[A-Za-z\u00b5%]{1,4}\b|%)/g, '$1\u00a0')
      .replace(/N m\b/g, 'N\u00a0m');
}

function words(name) {
  return String(name).replace(/_/g, ' ');
}

function fileName(path) {
  return String(path).split('/').pop();
}
