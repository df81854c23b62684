// What a page imports.
export * as geometry from "./geometry.js";
export { BeamScene } from "./scene.js";
