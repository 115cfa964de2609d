// Arms in space, moving: capsules between the origins of frames, drawn as vector graphics at once
// and by WebGL where the browser has it. One slider moves the arm and the mark in all time plots.

// ---- rigid motions as rows [r11 r12 r13 x  r21 r22 r23 y  r31 r32 r33 z]


function times(a, b) {
  const out = [];
  for (let r = 0; r < 12; r += 4) {
    for (let c = 0; c < 4; ++c) out.push(a[r] * b[c] + a[r + 1] * b[4 + c] + a[r + 2] * b[8 + c] + (c === 3 ? a[r + 3] : 0));
  }
  return out;
}

const origin = (T) => [T[3], T[7], T[11]];
const along = (T, p) => [0, 4, 8].map((r) => T[r] * p[0] + T[r + 1] * p[1] + T[r + 2] * p[2] + T[r + 3]);
const minus = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
const plus = (a, b, scale) => [a[0] + scale * b[0], a[1] + scale * b[1], a[2] + scale * b[2]];
const lengthOf = (a) => Math.hypot(a[0], a[1], a[2]);

/** Poses of all frames, and of their joints, with the joint variables s = c . q + s0. */
function posesOf(arm, q) {
  const poses = [];
  const joints = [];
  arm.frames.forEach((frame, k) => {
    const s = frame.c.reduce((sum, [i, share]) => sum + share * (q[i] || 0), frame.s0);
    const [c, n] = [Math.cos(s), Math.sin(s)];
    const J = frame.kind === 'revolute' ? [c, -n, 0, 0, n, c, 0, 0, 0, 0, 1, 0] : [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, frame.kind === 'prismatic' ? s : 0];
    joints[k] = times(frame.parent < 0 ? arm.base : poses[frame.parent], frame.A);
    poses[k] = times(times(joints[k], J), frame.B);
  });
  return {poses, joints};
}

// ---- an arm as primitives {kind, a, b, r, colour}

const kThick = 0.03;  // radius of the first link, as a share of the arm's reach

function reachOf(arm) {
  const {poses} = posesOf(arm, arm.middle);
  let reach = 0;
  for (const T of poses) reach = Math.max(reach, lengthOf(minus(origin(T), origin(arm.base))));
  const links = poses.map((T, k) => arm.frames[k].parent < 0 ? 0 : lengthOf(minus(origin(T), origin(poses[arm.frames[k].parent]))));
  return Math.max(reach, 0.5 * links.reduce((a, b) => a + b, 0), 1e-3);
}

for (const arm of series.arms || []) arm.reach = reachOf(arm);

function depthOf(arm, k) {
  return arm.frames[k].parent < 0 ? 0 : depthOf(arm, arm.frames[k].parent) + (arm.frames[k].kind === 'fixed' ? 0 : 1);
}

// The joint (from 0) that moves a frame, of several the nearest one; -1: none.
function moverOf(arm, k) {
  for (; k >= 0; k = arm.frames[k].parent) {
    const c = arm.frames[k].c;
    if (c.length) return c.reduce((a, b) => Math.abs(b[1]) > Math.abs(a[1]) ? b : a)[0];
  }
  return -1;
}

