// The table of findings, and what would tell rivals apart.

// Other joints are shown where they change by more than this share of what changes most.
const kNoticeable = 0.5;

function parameterList(finding, k) {
  return element(
      'ul', {class: 'parameters'},
      Object.keys(finding.parameters)
          .map(
              (name) => element(
                  'li', {}, element('span', {class: 'name'}, words(name)), ' ',
                  sizeWithInterval('/findings/' + k + '/parameters/' + pointerKey(name)))));
}

function heldOutChange(finding, k) {
  const {before, after} = finding.gain.test_relative_error;
  const change = before.map((b, i) => Math.abs(b - after[i]));
  const most = Math.max(...change);
  const place = '/findings/' + k + '/gain/test_relative_error/';
  const joints = before.map((_, i) => i)
                     .filter((i) => i === finding.joint - 1 || change[i] > kNoticeable * most);
  return element(
      'ul', {class: 'changes'},
      joints.map(
          (i) => element(
              'li', {},
              element('span', {class: 'name'}, series.joints[i] ? series.joints[i].name : i + 1),
              ' ', fromTo(place + 'before/' + i, place + 'after/' + i))));
}

function rivalWords(rival) {
  return element(
      'strong', {},
      words(rival.effect) + ' (' + (rival.frame ? words(rival.frame) : shortJoint(rival.joint)) +
          ')');
}

// Rivals with one reason are named together.
function rivalList(finding) {
  const reasons = new Map();
  for (const rival of finding.rivals) {
    if (!reasons.has(rival.why)) reasons.set(rival.why, []);
    reasons.get(rival.why).push(rival);
  }
  return [...reasons].map(
      ([why, rivals]) => element(
          'p', {class: 'rivals'}, rivals.length > 1 ? 'Rivals: ' : 'Rival: ',
          rivals.flatMap((rival, k) => [k ? ', ' : '', rivalWords(rival)]),
          ': ' + typeset(why) + '.'));
}

// What was found, without its place: the line above says it.
function phraseOf(finding) {
  const words = finding.phrase.charAt(0).toUpperCase() + finding.phrase.slice(1) + '.';
  return typeset(finding.remark ? words + ' ' + finding.remark : words);
}

function findingRow(finding, k) {
  const place = '/findings/' + k;
  const where = [
    finding.frame ? 'frame ' + finding.frame : jointName(finding.joint).toLowerCase(),
    finding.recording && fileName(finding.recording)
  ].filter(Boolean).join(', ');
  const cause = element(
      'div', {},
      element(
          'strong', {class: 'cause'}, number(place + '/rank', 'whole'),
          '\u2002' + words(finding.effect)),
      element('span', {class: 'where'}, ', ' + where), element('p', {}, phraseOf(finding)),
      shapeCurve(finding), rivalList(finding));
  return [
    cause, parameterList(finding, k), number(place + '/p_value', 'chance'),
    heldOutChange(finding, k),
    finding.outside ? '' :
                      element(
                          'span', {class: finding.status === 'confirmed' ? 'change' : 'warning'},
                          number(place + '/explains', 'share'), '\u00a0%',
                          finding.status === 'confirmed' ? '' : ' (not confirmed)')
  ];
}

function fillFindings() {
  if (!result.findings.length) {
    byId('finding-table')
        .append(element('p', {}, 'None: the recordings support no further effect.'));
    return;
  }
  byId('finding-table')
      .append(table(
          [
            {name: 'Cause'}, {name: 'Size (95 %)', kind: 'size'}, {name: 'p', kind: 'number'},
            {name: 'Held-out error', kind: 'size'}, {name: 'Explains', kind: 'number'}
          ],
          result.findings.map(findingRow), 'findings'));
}

// { separates: [a, b], trajectory: file or words, ... }; whatever else is there is text as well.
function fillNextExperiment() {
  const next = result.next_experiment;
  if (!next || !((next.separates || []).length || next.shows)) return;
  const rest = Object.entries(next).filter(
      ([name, value]) => !['separates', 'shows'].includes(name) && value && typeof value === 'string');
  byId('next-experiment')
      .append(
          element('h3', {}, next.shows ? 'The recording that would show it best' : 'The recording that would separate them'),
          element('p', {}, element('strong', {}, next.shows || next.separates.map(words).join(' from '))),
          ...rest.map(
              ([name, value]) =>
                  element('p', {}, element('span', {class: 'name'}, words(name) + ': '), value)));
}
