// The beam as a three.js scene. It gets a design and a state and makes every vertex from them (geometry.js).
// It draws when something has changed, never on its own.
import { OrbitControls, THREE } from "nicegui-scene";
import {
  add, around, arrow, at, attitude, bar, contact, directions, faces, first, mul, own, plate, scales,
} from "./geometry.js"; // prettier-ignore

const MOST = 128; // scales that can be drawn
const LOOK = [-0.75, 0.72, -0.16]; // from where one looks
const [HEAD, SHAFT, DOT] = [0.13, 0.042, 0.07];

// turns around and over (rad) and zooms by key
const KEYS = {
  ArrowLeft: [-0.12, 0, 1], ArrowRight: [0.12, 0, 1], ArrowUp: [0, -0.1, 1], ArrowDown: [0, 0.1, 1],
  "+": [0, 0, 1.15], "=": [0, 0, 1.15], "-": [0, 0, 1 / 1.15],
}; // prettier-ignore

// Give meshes corners of their own, between the same points.
function shape(meshes, corners, points, paint) {
  meshes.forEach((mesh, i) => {
    mesh.geometry.dispose();
    mesh.geometry = new THREE.BufferGeometry();
    mesh.geometry.setIndex(corners[i]);
    mesh.geometry.setAttribute("position", new THREE.Float32BufferAttribute(points, 3));
    if (paint && !i) mesh.geometry.setAttribute("color", new THREE.Float32BufferAttribute(paint, 3));
  });
}

export class BeamScene {
  // palette: {states, themes}, the colours of the scales by their state and of the rest on a light and a dark page
  constructor(canvas, palette) {
    this.canvas = canvas;
    this.palette = palette;
    this.arrows = true;
    this.renderer = new THREE.WebGLRenderer({ canvas, antialias: true });
    this.scene = new THREE.Scene();
    this.camera = new THREE.PerspectiveCamera(32, 1, 0.1, 2000);
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.addEventListener("change", () => this.request());
    this.controls.addEventListener("start", () => (this.chosen = true));
    this.controls.addEventListener("end", () => this.look());
    this.scene.add(new THREE.AmbientLight(0xffffff, 1.5));
    const sun = new THREE.DirectionalLight(0xffffff, 2.1);
    this.camera.add(sun);
    sun.position.set(-1, 2, 2);
    this.scene.add(this.camera);
    this.make();
    this.theme("light");
  }

  // Everything that is drawn, made once; `set` only moves it.
  make() {
    const both = { side: THREE.DoubleSide, polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 1 };
    const solid = () => new THREE.MeshLambertMaterial();
    const many = (shape, material) => {
      const mesh = new THREE.InstancedMesh(shape, material, MOST);
      mesh.frustumCulled = false;
      this.scene.add(mesh);
      return mesh;
    };
    // what lies behind a scale is seen through it, pale
    const through = (shape, material) => {
      const mesh = many(shape, material);
      const pale = new THREE.MeshBasicMaterial({ transparent: true, opacity: 0.3, depthTest: false });
      mesh.pale = many(shape, pale);
      mesh.pale.instanceMatrix = mesh.instanceMatrix;
      mesh.pale.material.color = material.color;
      return mesh;
    };
    const faceted = (more) => new THREE.MeshLambertMaterial({ ...both, flatShading: true, ...more });
    this.scales = new THREE.Mesh(new THREE.BufferGeometry(), faceted({ vertexColors: true }));
    this.rims = new THREE.LineSegments(new THREE.BufferGeometry(), new THREE.LineBasicMaterial());
    this.bar = new THREE.Mesh(new THREE.BufferGeometry(), faceted());
    this.barEdges = new THREE.LineSegments(new THREE.BufferGeometry(), this.rims.material);
    for (const part of [this.scales, this.rims, this.bar, this.barEdges]) {
      part.frustumCulled = false;
      this.scene.add(part);
    }
    // few corners: without a graphics card these small parts are most of the work
    this.points = through(new THREE.SphereGeometry(DOT, 8, 6), solid());
    const shaft = new THREE.CylinderGeometry(1, 1, 1, 8, 1, true).translate(0, 0.5, 0);
    const head = new THREE.ConeGeometry(1, 1, 12).translate(0, 0.5, 0);
    this.forces = {};
    for (const name of ["normal", "friction"]) {
      const material = solid();
      this.forces[name] = [through(shaft, material), through(head, material)];
      // friction lies within the plates that rub, and is drawn over them
      material.depthTest = name === "normal";
      for (const mesh of this.forces[name]) mesh.renderOrder = Number(name === "friction");
    }
  }

  theme(name) {
    const colours = this.palette.themes[name];
    this.scene.background = new THREE.Color(colours.background);
    this.rims.material.color.set(colours.edge);
    this.bar.material.color.set(colours.bar);
    this.points.material.color.set(colours.point);
    for (const name of ["normal", "friction"]) this.forces[name][0].material.color.set(colours[name]);
    this.request();
  }

