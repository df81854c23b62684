// The beam in space: bar, scales, contact points and forces, in pitches; geometry.py states the same.
// Axes: z along the beam, y out of the scaled face. The middle of the beam stays where it is.
// A design: {kind, held, eta, beta, lam, height, alpha, half, thick, sense, bend, law, neighbour, scales, S, shift}, ratios
// and radians. S maps the scaled face's places to those of its face. Loads are angles per pitch, or all strains per
// pitch: bend, twist, lateral bend and stretch; of a beam with ends the strains of each cell, in the middle of which its
// scale stands.

export const STEPS = 6; // pieces of the bar per pitch
export const PIECES = [6, 2]; // of a bent plate along its length and across it
export const LONGEST = 2.6; // length that an arrow comes near to as its force grows, in pitches

export const add = (u, v) => [u[0] + v[0], u[1] + v[1], u[2] + v[2]];
export const sub = (u, v) => [u[0] - v[0], u[1] - v[1], u[2] - v[2]];
export const mul = (c, v) => [c * v[0], c * v[1], c * v[2]];
export const dot = (u, v) => u[0] * v[0] + u[1] * v[1] + u[2] * v[2];
export const cross = (u, v) => [
  u[1] * v[2] - u[2] * v[1],
  u[2] * v[0] - u[0] * v[2],
  u[0] * v[1] - u[1] * v[0],
];
const unit = (v) => {
  const size = Math.hypot(...v);
  return size ? mul(1 / size, v) : v;
};

// All strains per pitch; of a load angle the stretch is that of the line that keeps its length.
function strains(d, load) {
  if (Array.isArray(load)) return load;
  const [psi, phi] = d.kind === "twisting" ? [d.held ?? 0, d.sense * load] : [d.bend * load, 0];
  return [psi, phi, 0, psi * (d.lam - d.height)];
}

// How the cross-sections of a state stand, and how a scale does.
export const at = (state) => state.strains ?? state.load;
export const attitude = (state) => state.pose ?? state.theta;

// State of the scale number i: all are alike, or each has its own.
export const own = (state, i) => (state.each ? state.each[i] : state);

// Axes and shift of a cross-section over k pitches of one cell's strains.
function screw([psi, phi, chi, eps], k) {
  const w = [-k * psi, -k * chi, -k * phi];
  const q = dot(w, w);
  const r = Math.sqrt(q);
  // sin(r) / r, (1 - cos(r)) / r^2, (r - sin(r)) / r^3
  const [a, b, c] =
    q < 1e-4
      ? [1 - (q / 6) * (1 - (q / 20) * (1 - q / 42)), 0.5 - (q / 24) * (1 - (q / 30) * (1 - q / 56)),
         1 / 6 - (q / 120) * (1 - (q / 42) * (1 - q / 72))]
      : [Math.sin(r) / r, (1 - Math.cos(r)) / q, (r - Math.sin(r)) / (q * r)]; // prettier-ignore
  const moved = (u, f, g) => {
    const once = cross(w, u);
    return add(u, add(mul(f, once), mul(g, cross(w, once))));
  };
  const [x, y, z] = [[1, 0, 0], [0, 1, 0], [0, 0, 1]].map((u) => moved(u, a, b));
  return { x, y, z, shift: moved([0, 0, k * (1 + eps)], b, c) };
}

const turned = (f, v) => add(add(mul(v[0], f.x), mul(v[1], f.y)), mul(v[2], f.z));
const onward = (f, by) => ({
  x: turned(f, by.x),
  y: turned(f, by.y),
  z: turned(f, by.z),
  shift: add(f.shift, turned(f, by.shift)),
});

// Sections between cells, from the middle of the beam, or from the section that does not move.
const known = new WeakMap();
function sections(cells, still) {
  if (known.has(cells)) return known.get(cells);
  const [n, out] = [cells.length, []];
  for (const way of [1, -1]) {
    let [f, place] = [{ x: [1, 0, 0], y: [0, 1, 0], z: [0, 0, 1], shift: [0, 0, still] }, n / 2 + still];
    out[place] = f;
    while (way > 0 ? place < n : place > 0) {
      const cell = way > 0 ? Math.floor(place) : Math.ceil(place) - 1;
      const end = way > 0 ? cell + 1 : cell;
      f = onward(f, screw(cells[cell], end - place));
      place = end;
      out[place] = f;
    }
  }
  known.set(cells, out);
  return out;
}

