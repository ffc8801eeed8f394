// Shows a simulation on a canvas: it runs by the clock, turns with the pointer, and is dragged by it.

import { add, Camera, dot, type Point, unit } from "./camera.js";
import { type Hit, pick } from "./pick.js";
import { ball, Renderer } from "./renderer.js";
import type { Simulation } from "./simulation.js";

/** Fastest that a vertex is dragged [m/s]: no hand is faster, and no cloth is asked for more than it can do. */
const FASTEST = 4;
/** Longest time that is caught up on [s]: after that the simulation is slower than the clock. */
const LONGEST = 0.1;

/** What happens in a viewer. */
export interface ViewerEvents {
  /** After each picture. */
  frame?: (times: FrameTimes) => void;
  /** Where a frame could not be computed; the viewer stands still then. */
  error?: (error: Error) => void;
  /** It runs, or stands still. */
  playing?: (isPlaying: boolean) => void;
}

/** How fast it is. */
export interface FrameTimes {
  /** Pictures a second. */
  fps: number;
  /** Time that a frame of the simulation takes [ms]. */
  step: number;
  /** Time since the simulation's start [s]. */
  time: number;
}

/** What the pointer has of the cloth. */
interface Drag {
  hit: Hit;
  /** Where the vertex was brought, and where the pointer is [m]. */
  now: Point;
  to: Point;
  pointer: number;
}

/** A simulation on a canvas. */
export class Viewer {
  readonly canvas: HTMLCanvasElement;
  readonly camera = new Camera();
  readonly #renderer: Renderer;
  readonly #events: ViewerEvents;
  readonly #stop = new AbortController();
  readonly #watch: ResizeObserver;
  #simulation: Simulation | undefined;
  #start: Uint8Array | undefined;
  #drag: Drag | undefined;
  #pointers = new Map<number, [number, number]>();
  #isPlaying = false;
  #isSeen = true;
  #request = 0;
  #before = 0;
  #owed = 0;
  #stepTime = 0;
  #fps = 0;

