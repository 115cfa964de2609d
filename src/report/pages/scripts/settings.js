// Inputs, version and settings: what it takes to repeat the run.

function settingText(value) {
  if (value === null || value === '' || (Array.isArray(value) && !value.length)) return '\u2013';
  if (Array.isArray(value)) return value.map((v) => v === null ? 'end' : v).join(', ');
  return String(value);
}

function fillSettings() {
  const settings = result.settings || {};
  const place = byId('settings');
  if (series.command)
    place.append(
        element('p', {class: 'small'}, 'To repeat it:'),
        element('pre', {class: 'command'}, series.command));
  const files = (role, list) =>
      (list || []).map((file) => [role, element('span', {class: 'path'}, file)]);
  const inputs = files('training', settings.train).concat(files('held out', settings.test));
  if (inputs.length)
    place.append(table([{name: 'Part'}, {name: 'Recording'}], inputs, 'inputs'));
  const rest = Object.entries(settings).filter(([name]) => name !== 'train' && name !== 'test');
  place.append(element(
      'dl', {class: 'facts-list'},
      [['veridyn', result.veridyn]].concat(rest).map(
          ([name, value]) => (element(
              'div', {}, element('dt', {}, words(name)),
              element('dd', {'data-setting': name}, settingText(value)))))));
  place.append(element(
      'p', {class: 'small'},
      'The whole result stands in this file as JSON, in the element with the id \u201cresult\u201d.'));
}