  // design: see geometry.js; state: {load, theta, slip, x, mu, name, pose, strains, bent}; a pose stands for
  // theta, strains for load; `other` in both is that of the other face's scales, `each` has the states of single scales
  set(design, state) {
    const shape = JSON.stringify([design.kind, design.scales, design.half]);
    const sizes = JSON.stringify([design.eta, design.beta, design.lam, design.held, design.bend]);
    this.design = design;
    this.state = state;
    this.faces = faces(design, state);
    this.moveBar();
    this.moveScales();
    this.moveContacts();
    // another beam is seen whole; changes of this one leave the place that was chosen as long as it stays in sight
    if (shape !== this.shape || (sizes !== this.sizes && !this.chosen)) this.reset();
    else if (this.whole && !this.sees(this.now())) this.frame(this.outline());
    [this.shape, this.sizes] = [shape, sizes];
    this.request();
  }

  moveBar() {
    const sections = bar(this.design, at(this.state));
    const [faces, edges] = [[0, 1, 2, 0, 2, 3], []];
    const last = 4 * (sections.length - 1);
    for (let i = 0; i < last; i += 4)
      for (let j = 0; j < 4; j++) {
        const [a, b] = [i + j, i + ((j + 1) % 4)];
        faces.push(a, a + 4, b + 4, a, b + 4, b);
        edges.push(a, a + 4);
      }
    faces.push(last, last + 2, last + 1, last, last + 3, last + 2);
    for (const end of [0, last]) for (let j = 0; j < 4; j++) edges.push(end + j, end + ((j + 1) % 4));
    shape([this.bar, this.barEdges], [faces, edges], sections.flat(2));
  }

  // Every scale as the body that it is, thick and bent, in the colour of its state.
  moveScales() {
    const plates = new Map();
    const [points, paint, faces, edges] = [[], [], [], []];
    for (const [d, state, { x, y, z, o }] of scales(this.faces)) {
      if (!plates.has(state)) plates.set(state, plate(d, state.bent));
      const [body, n] = [plates.get(state), points.length / 3];
      const colour = new THREE.Color(this.palette.states[state.name]).toArray();
      for (const [u, v, w] of body.points) {
        points.push(...add(add(o, mul(u, x)), add(mul(v, y), mul(w, z))));
        paint.push(...colour);
      }
      for (const [a, b, c, e] of body.faces) faces.push(n + a, n + b, n + c, n + a, n + c, n + e);
      for (const [a, b] of body.edges) edges.push(n + a, n + b);
    }
    shape([this.scales, this.rims], [faces, edges], points, paint);
  }

  // Contact points of every scale that has its neighbour, and the forces on it.
  moveContacts() {
    const matrix = new THREE.Matrix4();
    this.contacts = [];
    this.tips = [];
    for (const [d, whole] of this.faces) {
      for (let j = 0; j < d.scales - d.neighbour; j++) {
        const [state, beside] = [own(whole, j), own(whole, j + d.neighbour)];
        if (!(state.x > 0)) continue;
        const i = this.contacts.length;
        const k = first(d) + j;
        const { point } = contact(d, at(whole), attitude(state), k, state.bent, beside);
        this.contacts.push(point);
        this.points.setMatrixAt(i, matrix.makeTranslation(...point));
        const ways = directions(d, at(whole), attitude(state), state.slip, k, beside);
        const long = arrow(state.x);
        for (const [name, size] of [["normal", long], ["friction", long * state.mu]]) {
          this.place(this.forces[name], i, point, ways[name], size);
          this.tips.push(point.map((x, axis) => x + size * ways[name][axis]));
        }
      }
    }
    const count = this.contacts.length;
    const drawn = this.arrows ? count : 0;
    const friction = this.state.mu ? drawn : 0;
    const counts = [[[this.points], count], [this.forces.normal, drawn], [this.forces.friction, friction]];
    for (const [meshes, n] of counts)
      for (const mesh of meshes) {
        mesh.count = mesh.pale.count = n;
        mesh.instanceMatrix.needsUpdate = true;
      }
  }

  place([shaft, head], i, from, way, long) {
    const tip = Math.min(2.6 * HEAD, long / 2);
    const turn = new THREE.Quaternion().setFromUnitVectors(new THREE.Vector3(0, 1, 0), new THREE.Vector3(...way));
    const part = (along, thick, size) =>
      new THREE.Matrix4().compose(
        new THREE.Vector3(...from).addScaledVector(new THREE.Vector3(...way), along),
        turn,
        new THREE.Vector3(thick, size, thick),
      );
    shaft.setMatrixAt(i, part(0, SHAFT, Math.max(long - tip, 1e-6)));
    head.setMatrixAt(i, part(long - tip, Math.max(tip / 2.6, 1.6 * SHAFT), tip));
  }

  // Points around all that is drawn, and around the beam before it was loaded.
  now() {
    return [...around(this.faces), ...this.tips];
  }

  outline() {
    return [...around(this.faces, 0), ...this.now()];
  }

