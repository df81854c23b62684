// The page of the stand-alone view: a slider over the states inside the file, and an animation of them.
import * as geometry from "./geometry.js";
import { BeamScene } from "./scene.js";

const find = (id) => document.getElementById(id);
const data = JSON.parse(find("data").textContent);
const { design, states, palette } = data;
const canvas = document.querySelector("canvas");
const beam = new BeamScene(canvas, palette);
const slider = find("load");
const dark = matchMedia("(prefers-color-scheme: dark)");
let [playing, way] = [null, 1];

function show(i) {
  const state = states[i];
  slider.value = i;
  beam.set(design, state);
  find("now").value = state.words;
  slider.setAttribute("aria-valuetext", state.words);
}

// What the colours mean, of those that the slider comes to.
function legend() {
  const every = states.flatMap((state) => [state, ...(state.other ? [state.other] : []), ...(state.each ?? [])]);
  const names = Object.keys(palette.words).filter((name) => every.some((state) => state.name === name));
  const keys = names.map((name) => ["", palette.states[name], `scales: ${palette.words[name]}`]);
  if (every.some((state) => state.x > 0)) {
    keys.push(["force", "var(--normal)", "normal force on the tip"]);
    if (states[0].mu) keys.push(["force", "var(--friction)", "friction on the tip"]);
  }
  for (const [kind, colour, words] of keys) {
    const item = document.createElement("li");
    const key = document.createElement("b");
    key.className = kind;
    key.style.background = colour;
    item.append(key, words);
    find("legend").append(item);
  }
}

// the load goes up and down evenly; the states lie closer together towards a lock
function play() {
  let load = states[slider.value].load;
  const last = states[states.length - 1].load;
  playing = setInterval(() => {
    load += (way * last) / 90;
    if (load >= last || load <= 0) way = -way;
    load = Math.min(last, Math.max(0, load));
    show(states.findIndex((state) => state.load >= load - 1e-12));
  }, 40);
}

function toggle() {
  if (playing) {
    playing = clearInterval(playing);
  } else {
    beam.film(states.map((state) => ({ design, state })));
    play();
  }
  find("play").textContent = playing ? "Stop" : "Play";
}

const theme = () => beam.theme(dark.matches ? "dark" : "light");
const resize = () => beam.resize(find("stage").clientWidth, find("stage").clientHeight);
slider.max = states.length - 1;
slider.addEventListener("input", () => show(Number(slider.value)));
find("play").addEventListener("click", toggle);
canvas.addEventListener("keydown", (event) => beam.key(event.key) && event.preventDefault());
find("reset").addEventListener("click", () => beam.reset());
legend();
find("name").textContent = data.angle;
find("end").textContent = `${data.model}; ${data.sentence}`;
dark.addEventListener("change", theme);
new ResizeObserver(resize).observe(find("stage"));
resize();
show(data.first);
theme();
Object.assign(window, { squamaView: beam, squamaGeometry: geometry, squamaData: data });
