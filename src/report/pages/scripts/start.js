// Fills the page, keeps the plots at what the reader chose, and notes whether all went well.

const kStacked = 4;  // joints shown at once before one is chosen for a start

const chosen = {
  recording: 0,
  joint: 0,
  against: 0
};  // joint 0: all; against 0: the joint itself

function chosenJoints() {
  return chosen.joint ? [chosen.joint] : series.joints.map((_, i) => i + 1);
}

function drawPlots() {
  const recording = series.recordings[chosen.recording];
  drawTimePlots(recording, chosenJoints());
  drawResidualPlots(recording, chosenJoints(), chosen.against);
}

function recordingGroups() {
  return ['held out', 'training']
      .map((role) => ({
             name: role,
             options: series.recordings.flatMap(
                 (r, k) => r.role === role ? [[k, fileName(r.source)]] : []),
           }))
      .filter((group) => group.options.length);
}

function fillChooser() {
  const joints = series.joints.map((_, i) => [i + 1, jointName(i + 1)]);
  if (series.joints.length > kStacked) {
    chosen.joint = (result.findings && result.findings.length && result.findings[0].joint) || 1;
  }
  const choose = (what) => (value) => {
    chosen[what] = Number(value);
    drawPlots();
    noteState();
  };
  const joint = chooser('Joint', [{options: [[0, 'all']].concat(joints)}], choose('joint'));
  joint.querySelector('select').value = chosen.joint;
  const whole = element('button', {type: 'button'}, 'Whole recording');
  whole.addEventListener('click', () => showTime(null));
  byId('chooser').append(
      chooser('Recording', recordingGroups(), choose('recording')), joint,
      chooser(
          'Residual against', [{options: [[0, 'the joint itself']].concat(joints)}],
          choose('against')),
      whole);
  if (series.left_out) {
    byId('chooser').append(element(
        'span', {class: 'small'}, series.left_out + ' more recordings are not in this page.'));
  }
  const names = new Set(series.recordings.flatMap((r) => r.joints.flatMap(curvesOf)));
  byId('time-keys').append(...[...names].map(key));
  byId('residual-keys').append(key('forward'), key('backward'));
}

// For tests: how many plots there are, and whether anything sticks out to the right.
function noteState() {
  const root = document.documentElement;
  root.dataset.errors = root.dataset.errors || 0;
  root.dataset.plots = document.querySelectorAll('.plot').length;
  root.dataset.width = window.innerWidth;
  root.dataset.overflow = Math.max(0, root.scrollWidth - root.clientWidth);
  if (root.scrollWidth <= root.clientWidth) return;
  const wide = [...document.querySelectorAll('main *')].filter(
      (node) => node.getBoundingClientRect().right > root.clientWidth + 0.5);
  root.dataset.overflowBy =
      wide.slice(0, 8).map((node) => node.tagName + '.' + node.getAttribute('class')).join(' ');
}

function start() {
  if (result.command === 'diagnose') fillDiagnosis();
  if (result.command === 'identify') fillIdentification();
  if (result.command === 'simulate') fillSimulation();
  if (result.command === 'cooperate') fillCooperation();
  if (result.command === 'kinematics') fillKinematics();
  if (result.command === 'stability') fillStability();
  if (result.command === 'excite') fillExcitation();
  if (result.command === 'calibrate') fillCalibration();
  if (result.command === 'watch') fillWatch();
  fillSettings();
  if (!['simulate', 'watch'].includes(result.command) && series.recordings.length) {
    fillChooser();
    drawPlots();
  }
  let waiting;
  window.addEventListener('resize', () => {
    clearTimeout(waiting);
    waiting = setTimeout(() => {
      redrawResidualPlots();
      rampPlots.forEach(drawRamps);
      fitTimePlotsToPaper();
      noteState();
    }, 150);
  });
  noteState();
}

start();
