// The beam in space: bar, scales, contact points and forces, in pitches; geometry.py states the same.
// Axes: z along the beam, y out of the scaled face. The middle of the beam stays where it is.
// A design: {kind, held, eta, beta, lam, height, alpha, half, sense, bend, law, neighbour, scales, S, shift}, ratios and
// radians. S maps the scaled face's places to those of its face.

export const STEPS = 6; // pieces of the bar per pitch
export const LONGEST = 1.6; // length that an arrow comes near to as its force grows, in pitches

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

// The cross-section k pitches from the middle of the beam at a load angle per pitch: axes, and o, the middle of its
// scaled edge. It is moved by k times the screw of bend and twist, about the line that keeps its length; in twisting with
// the bend that is held.
export function frame(d, load, k) {
  const [psi, phi] = d.kind === "twisting" ? [d.held ?? 0, d.sense * load] : [d.bend * load, 0];
  const w = [-k * psi, 0, -k * phi];
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
  return { o: add(mul(d.lam, y), moved([0, 0, k * (1 + psi * (d.lam - d.height))], b, c)), x, y, z };
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

// The contact of scale k's tip with its neighbour, as the common normal of tip edge and side edge. In bending the
// tip's corner B meets the neighbour's face (across the beam the tip edge does: its middle), s and p along and across it.
export function contact(d, load, theta, k) {
  const one = scale(d, load, theta, k);
  const two = scale(d, load, theta, k + d.neighbour);
  if (d.kind !== "twisting") {
    const point = d.alpha ? one.corners[2] : one.m;
    const seen = sub(point, two.o);
    return { point, on_tip: point, p: dot(seen, two.y), s: dot(seen, two.x) };
  }
  const corner = two.corners[d.sense > 0 ? 0 : 1];
  const normal = cross(one.y, two.x);
  const away = sub(corner, one.m);
  const size = dot(normal, normal);
  const p = dot(cross(away, two.x), normal) / size;
  const s = dot(cross(away, one.y), normal) / size;
  return { point: add(corner, mul(s, two.x)), on_tip: add(one.m, mul(p, one.y)), p: d.sense * p, s };
}

// Unit vectors of the normal and the friction force on scale k where it rests on its neighbour. slip: sliding rates
// along the side edge and along the tip edge, in bending along and across the face. By the plate law the normal is the plate's, and friction lies in it.
export function directions(d, load, theta, slip, k) {
  const one = scale(d, load, theta, k);
  const two = scale(d, load, theta, k + d.neighbour);
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

// Design, state and place of every scale of both faces; at another load if one is given.
export const scales = (every, load) =>
  every.flatMap(([d, state]) =>
    Array.from({ length: d.scales }, (_, i) => [
      d,
      state,
      scale(d, load ?? state.load, state.pose ?? state.theta, first(d) + i),
    ]),
  );

// Points around bar and scales.
export const around = (every, load) => [
  ...bar(every[0][0], load ?? every[0][1].load).flat(),
  ...scales(every, load).flatMap(([, , one]) => one.corners),
];
