// What watch saw. While the arm runs the page loads itself anew.

const kReload = 2000;  // [ms]

function eventTable() {
  const seconds = (place) => number(place, 'plain', (v) => v.toFixed(2));
  const rows = result.sources.flatMap((source, s) => source.events.map((event, e) => {
    const place = '/sources/' + s + '/events/' + e;
    return [
      fileName(source.source), seconds(place + '/time'), seconds(place + '/since'), event.event,
      typeset(event.sentence)
    ];
  }));
  return table(
      [
        {name: 'Source'}, {name: 'Said at [s]', kind: 'number'}, {name: 'Since [s]', kind: 'number'},
        {name: 'State'}, {name: 'What'}
      ],
      rows, 'events');
}

function fillWatch() {
  byId('title').textContent = result.robot;
  byId('facts').append(result.running ? 'running; this page follows it' : 'ended');
  const alarms = result.sources.reduce((sum, source) => sum + source.alarms, 0);
  byId('verdict').append(element(
      'p', {class: 'lead'},
      alarms === 0 ? 'Nothing changed.' :
          alarms + (alarms === 1 ? ' change' : ' changes') + ' in ' + result.sources.length +
              (result.sources.length === 1 ? ' source.' : ' sources.')));
  byId('event-table').append(eventTable());
  if (series.recordings.length) startSimulationPlots();
  if (result.running) setTimeout(() => location.reload(), kReload);
}