/** @param tint  colour of the link that a joint (from 0) moves, or nothing */
function armParts(arm, q, tint, look) {
  const {poses, joints} = posesOf(arm, q);
  const out = [];
  const meshes = arm.meshes || [];
  for (const mesh of meshes) {
    const own = moverOf(arm, mesh.frame);
    const T = poses[mesh.frame];
    out.push({kind: 'mesh', mesh, T, a: origin(T), b: along(T, [0, 0, 1]), colour: (own >= 0 && tint && tint(own)) || (look && look.colour) || mesh.colour || 'link'});
  }
  arm.frames.forEach((frame, k) => {
    const from = frame.parent < 0 ? origin(arm.base) : origin(poses[frame.parent]);
    const r = arm.reach * kThick * Math.max(0.4, 1 - 0.09 * depthOf(arm, k));
    const own = frame.c.length ? frame.c.reduce((a, b) => Math.abs(b[1]) > Math.abs(a[1]) ? b : a)[0] : -1;
    const shade = (own >= 0 && tint && tint(own)) || (look && look.colour) || 'link';
    const at = origin(joints[k]);
    const add = (a, b, radius, colour) => lengthOf(minus(a, b)) > 0.15 * r ? out.push({kind: 'capsule', a, b, r: radius, colour}) : 0;
    // Surfaces of a file stand in for the rods.
    if (!meshes.length) {
    if (frame.parent >= 0 || !arm.mounted) add(from, at, r, (look && look.colour) || 'link');
    add(at, origin(poses[k]), frame.kind === 'prismatic' ? 0.7 * r : r, shade);
    if (frame.kind === 'revolute') {
      const z = [joints[k][2], joints[k][6], joints[k][10]];
      out.push({kind: 'capsule', a: plus(at, z, -1.1 * r), b: plus(at, z, 1.1 * r), r: 1.25 * r, colour: shade === 'link' ? 'hub' : shade});
    }
    }
    if (look && look.axes && frame.named !== false) {
      ['model', 'forward', 'extended'].forEach((colour, c) => out.push(
          {kind: 'line', points: [origin(poses[k]), plus(origin(poses[k]), [poses[k][c], poses[k][4 + c], poses[k][8 + c]], 0.11 * arm.reach)], colour, width: 2}));
      out.push({kind: 'label', a: origin(poses[k]), text: frame.name});
    }
  });
  return out;
}

function tipOf(arm, q) {
  const {poses} = posesOf(arm, q);
  return poses.length ? origin(poses[arm.tip]) : origin(arm.base);
}

/** Light grid under everything. */
function floorParts(box) {
  const size = Math.max(box.reach, 1e-3);
  const step = [1, 2, 5].map((m) => m * Math.pow(10, Math.floor(Math.log10(size / 4)))).reverse().find((s) => s <= size / 3) || size / 4;
  const middle = [0, 1].map((c) => Math.round(box.middle[c] / step) * step);
  const out = [];
  for (let k = -5; k <= 5; ++k) {
    for (const c of [0, 1]) {
      const a = [0, 0, box.floor], b = [0, 0, box.floor];
      a[c] = b[c] = middle[c] + k * step;
      a[1 - c] = middle[1 - c] - 5 * step;
      b[1 - c] = middle[1 - c] + 5 * step;
      out.push({kind: 'line', points: [a, b], colour: 'line', width: 0.8, back: true});
    }
  }
  return out;
}

// ---- the vector renderer

function mixed(a, b, share) {
  const of = (hex) => [1, 3, 5].map((at) => parseInt(hex.slice(at, at + 2), 16));
  const [x, y] = [of(a), of(b)];
  return '#' + x.map((v, k) => Math.round(v + share * (y[k] - v)).toString(16).padStart(2, '0')).join('');
}

function paint(name) {
  return name[0] === '#' ? name : colour(name);
}

function camera(view, box, width, height) {
  const [cy, sy, cp, sp] = [Math.cos(view.yaw), Math.sin(view.yaw), Math.cos(view.pitch), Math.sin(view.pitch)];
  const distance = 3.7 * box.reach;
  const focal = 1.35 * Math.min(width, 1.35 * height) * view.zoom;
  return (p) => {
    const [x, y, z] = minus(p, box.middle);
    const across = cy * x + sy * y;
    const away = -sy * x + cy * y;
    const depth = distance + cp * away - sp * z;
    const f = focal / Math.max(depth, 0.1 * box.reach);
    return [width / 2 + f * across, height / 2 - f * (cp * z + sp * away), depth, f];
  };
}

/** Corners of a mesh, [x, y, z] each. */
function pointsOf(mesh) {
  if (!mesh.points) mesh.points = mesh.x.map((x, k) => [x, mesh.y[k], mesh.z[k]]);
  return mesh.points;
}

/** Convex outline of points [x, y, ...] in a plane, by Andrew's monotone chain (1979). */
function hullOf(points) {
  const sorted = points.slice().sort((a, b) => a[0] - b[0] || a[1] - b[1]);
  const half = (list) => {
    const out = [];
    for (const p of list) {
      while (out.length > 1) {
        const [a, b] = out.slice(-2);
        if ((b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0]) > 0) break;
        out.pop();
      }
      out.push(p);
    }
    return out.slice(0, -1);
  };
  return half(sorted).concat(half(sorted.reverse()));
}

