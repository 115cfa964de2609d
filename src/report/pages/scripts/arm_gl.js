// The same primitives by three.js, where the page has it and the browser has WebGL.

async function libraryOf(id) {
  const packed = byId(id);
  if (!packed || typeof DecompressionStream === 'undefined') return false;
  if (window.THREE) return true;
  const bytes = Uint8Array.from(atob(packed.textContent.trim()), (c) => c.charCodeAt(0));
  const text = await new Response(new Blob([bytes]).stream().pipeThrough(new DecompressionStream('gzip'))).text();
  document.head.append(element('script', {}, text));
  return Boolean(window.THREE);
}

function hasWebGl() {
  try {
    // Where it is made of software, the vector graphics are faster; #webgl takes it all the same.
    const gl = document.createElement('canvas').getContext('webgl', {failIfMajorPerformanceCaveat: location.hash !== '#webgl'});
    if (!gl) return false;
    gl.getExtension('WEBGL_lose_context')?.loseContext();
    return true;
  } catch (fault) {
    return false;
  }
}

/** A stage like svgStage(), or nothing where there is no WebGL. */
async function webGlStage(box, held) {
  if (!hasWebGl() || !await libraryOf('three')) return null;
  const renderer = new THREE.WebGLRenderer({antialias: true, alpha: true, preserveDrawingBuffer: location.hash === '#webgl'});
  const scene = new THREE.Scene();
  const eye = new THREE.PerspectiveCamera(30, 10 / 7, 0.02 * box.reach, 40 * box.reach);
  eye.up.set(0, 0, 1);
  const sun = new THREE.DirectionalLight(0xffffff, 0.75);
  sun.position.set(-1, -2, 3);
  scene.add(new THREE.HemisphereLight(0xffffff, 0x8a8a92, 0.62), sun);
  const tube = new THREE.CylinderBufferGeometry(1, 1, 1, 28, 1, true).rotateX(Math.PI / 2);
  const ball = new THREE.SphereBufferGeometry(1, 24, 16);
  const cone = new THREE.ConeBufferGeometry(1, 2.4, 20).rotateX(Math.PI / 2);
  const vector = (p) => new THREE.Vector3(p[0], p[1], p[2]);
  const surfaceOf = (mesh) => {
    if (mesh.surface) return mesh.surface;
    const flat = new THREE.BufferGeometry();
    flat.setAttribute('position', new THREE.Float32BufferAttribute(mesh.corners.flatMap((k) => pointsOf(mesh)[Math.round(k)]), 3));
    flat.computeVertexNormals();
    return mesh.surface = flat;
  };
  const pool = new Map();  // by kind and place among its kind
  const used = new Set();
  const take = (name, make) => {
    if (!pool.has(name)) {
      pool.set(name, make());
      scene.add(pool.get(name));
    }
    used.add(name);
    pool.get(name).visible = true;
    return pool.get(name);
  };
  const solid = (name, geometry, hex) => {
    const mesh = take(name, () => new THREE.Mesh(geometry, new THREE.MeshPhongMaterial({shininess: 40, specular: 0x333333, side: THREE.DoubleSide})));
    mesh.material.color.set(hex);
    return mesh;
  };
  const place = (name, part, hex) => {
    if (part.kind === 'capsule') {
      const [a, b] = [vector(part.a), vector(part.b)];
      const rod = solid(name + 'rod', tube, hex);
      rod.position.copy(a).add(b).multiplyScalar(0.5);
      rod.scale.set(part.r, part.r, Math.max(1e-9, a.distanceTo(b)));
      if (a.distanceTo(b) > 1e-9) rod.lookAt(b);
      [a, b].forEach((p, k) => {
        const end = solid(name + 'end' + k, ball, hex);
        end.position.copy(p);
        end.scale.setScalar(part.r);
      });
    } else if (part.kind === 'arrow') {
      const [a, b] = [vector(part.a), vector(part.b)];
      const r = 0.008 * box.reach;
      place(name + 'shaft', {kind: 'capsule', a: part.a, b: part.b, r}, hex);
      const head = solid(name + 'head', cone, hex);
      head.position.copy(b);
      head.scale.setScalar(2.6 * r);
      if (a.distanceTo(b) > 1e-9) head.lookAt(b.clone().add(b.clone().sub(a)));
    } else if (part.kind === 'mesh') {
      const one = solid(name, surfaceOf(part.mesh), hex);
      const T = part.T;
      one.matrixAutoUpdate = false;
      one.matrix.set(T[0], T[1], T[2], T[3], T[4], T[5], T[6], T[7], T[8], T[9], T[10], T[11], 0, 0, 0, 1);
    } else if (part.kind === 'line' || part.kind === 'points') {
      const dots = part.kind === 'points';
      const one = take(name, () => dots ? new THREE.Points(new THREE.BufferGeometry(), new THREE.PointsMaterial({size: part.width || 3, sizeAttenuation: false})) :
                                          new THREE.Line(new THREE.BufferGeometry(), new THREE.LineBasicMaterial()));
      one.geometry.setFromPoints(part.points.map(vector));
      one.frustumCulled = false;
      one.material.color.set(hex);
    }
  };
  return {
    node: renderer.domElement,
    draw(parts, view) {
      const width = Math.max(100, held.clientWidth || 600), height = width * 0.7;
      renderer.setPixelRatio(Math.min(2, window.devicePixelRatio || 1));
      renderer.setSize(width, height);
      renderer.domElement.className = 'stage';
      const distance = 3.7 * box.reach / view.zoom;
      const [cp, sp] = [Math.cos(view.pitch), Math.sin(view.pitch)];
      eye.position.set(box.middle[0] + distance * cp * Math.sin(view.yaw), box.middle[1] - distance * cp * Math.cos(view.yaw), box.middle[2] + distance * sp);
      eye.lookAt(vector(box.middle));
      for (const one of pool.values()) one.visible = false;
      used.clear();
      parts.forEach((part, k) => part.colour && place(part.kind + k, part, paint(part.colour)));
      renderer.render(scene, eye);
    }
  };
}