// The cross-section k pitches from the middle of the beam: axes, and o, the middle of its scaled edge. It is moved by k
// times the screw of its strains.
export function frame(d, load, k) {
  let f;
  if (Array.isArray(load?.[0])) {
    const place = k + load.length / 2;
    const cell = Math.min(Math.max(Math.floor(place), 0), load.length - 1);
    f = onward(sections(load, d.still ?? 0)[cell], screw(load[cell], place - cell));
  } else f = screw(strains(d, load), k);
  return { o: add(mul(d.lam, f.y), f.shift), x: f.x, y: f.y, z: f.z };
}

// Place of the base, n_X and n_Y of a scale on a hinge, in the axes of its cross-section.
function hinged(d, theta) {
  const [ca, sa, ct, st] = [Math.cos(d.alpha), Math.sin(d.alpha), Math.cos(theta), Math.sin(theta)];
  return [[0, 0, 0], [-sa * ct, st, ca * ct], [ca, 0, sa]];
}

const det = (d) => d.S[0] * d.S[1] * d.S[2];
const mapped = (d, v) => v.map((x, i) => d.S[i] * x);

function placed(d, o, x, y) {
  const m = add(o, mul(d.eta, x));
  const half = mul(d.beta, y);
  const corners = [sub(o, half), add(o, half), add(m, half), sub(m, half)];
  return { x, y, z: mul(det(d), cross(x, y)), o, m, corners };
}

// The scale k pitches from the middle: axes, o and m the middles of base and tip edge, corners D, A, B, C. theta is its
// inclination on a hinge, or place of the base, n_X and n_Y in the axes of the cross-section.
export function scale(d, load, theta, k) {
  const f = frame(d, load, k);
  const [o, x, y] = (Array.isArray(theta) ? theta : hinged(d, theta)).map(([across, out, along]) =>
    add(add(mul(across, f.x), mul(out, f.y)), mul(along, f.z)),
  );
  return placed(d, mapped(d, add(f.o, o)), mapped(d, x), mapped(d, y));
}

// How far a bent plate lies above its flat middle surface: 24 powers of the shares of length and half width.
export function lift(d, bent, x, y) {
  const [X, Y] = [x / d.eta, y / d.beta];
  return bent ? bent.reduce((sum, b, i) => sum + b * X ** (2 + Math.floor(i / 4)) * Y ** (i % 4), 0) : 0;
}

// A scale as a body in its own axes: points, faces and edges by their numbers; a thin one is a surface.
export function plate(d, bent) {
  const [n, m] = bent ? PIECES : [1, 1];
  const [middle, faces] = [[], []];
  const number = (i, j) => j * (n + 1) + i;
  for (let j = 0; j <= m; j++)
    for (let i = 0; i <= n; i++) {
      const [x, y] = [(d.eta * i) / n, d.beta * ((2 * j) / m - 1)];
      middle.push([x, y, lift(d, bent, x, y)]);
      if (i < n && j < m) faces.push([number(i, j), number(i + 1, j), number(i + 1, j + 1), number(i, j + 1)]);
    }
  const range = (length, f) => Array.from({ length }, (_, i) => f(i));
  const rim = [
    ...range(n, (i) => number(i, 0)), ...range(m, (j) => number(n, j)),
    ...range(n, (i) => number(n - i, m)), ...range(m, (j) => number(0, m - j)),
  ]; // prettier-ignore
  const edges = rim.map((one, i) => [one, rim[(i + 1) % rim.length]]);
  if (!d.thick) return { points: middle, faces, edges };
  const [up, half] = [middle.length, d.thick / 2];
  const above = (every) => every.map((one) => one.map((i) => i + up));
  const corners = [number(0, 0), number(n, 0), number(n, m), number(0, m)];
  return {
    points: [-half, half].flatMap((off) => middle.map(([x, y, z]) => [x, y, z + off])),
    faces: [...faces, ...above(faces), ...edges.map(([a, b]) => [a, b, b + up, a + up])],
    edges: [...edges, ...above(edges), ...corners.map((i) => [i, i + up])],
  };
}

