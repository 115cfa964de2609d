// The one template: header, a first screen that says what this is, whether it is good and what
// comes next, then a list of sections, and what it takes to repeat the run.

const pages = {};     // by command: () => {title, facts, lead, good, next, picture, sections}
const redraws = [];   // called when the page stands, and when its colours change
const arms = [];      // {show(t), choose(recording)}

/** A section; one without content is none. @param note  words below its title. */
function section(id, title, note, ...content) {
  const there = content.flat(Infinity).filter((c) => c !== null && c !== undefined && c !== false && c !== '');
  return there.length ? {id, title, node: element('section', {id}, element('h2', {}, title), note ? paragraph('note', note) : null, there)} : null;
}

function settingText(value) {
  if (value === null || value === '' || (Array.isArray(value) && !value.length)) return '\u2013';
  if (Array.isArray(value)) return value.map((v) => v === null ? 'end' : v).join(', ');
  return String(value);
}

const kSettingUnits = {filter_cutoff: 'Hz', resample: 'Hz', rate: 'Hz', drop_start: 's', drop_end: 's', min_speed: 'rad/s, m/s',
  position_frequency: 'Hz', force_cutoff: 'Hz', observer: 'Hz', motor_lag: 's', torque_delay: 'cycles', seconds: 's'};

function runSection() {
  const settings = result.settings || {};
  const files = (role, list) => (list || []).map((file) => [role, element('span', {class: 'path'}, file)]);
  const inputs = files('training', settings.train).concat(files('held out', settings.test));
  const rest = Object.entries(settings).filter(([name]) => name !== 'train' && name !== 'test');
  const facts = [['veridyn', result.veridyn]].concat(series.made ? [['date', series.made]] : [], rest);
  return section(
      'run', 'This run', null, series.command ? [paragraph('small', 'To repeat it:'), commandLine(series.command)] : null,
      inputs.length ? table(['Part', 'Recording'], inputs, 'inputs') : null,
      element('dl', {class: 'facts-list'}, facts.map(([name, value]) => element('div', {},
        element('dt', {}, words(name) + (kSettingUnits[name] ? ' [' + kSettingUnits[name] + ']' : '')),
        element('dd', {'data-setting': name}, settingText(value))))),
      paragraph('small', 'The whole result stands in this file as JSON, in the element with the id \u201cresult\u201d: ',
                button('save it', () => saveAs((result.robot || result.command) + '.json', 'application/json', JSON.stringify(result, null, 2)))));
}

/** A command to copy. */
function commandLine(command) {
  const copy = button('Copy', () => navigator.clipboard && navigator.clipboard.writeText(command).then(() => copy.textContent = 'Copied'), 'Copy the command');
  return element('pre', {class: 'command'}, copy, element('code', {}, command));
}

/** This run's command with another name, without what it wrote; "" where it is not known. */
function otherCommand(name, without) {
  const words = (series.command || '').match(/'[^']*'|\S+/g) || [];
  if (words.length < 2) return '';
  const out = ['veridyn', name];
  const drop = new Set(['--json', '--report', '--model-out', '--factor-out', '--quiet', '--threads', '-o'].concat(without || []));
  for (let k = 2; k < words.length; ++k) {
    if (drop.has(words[k])) {
      while (k + 1 < words.length && words[k] !== '--quiet' && words[k + 1][0] !== '-') ++k;
    } else {
      out.push(words[k]);
    }
  }
  return out.join(' ');
}

/** The file that the command of this run names first. */
function fileOfRun(otherwise) {
  return ((series.command || '').match(/'[^']*'|\S+/g) || []).slice(2).find((word) => word[0] !== '-') || otherwise;
}

function wordAfter(option) {
  const words = (series.command || '').match(/'[^']*'|\S+/g) || [];
  const at = words.indexOf(option);
  return at < 0 ? '' : words[at + 1];
}

// Words and a command that come next.
function nextWords(next) {
  if (!next) return null;
  const list = [].concat(next);
  return element('div', {class: 'next'}, element('h3', {}, 'What next'), list.map((one) => one.command ? [paragraph('', one.why), commandLine(one.command)] : paragraph('', one.why || one)));
}

function build(page) {
  const main = byId('page');
  document.title = page.title + ' \u2013 ' + page.kind;
  const sections = page.sections.flat().concat(runSection()).filter(Boolean);
  main.append(element(
      'header', {}, paragraph('kind', page.kind), element('h1', {id: 'title'}, page.title), element('p', {class: 'facts', id: 'facts'}, page.facts),
      element('nav', {'aria-label': 'Parts of this page'}, sections.map((s) => element('a', {href: '#' + s.id}, s.title)))));
  const picture = [].concat(page.picture || []).flat(Infinity).filter(Boolean);
  main.append(element(
      'section', {id: 'verdict', class: 'verdict' + (picture.length ? ' with-picture' : ''), 'aria-label': 'First screen'},
      element('div', {class: 'words'}, paragraph('lead ' + (page.state || ''), page.lead), page.good, nextWords(page.next)),
      picture.length ? element('div', {class: 'picture'}, picture) : null));
  main.append(...sections.map((s) => s.node));
}

// For tests: how many plots there are, whether anything sticks out to the right, and the smallest size of words in drawings
// as a percentage of the style sheet's.
function noteState() {
  const root = document.documentElement;
  root.dataset.errors = root.dataset.errors || 0;
  root.dataset.plots = document.querySelectorAll('.plot').length;
  root.dataset.width = window.innerWidth;
  root.dataset.overflow = Math.max(0, root.scrollWidth - root.clientWidth);
  const drawn = [...document.querySelectorAll('svg.chart')].filter((svg) => svg.clientWidth > 0);
  root.dataset.words = Math.round(100 * Math.min(1, ...drawn.map((svg) => svg.clientWidth / svg.viewBox.baseVal.width)));
  root.dataset.scheme = matchMedia('(prefers-color-scheme: dark)').matches ? 'dark' : 'light';
  if (root.scrollWidth <= root.clientWidth) return;
  const wide = [...document.querySelectorAll('main *')].filter((node) => node.getBoundingClientRect().right > root.clientWidth + 0.5);
  root.dataset.overflowBy = wide.slice(0, 8).map((node) => node.tagName + '.' + node.getAttribute('class')).join(' ');
}

function start() {
  build(pages[result.command]());
  redraws.forEach((draw) => draw());
  const linked = /#t=([-0-9.]+)/.exec(location.hash);  // a moment to begin with
  if (linked) {
    arms.forEach((arm) => arm.show(Number(linked[1])));
    showMoment(Number(linked[1]));
  }
  const again = () => {
    redraws.forEach((draw) => draw());
    noteState();
  };
  matchMedia('(prefers-color-scheme: dark)').addEventListener('change', again);
  let waiting;
  window.addEventListener('resize', () => {
    clearTimeout(waiting);
    waiting = setTimeout(() => {
      arms.forEach((arm) => arm.resize());
      showMoment(moment);
      noteState();
    }, 150);
  });
  noteState();
}