  constructor(canvas: HTMLCanvasElement, events: ViewerEvents = {}) {
    this.canvas = canvas;
    this.#events = events;
    this.#renderer = new Renderer(canvas);
    const { signal } = this.#stop;
    const on = <K extends keyof HTMLElementEventMap>(kind: K, then: (event: HTMLElementEventMap[K]) => void) =>
      canvas.addEventListener(kind, then, { signal, passive: false });
    on("pointerdown", (event) => this.#press(event));
    on("pointermove", (event) => this.#move(event));
    for (const kind of ["pointerup", "pointercancel", "lostpointercapture"] as const) on(kind, (event) => this.#release(event));
    on("wheel", (event) => {
      event.preventDefault();
      this.camera.zoom(Math.exp(Math.max(-1, Math.min(1, event.deltaY / 400))));
      this.redraw();
    });
    on("keydown", (event) => this.#key(event));
    canvas.addEventListener("webglcontextlost", (event) => event.preventDefault(), { signal });
    canvas.addEventListener("webglcontextrestored", () => {
      this.#renderer.restart();
      if (this.#simulation) this.#renderer.show(this.#simulation);
      this.redraw();
    }, { signal });
    canvas.ownerDocument.addEventListener("visibilitychange", () => this.#wake(), { signal });
    this.#watch = new ResizeObserver(() => this.#resize());
    this.#watch.observe(canvas);
    this.#resize();
  }

  /** The simulation that is shown. */
  get simulation(): Simulation | undefined {
    return this.#simulation;
  }

  get isPlaying(): boolean {
    return this.#isPlaying;
  }

  /** Shows a simulation, whose memory stays the caller's. `keepsView` leaves the camera where it is. */
  show(simulation: Simulation | undefined, { keepsView = false } = {}): void {
    this.#drag = undefined;
    this.#simulation = simulation;
    this.#start = simulation?.snapshot();
    this.#owed = 0;
    if (!simulation) {
      this.#renderer.clear();
    } else {
      this.#renderer.show(simulation);
      if (!keepsView) this.frame();
    }
    this.redraw();
  }

  /** Brings all bodies into view. */
  frame(): void {
    if (!this.#simulation) return;
    const { at, radius } = ball(this.#simulation);
    this.camera.frame(at, radius);
    this.redraw();
  }

  play(): void {
    if (this.#isPlaying) return;
    this.#isPlaying = true;
    this.#events.playing?.(true);
    this.#before = 0;
    this.#wake();
  }

  pause(): void {
    if (!this.#isPlaying) return;
    this.#isPlaying = false;
    this.#events.playing?.(false);
  }

  /** Goes back to the start. */
  restart(): void {
    if (!this.#simulation || !this.#start) return;
    this.#let();
    this.#simulation.restore(this.#start);
    this.#owed = 0;
    this.redraw();
  }

  /** Runs one frame of the simulation. */
  stepOnce(): void {
    this.#step();
    this.redraw();
  }

  /** Whether it is in sight; it stands still where it is not. */
  set isSeen(isSeen: boolean) {
    this.#isSeen = isSeen;
    this.#before = 0;
    this.#wake();
  }

  /** Draws it once more. */
  redraw(): void {
    this.#wake();
  }

  /** Gives all back but the simulation. */
  dispose(): void {
    this.#stop.abort();
    this.#watch.disconnect();
    cancelAnimationFrame(this.#request);
    this.#request = -1;
    this.#isPlaying = false;
    this.#renderer.dispose();
    this.#simulation = undefined;
  }

  #wake(): void {
    if (this.#request !== 0 || !this.#isSeen) return;
    this.#request = requestAnimationFrame((now) => {
      this.#request = 0;
      this.#picture(now);
    });
  }

  #picture(now: number): void {
    const simulation = this.#simulation;
    const passed = this.#before > 0 ? (now - this.#before) / 1e3 : 0;
    this.#before = this.#isPlaying ? now : 0;
    if (!simulation || simulation.isFreed) return;
    if (passed > 0) this.#fps += (1 / passed - this.#fps) * (this.#fps === 0 ? 1 : 0.1);
    if (this.#isPlaying) {
      this.#owed = Math.min(LONGEST, this.#owed + (passed || simulation.dt));
      // A picture waits for no more frames than the clock's.
      const until = performance.now() + 1e3 * LONGEST;
      while (this.#isPlaying && this.#owed >= simulation.dt * 0.999 && performance.now() < until) {
        this.#owed -= simulation.dt;
        this.#step();
      }
    }
    try {
      this.#renderer.draw(simulation, this.camera);
      this.#events.frame?.({ fps: this.#fps, step: this.#stepTime, time: simulation.time });
    } catch (error) {
      this.#fail(error);
    }
    if (this.#isPlaying && !this.canvas.ownerDocument.hidden) this.#wake();
  }

  #step(): void {
    const simulation = this.#simulation;
    if (!simulation) return;
    const start = performance.now();
    try {
      this.#pull(simulation);
      simulation.step();
    } catch (error) {
      this.#fail(error);
    }
    const took = performance.now() - start;
    this.#stepTime += (took - this.#stepTime) * (this.#stepTime === 0 ? 1 : 0.1);
  }

  #fail(error: unknown): void {
    this.pause();
    this.#events.error?.(error instanceof Error ? error : new Error(String(error)));
  }

  /** Brings the dragged vertex nearer to the pointer. */
  #pull(simulation: Simulation): void {
    const drag = this.#drag;
    if (!drag) return;
    const way = add(drag.to, drag.now, -1);
    const far = Math.hypot(...way);
    const most = FASTEST * simulation.dt;
    drag.now = far > most ? add(drag.now, way, most / far) : drag.to;
    simulation.pin(drag.hit.body, drag.hit.vertex, drag.now);
  }

  /** Where an event is in the picture, from −1 to 1, y up. */
  #place(event: PointerEvent): [number, number] {
    const box = this.canvas.getBoundingClientRect();
    return [2 * (event.clientX - box.left) / box.width - 1, 1 - 2 * (event.clientY - box.top) / box.height];
  }

  #press(event: PointerEvent): void {
    this.canvas.focus({ preventScroll: true });
    this.canvas.setPointerCapture(event.pointerId);
    this.#pointers.set(event.pointerId, [event.clientX, event.clientY]);
    const simulation = this.#simulation;
    if (!simulation || this.#pointers.size > 1 || event.button !== 0 || event.shiftKey) return this.#let();
    const hit = pick(simulation, this.#renderer.triangles, this.camera.eye, this.camera.ray(...this.#place(event)));
    if (!hit) return;
    try {
      simulation.pin(hit.body, hit.vertex, hit.place);
      this.#drag = { hit, now: hit.place, to: hit.place, pointer: event.pointerId };
    } catch {
      // A pin of the scene that moves by keyframes holds it.
    }
  }

  #move(event: PointerEvent): void {
    const before = this.#pointers.get(event.pointerId);
    if (!before) return;
    const others = [...this.#pointers].filter(([id]) => id !== event.pointerId).map(([, place]) => place);
    const [dx, dy] = [event.clientX - before[0], event.clientY - before[1]];
    this.#pointers.set(event.pointerId, [event.clientX, event.clientY]);
    const other = others[0];
    if (other) {
      const apart = (place: readonly [number, number]) => Math.hypot(place[0] - other[0], place[1] - other[1]) || 1;
      this.camera.zoom(apart(before) / apart([event.clientX, event.clientY]));
    } else if (this.#drag) {
      this.#drag.to = this.#onPlane(this.#place(event), this.#drag.hit.place);
    } else {
      const turn = 5 / Math.max(1, this.canvas.clientHeight);
      this.camera.orbit(-dx * turn, dy * turn);
    }
    this.redraw();
  }

  /** The point under the pointer as far away as `place` is. */
  #onPlane(at: [number, number], place: Point): Point {
    const { eye } = this.camera;
    const ahead = unit(add(this.camera.at, eye, -1));
    const way = this.camera.ray(...at);
    return add(eye, way, dot(add(place, eye, -1), ahead) / dot(way, ahead));
  }

  #release(event: PointerEvent): void {
    this.#pointers.delete(event.pointerId);
    if (this.#drag?.pointer === event.pointerId) this.#let();
  }

  /** Lets the cloth go. */
  #let(): void {
    const drag = this.#drag;
    this.#drag = undefined;
    if (drag && this.#simulation && !this.#simulation.isFreed) {
      try {
        this.#simulation.unpin(drag.hit.body, drag.hit.vertex);
      } catch (error) {
        this.#fail(error);
      }
    }
  }

  #key(event: KeyboardEvent): void {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const step = 0.1;
    const actions: Record<string, () => void> = {
      ArrowLeft: () => this.camera.orbit(-step, 0),
      ArrowRight: () => this.camera.orbit(step, 0),
      ArrowUp: () => this.camera.orbit(0, step),
      ArrowDown: () => this.camera.orbit(0, -step),
      "+": () => this.camera.zoom(0.9),
      "=": () => this.camera.zoom(0.9),
      "-": () => this.camera.zoom(1.1),
      " ": () => (this.#isPlaying ? this.pause() : this.play()),
      ".": () => this.stepOnce(),
      f: () => this.frame(),
      r: () => this.restart(),
    };
    const action = actions[event.key];
    if (!action) return;
    event.preventDefault();
    action();
    this.redraw();
  }

  #resize(): void {
    const { clientWidth, clientHeight } = this.canvas;
    const scale = Math.min(2, globalThis.devicePixelRatio || 1);
    this.canvas.width = Math.max(1, Math.round(clientWidth * scale));
    this.canvas.height = Math.max(1, Math.round(clientHeight * scale));
    this.camera.aspect = this.canvas.width / this.canvas.height;
    this.redraw();
  }
}