function svgStage(box) {
  const svg = drawing('svg', {class: 'stage', role: 'img', viewBox: '0 0 600 420'});
  const shapes = (part, project) => {
    const points = (part.points || [part.a, part.b || part.a]).map(project);
    const depth = points.reduce((sum, p) => sum + p[2], 0) / points.length;
    const at = (p) => p[0].toFixed(1) + ' ' + p[1].toFixed(1);
    const line = (width, colour, shift) => drawing('path', {
      d: 'M' + points.map((p) => (p[0] + (shift || 0)).toFixed(1) + ' ' + (p[1] + 1.2 * (shift || 0)).toFixed(1)).join('L') + (points.length === 2 && at(points[0]) === at(points[1]) ? 'h0' : ''),
      fill: 'none', stroke: colour, 'stroke-width': width.toFixed(2), 'stroke-linecap': 'round', 'stroke-linejoin': 'round'});
    const hex = part.colour ? paint(part.colour) : '';
    if (part.kind === 'capsule') {
      const w = 2 * part.r * (points[0][3] + points[1][3]) / 2;
      return {depth, nodes: [line(w, mixed(hex, '#000000', 0.38)), line(0.8 * w, hex, -0.03 * w), line(0.24 * w, mixed(hex, '#ffffff', 0.5), -0.15 * w)]};
    }
    if (part.kind === 'mesh') {
      const outline = hullOf(pointsOf(part.mesh).map((p) => project(along(part.T, p))));
      const middle = outline.reduce((sum, p) => sum + p[2] / outline.length, 0);
      return {depth: middle, nodes: [drawing('path', {d: 'M' + outline.map(at).join('L') + 'Z', fill: hex, stroke: mixed(hex, '#000000', 0.38), 'stroke-width': 1.2, 'stroke-linejoin': 'round'})]};
    }
    if (part.kind === 'label') return {depth: -1, nodes: [drawing('text', {x: points[0][0] + 7, y: points[0][1] - 7, class: 'tick'}, part.text)]};
    if (part.kind === 'arrow') {
      const [a, b] = points;
      const angle = Math.atan2(b[1] - a[1], b[0] - a[0]);
      const head = [2.6, -2.6].map((turn) => (b[0] + 9 * Math.cos(angle + turn)).toFixed(1) + ' ' + (b[1] + 9 * Math.sin(angle + turn)).toFixed(1));
      return {depth: -0.5, nodes: [line(3, hex), drawing('path', {d: 'M' + head[0] + 'L' + at(b) + 'L' + head[1], fill: 'none', stroke: hex, 'stroke-width': 3, 'stroke-linecap': 'round'})]};
    }
    if (part.kind === 'points')
      return {depth: 1e6, nodes: [drawing('path', {d: points.map((p) => 'M' + at(p) + 'h0').join(''), stroke: hex, 'stroke-width': part.width || 3, 'stroke-linecap': 'round', 'stroke-opacity': 0.7})]};
    return {depth: part.back ? 1e9 : depth, nodes: [line(part.width || 1.4, hex)]};
  };
  return {
    node: svg,
    draw(parts, view) {
      const width = 600, height = 420;
      const project = camera(view, box, width, height);
      const drawn = parts.map((part) => shapes(part, project)).sort((a, b) => b.depth - a.depth);
      svg.replaceChildren(...drawn.flatMap((one) => one.nodes));
    }
  };
}

// ---- a stage with a slider

const kFrames = 15;      // [ms] between drawings, at least
const kTrail = 400;      // points of the tip's path
let playing = null;

function boxOf(points) {
  const ranges = [0, 1, 2].map((c) => [Math.min(...points.map((p) => p[c])), Math.max(...points.map((p) => p[c]))]);
  const middle = ranges.map(([a, b]) => (a + b) / 2);
  const reach = Math.max(1e-6, ...points.map((p) => lengthOf(minus(p, middle))));
  return {middle, reach, floor: ranges[2][0] - 0.03 * reach};
}

