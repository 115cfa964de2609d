// Errors per joint, as a table with bars.

// A bar from zero for each error, and a mark at the noise floor; the scale is common to all joints.
function errorBars(bars, floor, largest) {
  const width = (pointer) => (100 * valueAt(pointer) / largest).toFixed(2) + '%';
  const there = bars.filter((bar) => isNumber(valueAt(bar.from)));
  return element(
      'div', {class: 'bars', 'aria-hidden': 'true'},
      there.map((bar) => element('i', {class: bar.kind, style: 'width:' + width(bar.from)})),
      isNumber(valueAt(floor)) ? element('b', {style: 'left:' + width(floor)}) : null);
}

/**
 * One line: error of each joint at `place`, with where it goes to at `after` if that is given, and
 * the noise floor.
 */
function errorsInWords(title, place, after) {
  return [
    element('p', {class: 'small'}, title),
    element('ul', {class: 'errors-in-words'}, series.joints.map((joint, i) => {
      const floor = '/noise_floor/relative_error/' + i;
      const error = after ? fromTo(place + i, after + i) : percent(place + i);
      return element(
          'li', {}, element('span', {class: 'name'}, joint.name), ' ', error,
          isNumber(valueAt(floor)) ?
              [' ', element('span', {class: 'floor'}, '(noise floor ', percent(floor), ')')] :
              null);
    }))
  ];
}

/**
 * @param columns  [{name, place, kind}]: place is the list of relative errors in the result; kind,
 *     if given, makes a bar.
 */
function errorTable(columns, floor) {
  const there = columns.filter(
      (column) => Array.isArray(valueAt(column.place)) && valueAt(column.place).length);
  const bars = there.filter((column) => column.kind);
  const largest =
      Math.max(1e-12, ...bars.flatMap((column) => valueAt(column.place)).filter(isNumber));
  const head = [{name: 'Joint'}].concat(
      there.map((column) => ({name: column.name, kind: 'number'})),
      bars.length ? [{name: 'Held out, with the noise floor', kind: 'graph'}] : []);
  const rows = series.joints.map(
      (joint, i) => [element('strong', {}, i + 1 + ' ' + joint.name)].concat(
          there.map((column) => percent(column.place + '/' + i)),
          bars.length ? [errorBars(
                            bars.map((c) => ({kind: c.kind, from: c.place + '/' + i})),
                            floor + '/' + i, largest)] :
                        []));
  return table(head, rows, 'errors');
}