  // Whether points are in the picture.
  sees(points) {
    this.camera.updateMatrixWorld();
    return points.every((p) => {
      const { x, y } = new THREE.Vector3(...p).project(this.camera);
      return Math.abs(x) <= 1 && Math.abs(y) <= 1;
    });
  }

  // Who comes near to a part, or moves aside, goes on seeing that; who only turns sees the whole again at a change.
  look() {
    const near = this.camera.position.distanceTo(this.controls.target) < 0.999 * this.away;
    const aside = this.controls.target.distanceTo(this.middle) > 0.001 * this.away;
    this.whole = !(near || aside) || this.sees(this.now());
  }

  // From where the whole beam is seen, straight and as it is.
  reset() {
    if (!this.design) return;
    this.chosen = false;
    this.frame(this.outline());
  }

  // See the whole of pictures {design, state} that are about to come.
  film(pictures) {
    const every = pictures.flatMap(({ design, state }) => around(faces(design, state)));
    if (this.whole && !this.sees(every)) this.frame(this.outline().concat(every));
  }

  // See all points as near as can be, from the side that was chosen.
  frame(points) {
    const box = new THREE.Box3().setFromPoints(points.map((p) => new THREE.Vector3(...p)));
    const middle = box.getCenter(new THREE.Vector3());
    const here = this.camera.position.clone().sub(this.controls.target);
    const back = (this.chosen ? here : new THREE.Vector3(...LOOK)).normalize();
    const right = new THREE.Vector3(0, 1, 0).cross(back).normalize();
    const up = back.clone().cross(right);
    const slope = Math.tan((this.camera.fov * Math.PI) / 360);
    let away = 0;
    for (const point of points) {
      const q = new THREE.Vector3(...point).sub(middle);
      const needed = Math.max(Math.abs(q.dot(right)) / this.camera.aspect, Math.abs(q.dot(up)));
      away = Math.max(away, q.dot(back) + needed / slope);
    }
    away *= 1.1;
    this.controls.target.copy(middle);
    this.camera.position.copy(middle).addScaledVector(back, away);
    this.camera.far = 20 * away;
    this.camera.updateProjectionMatrix();
    this.controls.update();
    Object.assign(this, { middle, away, whole: true });
    this.request();
  }

  // Turn by angles (rad) and come nearer by a factor, for the keyboard.
  orbit(around, over, nearer) {
    this.chosen = true;
    const offset = this.camera.position.clone().sub(this.controls.target);
    const ball = new THREE.Spherical().setFromVector3(offset);
    ball.theta += around;
    ball.phi = Math.min(Math.PI - 0.05, Math.max(0.05, ball.phi + over));
    ball.radius /= nearer;
    this.camera.position.copy(this.controls.target).add(offset.setFromSpherical(ball));
    this.controls.update();
    this.look();
    this.request();
  }

  // Do what a key stands for; say whether it stands for something.
  key(name) {
    if (name === "Home") this.reset();
    else if (name in KEYS) this.orbit(...KEYS[name]);
    else return false;
    return true;
  }

  resize(width, height) {
    if (!width || !height) return;
    this.renderer.setPixelRatio(Math.min(2, window.devicePixelRatio || 1));
    this.renderer.setSize(width, height, false);
    const before = this.camera.aspect;
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    if (Math.abs(before - this.camera.aspect) > 0.01 && !this.chosen) this.reset();
    else if (this.design && this.whole && !this.sees(this.now())) this.frame(this.outline());
    this.request();
  }

  request() {
    if (this.waiting || this.gone) return;
    this.waiting = requestAnimationFrame(() => this.draw());
  }

  draw() {
    this.waiting = null;
    this.renderer.render(this.scene, this.camera);
    this.onDraw?.(this); // for who measures
  }

  // The view as a picture of this size, as the address of its data: the whole beam, or what is seen of it.
  picture(width, height) {
    const { camera, controls, renderer } = this;
    const [size, ratio] = [renderer.getSize(new THREE.Vector2()), renderer.getPixelRatio()];
    const [eye, target, { aspect, fov }] = [camera.position.clone(), controls.target.clone(), camera];
    const [middle, away, whole] = [this.middle, this.away, this.whole];
    renderer.setPixelRatio(1);
    renderer.setSize(width, height, false);
    camera.aspect = width / height;
    if (whole) this.frame(this.outline());
    // no less to the sides than there was
    else camera.fov = (360 / Math.PI) * Math.atan(Math.tan((fov * Math.PI) / 360) * Math.max(1, aspect / camera.aspect));
    camera.updateProjectionMatrix();
    this.draw();
    const made = this.canvas.toDataURL("image/png");
    renderer.setPixelRatio(ratio);
    renderer.setSize(size.x, size.y, false);
    Object.assign(camera, { aspect, fov });
    camera.position.copy(eye);
    controls.target.copy(target);
    camera.updateProjectionMatrix();
    controls.update();
    Object.assign(this, { middle, away, whole });
    this.draw();
    return made;
  }

  dispose() {
    this.gone = true;
    this.controls.dispose();
    this.renderer.dispose();
  }
}
