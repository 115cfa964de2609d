// What the data rule out, what they cannot tell, and what is wrong with the recordings.

function groupBy(list, keyOf) {
  const groups = new Map();
  list.forEach((item, k) => {
    const name = keyOf(item);
    if (!groups.has(name)) groups.set(name, []);
    groups.get(name).push({item, k});
  });
  return [...groups.values()];
}

function shortJoint(joint) {
  const known = series.joints[joint - 1];
  return known ? joint + '\u00a0' + known.name : joint ? String(joint) : 'whole arm';
}

function fillNotSupported() {
  const list = result.not_supported || [];
  if (!list.length) return;
  const joints = [...new Set(list.map((item) => item.joint))].sort((a, b) => a - b);
  const columns =
      [{name: 'Effect'}].concat(joints.map((joint) => ({name: shortJoint(joint), kind: 'number'})));
  const rows =
      groupBy(list, (item) => item.effect)
          .map(
              (group) => [element('strong', {}, words(group[0].item.effect))].concat(
                  joints.map((joint) => {
                    const cells = group.filter(({item}) => item.joint === joint);
                    return cells.length ?
                        element(
                            'span', {},
                            cells.flatMap(
                                ({k, item}, at) =>
                                    [at ? ', ' : '',
                                     element('span', {title: item.why}, number('/not_supported/' + k + '/p_value', 'chance'))])) :
                        null;
                  })));
  byId('not-supported')
      .append(
          element('h3', {}, 'Not supported'),
          element(
              'p', {class: 'note'},
              'Effects that were asked and not accepted, with the p of the best evidence for each on each joint; the reason shows under the pointer.'),
          table(columns, rows, 'excluded'));
}

function fillCannotTell() {
  const groups = groupBy(result.cannot_tell || [], (item) => item.effect + '\n' + item.why);
  if (!groups.length) return;
  const rows = groups.map(
      (group) =>
          [element('strong', {}, words(group[0].item.effect)),
           group.map(({item}) => shortJoint(item.joint)).join(', '), typeset(group[0].item.why)]);
  byId('cannot-tell')
      .append(
          element('h3', {}, 'Cannot be told'),
          table([{name: 'Effect'}, {name: 'Joint'}, {name: 'Why'}], rows, 'cannot-tell'));
}

function fillLeftOut() {
  const seconds = (v) => v.toFixed(2);
  const list = result.left_out || [];
  if (!list.length) return;
  const rows = list.map(
      (part, k) =>
          [element('strong', {}, fileName(part.file)), shortJoint(part.joint),
           element(
               'span', {}, number('/left_out/' + k + '/from', 'plain', seconds), ' to ',
               number('/left_out/' + k + '/to', 'plain', seconds), '\u00a0s'),
           typeset(part.why)]);
  byId('quality-table')
      .append(
          element('h3', {}, 'Left out'),
          element(
              'p', {class: 'note'},
              'Moments that belong to a recording and not to the arm; no fit and no error counts them. The plots over time mark them.'),
          table(
              [{name: 'Recording'}, {name: 'Joint'}, {name: 'Time'}, {name: 'Why'}], rows,
              'left-out'));
}

function filledRows(place) {
  const share = number(place + '/share', 'share');
  const late = number(place + '/lateness', 'milli');
  return element(
      'span', {}, ' Of the rows ', share, '\u00a0% are filled in; what they showed was ', late,
      '\u00a0ms old on average.');
}

function fillQuality() {
  const groups = groupBy(result.data_quality || [], (item) => item.file);
  if (!groups.length) {
    if (!(result.left_out || []).length)
      byId('quality-table').append(element('p', {}, 'Nothing to remark.'));
    return;
  }
  const rows = groups.map(
      (group) =>
          [element('strong', {}, fileName(group[0].item.file)),
           element(
               'ul', {class: 'remarks'},
               group.map(
                   ({item, k}) => element(
                       'li', {}, typeset(item.sentence),
                       item.filled_rows ? filledRows('/data_quality/' + k + '/filled_rows') :
                                          null)))]);
  byId('quality-table').append(table([{name: 'Recording'}, {name: 'Remarks'}], rows, 'quality'));
}