// The contact of scale k's tip with its neighbour, as the common normal of tip edge and side edge of the flat middle
// surfaces; point lies on the surface of the thick, bent plate. In bending the tip's corner B meets the neighbour's face
// (across the beam the tip edge does: its middle), s and p along and across it.
// The neighbour stands alike, or as the state beside says.
export function contact(d, load, theta, k, bent, beside = { theta, bent }) {
  const one = scale(d, load, theta, k);
  const two = scale(d, load, attitude(beside), k + d.neighbour);
  if (d.kind !== "twisting") {
    const y = d.alpha ? d.beta : 0;
    const point = add(add(one.m, mul(y, one.y)), mul(lift(d, bent, d.eta, y) - d.thick / 2, one.z));
    const seen = sub(point, two.o);
    return { point, on_tip: point, p: dot(seen, two.y), s: dot(seen, two.x) };
  }
  const corner = two.corners[d.sense > 0 ? 0 : 1];
  const normal = cross(one.y, two.x);
  const away = sub(corner, one.m);
  const size = dot(normal, normal);
  const p = dot(cross(away, two.x), normal) / size;
  const s = dot(cross(away, one.y), normal) / size;
  const up = lift(d, beside.bent, s, -d.sense * d.beta) + d.thick / 2;
  return { point: add(add(corner, mul(s, two.x)), mul(up, two.z)), on_tip: add(one.m, mul(p, one.y)), p: d.sense * p, s };
}

// Unit vectors of the normal and the friction force on scale k where it rests on its neighbour. slip: sliding rates
// along the side edge and along the tip edge, in bending along and across the face. By the plate law the normal is the plate's, and friction lies in it.
export function directions(d, load, theta, slip, k, beside = { theta }) {
  const one = scale(d, load, theta, k);
  const two = scale(d, load, attitude(beside), k + d.neighbour);
  const across = d.kind === "twisting" ? mul(d.sense, one.y) : two.y;
  let friction = add(mul(slip[0], two.x), mul(slip[1], across));
  let normal = two.z;
  if (d.kind === "twisting" && d.law === "plate") friction = sub(friction, mul(dot(friction, normal), normal));
  else if (d.kind === "twisting") normal = unit(mul(det(d), cross(two.x, one.y)));
  return { normal, friction: unit(friction) };
}

// Length of the arrow of a force x in units of its own.
export const arrow = (x) => (LONGEST * x) / (1 + x);

// Cross-sections of the bar from end to end: four corners each, the scaled edge first.
export function bar(d, load) {
  const n = STEPS * d.scales;
  const sections = [];
  for (let i = 0; i <= n; i++) {
    const f = frame(d, load, -d.scales / 2 + (d.scales * i) / n);
    const side = mul(d.half, f.x);
    const low = mul(-2 * d.lam, f.y);
    const [left, right] = [sub(f.o, side), add(f.o, side)];
    sections.push([left, right, add(right, low), add(left, low)]);
  }
  return sections;
}

// Place of the first scale; the others follow at distances of one pitch.
export const first = (d) => -(d.scales - 1) / 2 + d.shift;

// Design and state of each face that has scales.
export const faces = (design, state) => [[design, state], ...(design.other ? [[design.other, state.other]] : [])];

// Design, own state and place of every scale of both faces; at another load if one is given.
export const scales = (every, load) =>
  every.flatMap(([d, state]) =>
    Array.from({ length: d.scales }, (_, i) => [
      d,
      own(state, i),
      scale(d, load ?? at(state), attitude(own(state, i)), first(d) + i),
    ]),
  );

// Points around bar and scales.
export const around = (every, load) => [
  ...bar(every[0][0], load ?? at(every[0][1])).flat(),
  ...scales(every, load).flatMap(([, , one]) => one.corners),
];
