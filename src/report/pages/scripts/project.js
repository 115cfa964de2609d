// One page for a folder: models over time, what changed when, links to the other pages.

const kUnits = [['days', 86400e3], ['hours', 3600e3], ['minutes', 60e3], ['seconds', 1e3]];  // [ms]

/** The largest unit of which the models span two; seconds for less. */
function unitOf(models) {
  const dates = models.map((m) => Date.parse(m.date));
  const span = Math.max(...dates) - Math.min(...dates);
  return kUnits.find(([, size]) => span >= 2 * size) || kUnits[kUnits.length - 1];
}

function day(date) {
  return String(date).replace('T', ' ').replace(/:\d\dZ?$/, '');
}

/** Each parameter over time, where several models have it: dots with 95 % intervals. */
function historyCharts(robot) {
  const models = result.models.filter((m) => m.robot === robot);
  const first = Date.parse(models[0].date);
  const [unit, size] = unitOf(models);
  const names = [...new Set(models.flatMap((m) => m.parameters.map((p) => p.name)))];
  return names.map((name) => {
    const points = models.map((m) => ({m, p: m.parameters.find((p) => p.name === name)})).filter(({p}) => p && isNumber(p.value))
        .map(({m, p}) => ({at: (Date.parse(m.date) - first) / size, value: p.value, half: kNormal95 * (p.std || 0), unit: p.unit}));
    if (points.length < 2) return null;
    return chart({
      name: 'history', joint: 0, title: name, x: {name: unit + ' since ' + day(models[0].date)}, y: {name: points[0].unit}, width: 400, height: 200, marks: [
        {kind: 'line', name: '95 %', colour: 'quiet', width: 1.2, silent: true, points: points.flatMap((p) => [[p.at, p.value - p.half], [p.at, p.value + p.half], [null, null]])},
        {kind: 'line', name: 'course', colour: 'pale-extended', silent: true, points: points.map((p) => [p.at, p.value])},
        {kind: 'dots', name: 'value', colour: 'extended', width: 7, opacity: 1, points: points.map((p) => [p.at, p.value])}]});
  });
}

pages.page = () => {
  const robots = [...new Set(result.models.map((m) => m.robot))];
  const changed = result.changes.filter((c) => c.verdict === 'differ');
  const last = result.changes[result.changes.length - 1];
  const dates = result.models.concat(result.pages, result.recordings).map((one) => one.date).filter(Boolean).sort();
  const newest = result.models[result.models.length - 1];
  const charts = robots.flatMap(historyCharts);
  return {
    title: result.name || fileName(result.folder.replace(/\/+$/, '')) || result.folder, kind: 'Project',
    facts: [countOf(result.models.length, 'model') + ', ' + countOf(result.pages.length, 'page') + ', ' + countOf(result.recordings.length, 'recording') +
            (dates.length ? ', from ' + day(dates[0]) + ' to ' + day(dates[dates.length - 1]) : '')],
    lead: !last ? 'Nothing to compare yet: ' + countOf(result.models.length, 'model') + '.' : changed.length ? 'Changed ' + countOf(changed.length, 'time') + ', last on ' + day(changed[changed.length - 1].date) + '.' :
        'No change beyond chance between ' + countOf(result.models.length, 'model') + '.',
    state: last && last.verdict === 'differ' ? 'bad' : 'good',
    good: [result.changes.length ? table(['When', 'From', 'To', 'What changed'], result.changes.map((c) => [day(c.date), fileName(c.before), fileName(c.after),
      c.verdict === 'same' ? 'nothing beyond chance' : c.sentences.length ? element('ul', {}, c.sentences.map((s) => element('li', {}, typeset(s)))) : words(c.verdict)]), 'changes') : null],
    next: newest ? [{why: 'Ask the next recordings what has changed since:', command: 'veridyn diagnose ' + newest.file + ' --train NEW.csv --test OTHER.csv'}] : null,
    picture: charts.find(Boolean) || null,
    sections: [
      section('history', 'Parameters over time', null, grid(charts.filter(Boolean).slice(1))),
      section('models', 'Models', null, result.models.length ? table(['Made', 'Model', 'Robot', 'By', 'From', '#Error per joint [%]'], result.models.map((m, k) => [
        day(m.date), strong(m.file), m.robot, m.command, m.inputs.join(', '), numbers('/models/' + k + '/relative_error', 'percent')]), 'models') : null),
      section('pages', 'Pages and results', null, result.pages.length ? table(['Written', 'File', 'Command', 'Of', 'What it says'], result.pages.map((p) => [
        day(p.date), element('a', {href: encodeURI(p.link)}, p.file), p.command, p.robot, element('ul', {}, p.sentences.map((s) => element('li', {}, typeset(s))))]), 'pages') : null),
      section('recordings', 'Recordings', null, result.recordings.length ? table(['Written', 'File', '#Size [kB]'], result.recordings.map((r, k) => [
        day(r.date), r.file, number('/recordings/' + k + '/bytes', 'kilo')]), 'recordings') : null),
      section('unreadable', 'Not readable', null, result.unreadable.length ? element('ul', {}, result.unreadable.map((why) => element('li', {}, why))) : null)]
  };
};