/**
 * @param scene  {title, name, time, parts(t): primitives, points: what must be in view, keys, still}
 */
function stage(scene) {
  const box = boxOf(scene.points);
  const view = {yaw: -0.7, pitch: 0.38, zoom: 1};
  let at = scene.time.length ? scene.time[0] : 0;
  let renderer = svgStage(box);
  const [from, to] = [scene.time[0] || 0, scene.time[scene.time.length - 1] || 0];
  const moves = to > from;
  const clock = element('output', {class: 'clock'});
  const slider = element('input', {type: 'range', class: 'scrubber', min: from, max: to, step: (to - from) / 1000 || 1, value: from, 'aria-label': scene.clock ? 'Posture' : 'Time'});
  const held = element('div', {class: 'held'}, renderer.node);
  const figure = element('figure', {class: 'plot arm', 'data-plot': 'arm', 'data-joint': 0});
  const draw = () => {
    const parts = (scene.still ? [] : floorParts(box)).concat(scene.parts(at));
    renderer.draw(parts, view);
    renderer.node.setAttribute('aria-label', scene.title);
    clock.textContent = scene.clock ? scene.clock(at) : moves ? at.toFixed(2) + ' s' : '';
    figure.dataset.points = 'parts:' + parts.filter((p) => p.kind !== 'label').length;
    figure.dataset.moment = at.toFixed(3);
    figure.dataset.pose = parts.filter((p) => p.kind === 'capsule' || p.kind === 'mesh').map((p) => p.b.map((v) => v.toFixed(3)).join(',')).join(' ');
  };
  const show = (t) => {
    at = Math.min(to, Math.max(from, t));
    slider.value = at;
    draw();
  };
  const seek = (t) => {
    show(t);
    for (const other of arms) if (other.show !== show && !other.own) other.show(t);
    if (!scene.own) showMoment(at);
  };
  slider.addEventListener('input', () => {
    stop();
    seek(Number(slider.value));
  });
  const play = button('\u25b6', () => playing === figure ? stop() : run(), 'Play');
  const stop = () => {
    playing = null;
    play.textContent = '\u25b6';
  };
  const run = () => {
    playing = figure;
    play.textContent = '\u275a\u275a';
    if (at >= to) at = from;
    let last = performance.now();
    let frames = 0;
    const begun = last;
    const step = (now) => {
      if (playing !== figure) return stop();
      if (now - last >= kFrames) {
        seek(at + (now - last) / 1000);
        last = now;
        figure.dataset.rate = (++frames / Math.max(1e-3, (now - begun) / 1000)).toFixed(1);
      }
      if (at >= to) return stop();
      requestAnimationFrame(step);
    };
    requestAnimationFrame(step);
  };
  let drag = null;
  held.addEventListener('pointerdown', (event) => {
    drag = [event.clientX, event.clientY];
    held.setPointerCapture(event.pointerId);
  });
  held.addEventListener('pointermove', (event) => {
    if (!drag) return;
    view.yaw -= 0.01 * (event.clientX - drag[0]);
    view.pitch = Math.min(1.5, Math.max(-1.5, view.pitch + 0.01 * (event.clientY - drag[1])));
    drag = [event.clientX, event.clientY];
    draw();
  });
  held.addEventListener('pointerup', () => drag = null);
  held.addEventListener('pointercancel', () => drag = null);
  const zoom = (factor) => () => {
    view.zoom *= factor;
    draw();
  };
  const svgOf = () => {
    const copy = svgStage(box);
    copy.draw((scene.still ? [] : floorParts(box)).concat(scene.parts(at)), view);
    return svgFile(copy.node);
  };
  fill(figure, {}, [
    element('figcaption', {}, scene.title, element('span', {class: 'tools'}, button('+', zoom(1.2), 'Nearer'), button('\u2212', zoom(1 / 1.2), 'Farther'),
                                                   button('SVG', () => saveAs('arm.svg', 'image/svg+xml', svgOf()), 'Save the arm as SVG'))),
    scene.keys && scene.keys.length ? paragraph('keys', scene.keys) : null, held,
    moves ? element('div', {class: 'player'}, play, slider, clock) : null, scene.controls ? scene.controls(draw) : null]);
  arms.push({show, resize: draw, own: scene.own, choose: (recording) => scene.choose && (scene.choose(recording), show(0))});
  redraws.push(draw);
  // The drawing is there at once; who touches it gets solid bodies, where the browser has WebGL.
  const solid = () => webGlStage(box, held).then((better) => {
    if (!better) return;
    renderer = better;
    held.replaceChildren(better.node);
    document.documentElement.dataset.webgl = '1';
    draw();
  });
  if (location.hash === '#webgl') redraws.push(solid); else figure.addEventListener('pointerenter', solid, {once: true});
  return figure;
}

