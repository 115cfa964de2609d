// The verdict in words, and the order of a diagnosis.

const kSentences = 5;  // findings named at the top

function countOf(count, one, many) {
  return count + ' ' + (count === 1 ? one : many);
}

// What the held-out recordings say of a finding: confirmed with its share, or not.
function statusWords(finding, k) {
  const share = number('/findings/' + k + '/explains', 'share');
  if (finding.outside) return element('span', {class: 'small'}, 'Left out of the fit.');
  return finding.status === 'confirmed' ?
      element('span', {class: 'small'}, 'Explains ', share, '\u00a0%.') :
      element(
          'strong', {class: 'warning'}, 'Not confirmed: the held-out error is no smaller with it (',
          share, '\u00a0%).');
}

function verdictItem(finding, k) {
  return element('li', {}, typeset(finding.sentence), ' ', statusWords(finding, k));
}

// Joints that the extended model predicts worse than the baseline does.
function worseJoints() {
  return (result.summary ? result.summary.worse_joints : [])
      .map(
          (joint) => element(
              'p', {class: 'warning'}, 'The extended model is worse on ',
              jointName(joint).toLowerCase(), ': ',
              fromTo(
                  '/baseline/test/relative_error/' + (joint - 1),
                  '/extended/test/relative_error/' + (joint - 1)),
              '.'));
}

function explainedByMain() {
  const s = result.summary;
  if (!s || s.main_findings >= result.findings.length) return null;
  return element(
      'p', {}, 'The first ', number('/summary/main_findings', 'whole'), ' explain ',
      number('/summary/explained_by_main', 'share'), '\u00a0% of the removable held-out error, all ',
      String(result.findings.length), ' of them ', number('/summary/explained_by_all', 'share'),
      '\u00a0%.');
}

function verdictFindings() {
  const findings = result.findings;
  if (!findings.length) {
    return [element(
        'p', {class: 'lead'},
        result.changes_since ?
            'Nothing has changed since the model was made, as far as these recordings tell.' :
            'Nothing found' +
                ((result.verdict || []).every((v) => v.state === 'at_floor') ?
                     ': every joint is at its floor.' :
                     ', yet not every joint is at its floor.'))];
  }
  const points = findings.length === 1 ? 'one point' : findings.length + ' points';
  const lead = (result.changes_since ? 'Since the model was made, the arm has changed in ' :
                                       'The arm differs from the model in ') +
      points + '.';
  const main = findings.filter((finding) => finding.main !== false).length;
  const shown = Math.min(main, kSentences);
  const more = findings.length - shown;
  return [
    element('p', {class: 'lead'}, lead),
    element('ol', {}, findings.slice(0, shown).map(verdictItem)),
    more > 0 ? element(
                   'p', {}, 'And ' + more + (shown === main ? ' small ones' : ' more') + ' in the ',
                   element('a', {href: '#findings'}, 'table of findings'), '.') :
               null,
    explainedByMain(), ...worseJoints(),
    result.summary && !result.summary.held_out_untouched ?
        element(
            'p', {class: 'warning'},
            'The held-out recordings chose among the findings: the extended model\u2019s held-out ' +
                'error is no longer that of recordings that took no part.') :
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
      number('/hypotheses', 'whole'), ' hypotheses tested in ',
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
            {name: 'Held out, baseline', place: '/baseline/test/relative_error', kind: 'model'},
            extended && {
              name: 'Held out, extended',
              place: '/extended/test/relative_error',
              kind: 'extended'
            },
            extended && result.extended.test.repaired && {
              name: 'Extended, late rows repaired',
              place: '/extended/test/repaired/relative_error'
            },
            extended && result.extended.test.without_excluded && {
              name: 'Extended, without excluded rows',
              place: '/extended/test/without_excluded/relative_error'
            },
            {name: 'Noise floor', place: '/noise_floor/relative_error'},
            {name: 'Training, baseline', place: '/baseline/train/relative_error'},
            extended && {name: 'Training, extended', place: '/extended/train/relative_error'},
          ].filter(Boolean),
          '/noise_floor/relative_error'));
  fillJointVerdicts();
  fillFindings();
  fillNextExperiment();
  fillWaterfalls();
  fillCannotTell();
  fillNotSupported();
  fillLeftOut();
  fillQuality();
}
