// The verdict in words, and the order of a diagnosis.

const kSentences = 4;  // findings named at the top

function countOf(count, one, many) {
  return count + ' ' + (count === 1 ? one : many);
}

function verdictItem(finding, k) {
  return element(
      'li', {}, typeset(finding.sentence), ' ',
      element(
          'span', {class: 'small'}, 'Explains ', number('/findings/' + k + '/explains', 'share'),
          '\u00a0%.'));
}

function verdictFindings() {
  const findings = result.findings;
  if (!findings.length) {
    return [element(
        'p', {class: 'lead'},
        result.changes_since ?
            'Nothing has changed since the model was made, as far as these recordings tell.' :
            'Nothing found: the recordings support no further effect.')];
  }
  const points = findings.length === 1 ? 'one point' : findings.length + ' points';
  const lead = (result.changes_since ? 'Since the model was made, the arm has changed in ' :
                                       'The arm differs from the model in ') +
      points + '.';
  const more = findings.length - kSentences;
  return [
    element('p', {class: 'lead'}, lead),
    element('ol', {}, findings.slice(0, kSentences).map(verdictItem)),
    more > 0 ? element(
                   'p', {}, 'And ' + more + ' more in the ',
                   element('a', {href: '#findings'}, 'table of findings'), '.') :
               null
  ];
}

function verdictWarnings() {
  const remarks = result.data_quality || [];
  const faults = remarks.filter((item) => item.severity === 'fault');
  const out = faults.map(
      (item) =>
          element('p', {class: 'warning'}, fileName(item.file) + ': ' + typeset(item.sentence)));
  if (result.provisional)
    out.push(element(
        'p', {class: 'warning'},
        'Learned from one recording only: the names of causes are provisional.'));
  if (remarks.length > faults.length) {
    const files = new Set(remarks.map((item) => item.file)).size;
    out.push(element(
        'p', {class: 'small'},
        countOf(remarks.length - faults.length, 'remark', 'remarks') + ' on the ',
        element('a', {href: '#quality'}, 'quality of ' + countOf(files, 'recording', 'recordings')),
        '.'));
  }
  return out;
}

function fillDiagnosis() {
  byId('title').textContent = result.robot;
  byId('facts').append(
      number('/hypotheses', 'whole'), ' hypotheses asked in ',
      number('/seconds', 'plain', (v) => v.toFixed(1)), ' s');
  const extended = result.findings.length > 0;
  byId('verdict').append(
      ...verdictFindings().filter(Boolean),
      ...errorsInWords(
          extended ? 'Held-out error with all findings, per joint:' : 'Held-out error, per joint:',
          '/baseline/test/relative_error/', extended && '/extended/test/relative_error/'),
      ...verdictWarnings());
  byId('error-table')
      .append(errorTable(
          [
            {name: 'Held out, as it stands', place: '/baseline/test/relative_error', kind: 'model'},
            extended && {
              name: 'Held out, extended',
              place: '/extended/test/relative_error',
              kind: 'extended'
            },
            {name: 'Noise floor', place: '/noise_floor/relative_error'},
            {name: 'Training, as it stands', place: '/baseline/train/relative_error'},
            extended && {name: 'Training, extended', place: '/extended/train/relative_error'},
          ].filter(Boolean),
          '/noise_floor/relative_error'));
  fillFindings();
  fillNextExperiment();
  fillWaterfalls();
  fillCannotTell();
  fillNotSupported();
  fillLeftOut();
  fillQuality();
}