/** The row of a recording at a time. */
function rowAt(time, t) {
  let low = 0, high = time.length - 1;
  while (high - low > 1) {
    const k = (low + high) >> 1;
    if (time[k] <= t) low = k; else high = k;
  }
  return Math.abs(time[low] - t) <= Math.abs(time[high] - t) ? low : high;
}

const jointsAt = (columns, k) => columns.map((column) => column[k] || 0);

const kSamples = 9;  // postures that a view must hold

function samplesOf(arm, columns) {
  const last = columns[0].length - 1;
  return Array.from({length: kSamples}, (_, k) => {
    const {poses} = posesOf(arm, jointsAt(columns, Math.round(k * last / (kSamples - 1))));
    return poses.map(origin).concat((arm.meshes || []).flatMap((m) => extremesOf(m).map((p) => along(poses[m.frame], p))));
  }).flat();
}

/** The corners of the box around a mesh. */
function extremesOf(mesh) {
  const [low, high] = [Math.min, Math.max].map((f) => [mesh.x, mesh.y, mesh.z].map((c) => c.reduce((a, b) => f(a, b))));
  return [0, 1, 2, 3, 4, 5, 6, 7].map((k) => [0, 1, 2].map((axis) => (k >> axis & 1 ? high : low)[axis]));
}

/** The arm of a recording, or nothing. @param kind  "diagnose": links in the colour of what the model leaves of their joint */
function armView(kind) {
  const first = series.recordings.find((r) => r.time.length && (r.q || r.joints));
  const list = series.arms || [];
  if (!first || !list.length || !list[0].frames.length) return null;
  const arm = list[0];
  const columnsOf = (r) => r.q || r.joints.map((j) => j.q);
  let recording = first, columns = columnsOf(first), trail = [], worst = [];
  const scene = {
    title: 'The arm' + (first.source ? ', ' + fileName(first.source) : ''), time: first.time, points: [], keys: [],
    choose(r) {
      recording = r;
      columns = columnsOf(r);
      const step = Math.max(1, Math.floor(r.time.length / kTrail));
      trail = r.time.map((_, k) => k).filter((k) => k % step === 0).map((k) => tipOf(arm, jointsAt(columns, k)));
      worst = kind === 'diagnose' && r.joints[0].measured ? r.joints.map((j) => Math.max(1e-12, ...residualOf(j, 'model').filter(isNumber).map(Math.abs))) : [];
    },
    parts(t) {
      const k = rowAt(recording.time, t);
      const tint = worst.length ? (i) => {
        const joint = recording.joints[i];
        const left = joint && isNumber(joint.model[k]) && isNumber(joint.measured[k]) ? Math.abs(joint.measured[k] - joint.model[k]) / worst[i] : 0;
        return mixed(colour('link'), colour('bad'), Math.min(1, 1.3 * left));
      } : null;
      return [{kind: 'line', points: trail.length > 1 ? trail : [trail[0], trail[0]], colour: 'pale-extended', width: 1.6}].concat(armParts(arm, jointsAt(columns, k), tint));
    }
  };
  scene.choose(first);
  scene.points = trail.concat([origin(arm.base)], samplesOf(arm, columns));
  if (worst.length) scene.keys = [key('link', 'link'), key('the model leaves most of the joint\u2019s torque', 'bad')];
  return stage(scene);
}
