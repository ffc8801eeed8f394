export { init, simdLevel, version } from "./engine.js";
export { fetchScene } from "./fetched.js";
export { filesOf, Simulation } from "./simulation.js";
export { TaffetaCloth } from "./element.js";
export { Camera } from "./camera.js";
export { type Hit, pick } from "./pick.js";
export { type FrameTimes, Viewer, type ViewerEvents } from "./viewer.js";
export type * from "./types.js";
