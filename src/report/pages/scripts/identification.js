// What identify found, in words and tables.

function identificationWords() {
  const feasible = result.feasible ? 'every body is physically possible' :
                                     'not every body is physically possible';
  const lead = element(
      'p', {class: 'lead'}, String(result.base_parameters.length), ' base parameters from ',
      number('/rows', 'whole'), ' rows; ' + feasible + '.');
  const out = [
    ...(result.verdict && result.verdict.sentence ?
            [element('p', {class: 'lead'}, result.verdict.sentence + '.')] :
            []),
    lead,
    ...errorsInWords(
        result.test ? 'Held-out error, per joint:' : 'Error on the training recordings, per joint:',
        result.test ? '/test/relative_error/' : '/train/relative_error/')
  ];
  if (result.status !== 'done') out.push(element('p', {class: 'warning'}, result.reason));
  const facts = [
    ['Condition number, columns scaled', '/condition_number'],
    ['Condition number, as they are', '/condition_number_unscaled'], ['Rank gap', '/rank_gap'],
    ['Rows that count after autocorrelation', '/effective_samples'],
    ['Weighted sum of squares', '/objective'],
    ['The same without conditions', '/unconstrained_objective'], ['Duality gap', '/duality_gap']
  ];
  out.push(element(
      'dl', {class: 'facts-list'},
      facts.filter(([, place]) => isNumber(valueAt(place)))
          .map(
              ([name, place]) => (element(
                  'div', {}, element('dt', {}, name),
                  element('dd', {}, number(place, 'plain')))))));
  if ((result.active_constraints || []).length) {
    out.push(element(
        'p', {class: 'small'},
        'At the edge of what is possible: ' + result.active_constraints.join(', ') + '.'));
  }
  return out;
}

function fillRecordingErrors() {
  const rows = [];
  for (const part of ['test', 'train']) {
    const recordings = result[part] && result[part].recordings || [];
    recordings.forEach((recording, k) => {
      const place = '/' + part + '/recordings/' + k + '/relative_error/';
      rows.push([
        element('strong', {}, fileName(recording.source)), part === 'test' ? 'held out' : 'training'
      ].concat(series.joints.map((_, i) => percent(place + i))));
    });
  }
  if (rows.length < 2) return;
  const columns = [{name: 'Recording'}, {name: 'Part'}].concat(
      series.joints.map((joint, i) => ({name: i + 1 + ' ' + joint.name, kind: 'number'})));
  byId('recording-errors')
      .append(element('h3', {}, 'By recording'), table(columns, rows, 'recording-errors'));
}

// The value with two digits of its deviation.
function baseRow(one, k) {
  const place = '/base_parameters/' + k;
  const decimals = isNumber(one.std) && one.std > 1e-7 && Math.abs(one.value) < 1e5 ?
      Math.max(0, 1 - Math.floor(Math.log10(one.std))) :
      null;
  const write = decimals === null ? undefined : (v) => withMinus(v.toFixed(decimals));
  return [
    element(
        'span', {class: 'expression'},
        (one.expression || one.name).replace(/(^| )- ?/g, '$1\u2212 ')),
    number(place + '/value', 'plain', write), number(place + '/std', 'plain', write),
    typeset(one.unit)
  ];
}

function fillIdentification() {
  byId('title').textContent = result.robot;
  byId('facts').append(words(result.method) + ' least squares');
  byId('verdict').append(...identificationWords());
  byId('error-table')
      .append(errorTable(
          [
            {name: 'Held out', place: '/test/relative_error', kind: 'extended'},
            {name: 'Held out, moving', place: '/test/moving/relative_error'},
            {name: 'Held out, largest', place: '/test/max_error'},
            {
              name: 'Training',
              place: '/train/relative_error',
              kind: result.test ? undefined : 'extended'
            },
            {name: 'Noise floor', place: '/noise_floor/relative_error'},
          ],
          '/noise_floor/relative_error'));
  fillRecordingErrors();
  byId('base-table')
      .append(table(
          [
            {name: 'Base parameter'}, {name: 'Value', kind: 'number'},
            {name: 'Std. deviation', kind: 'number'}, {name: 'Unit'}
          ],
          result.base_parameters.map(baseRow), 'base'));
}
