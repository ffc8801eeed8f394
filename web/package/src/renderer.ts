// Draws a simulation with WebGL2: two-sided, lit, with a shadow.

import { add, type Camera, lookAt, type Matrix, orthographic, type Point, product, unit } from "./camera.js";
import type { Simulation } from "./simulation.js";

/** Texels of the shadow along each axis. */
const SHADOW = 1024;
/** Where the light comes from. */
const LIGHT: Point = unit([0.5, 1, 0.6]);

const IDENTITY = new Float32Array([1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]);

const VERTEX = `#version 300 es
layout(location = 0) in vec3 place;
layout(location = 1) in vec3 normal;
uniform mat4 pose, camera, light;
out vec3 at, up;
out vec4 seen;
void main() {
  vec4 world = pose * vec4(place, 1.0);
  at = world.xyz;
  up = mat3(pose) * normal;
  seen = light * world;
  gl_Position = camera * world;
  gl_PointSize = 7.0;
}`;

const FRAGMENT = `#version 300 es
precision highp float;
precision highp sampler2DShadow;
in vec3 at, up;
in vec4 seen;
uniform vec3 colour, eye, sun, middle;
uniform float fade;
uniform sampler2DShadow shadow;
out vec4 result;
float lit() {
  vec3 here = 0.5 * seen.xyz + 0.5;
  if (any(greaterThan(abs(here - 0.5), vec3(0.5)))) return 1.0;
  float sum = 0.0;
  for (int i = -1; i <= 1; i++)
    for (int j = -1; j <= 1; j++)
      sum += texture(shadow, vec3(here.xy + vec2(i, j) / ${SHADOW}.0, here.z - 0.002));
  return sum / 9.0;
}
void main() {
  float size = length(up);
  vec3 n = size > 0.0 ? up / size : vec3(0.0, 1.0, 0.0);
  vec3 view = normalize(eye - at);
  if (dot(n, view) < 0.0) {
    // From inside of the ground one sees out.
    if (fade > 0.0) discard;
    n = -n;
  }
  float direct = max(dot(n, sun), 0.0) * lit();
  float ambient = mix(0.32, 0.62, 0.5 + 0.5 * n.y);
  float sheen = 0.25 * pow(1.0 - max(dot(n, view), 0.0), 3.0);
  vec3 shade = colour * (ambient + 0.75 * direct) + sheen * (0.4 + 0.6 * direct);
  // A plane ends softly.
  float alpha = fade > 0.0 ? 1.0 - smoothstep(0.35 * fade, fade, distance(at, middle)) : 1.0;
  vec3 out_ = pow(clamp(shade, 0.0, 1.0), vec3(1.0 / 2.2));
  result = vec4(out_ * alpha, alpha);
}`;

/** Colours of bodies one after the other, in light. */
const COLOURS: Point[] = [[0.62, 0.07, 0.09], [0.07, 0.24, 0.55], [0.72, 0.46, 0.08], [0.08, 0.42, 0.28], [0.4, 0.16, 0.45]];
const COLLIDER: Point = [0.42, 0.43, 0.45];
const PLANE: Point = [0.5, 0.5, 0.5];

/** What is drawn with one call. */
interface Drawn {
  vertices: WebGLVertexArrayObject;
  buffers: WebGLBuffer[];
  places: WebGLBuffer;
  normals: WebGLBuffer;
  count: number;
  isPoints: boolean;
  colour: Point;
  isPlane: boolean;
  /** The collider whose pose it has. */
  collider?: string;
  deforms: boolean;
  body?: string;
}

/** Area-weighted normals of triangles. */
export function normalsOf(places: Float32Array, triangles: Uint32Array): Float32Array {
  const normals = new Float32Array(places.length);
  for (let face = 0; face < triangles.length; face += 3) {
    const [a, b, c] = [3 * triangles[face]!, 3 * triangles[face + 1]!, 3 * triangles[face + 2]!];
    const [ux, uy, uz] = [places[b]! - places[a]!, places[b + 1]! - places[a + 1]!, places[b + 2]! - places[a + 2]!];
    const [vx, vy, vz] = [places[c]! - places[a]!, places[c + 1]! - places[a + 1]!, places[c + 2]! - places[a + 2]!];
    const n = [uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx];
    for (const corner of [a, b, c]) for (let axis = 0; axis < 3; axis++) normals[corner + axis]! += n[axis]!;
  }
  return normals;
}

/** Draws on a canvas. */
export class Renderer {
  readonly #gl: WebGL2RenderingContext;
  readonly #canvas: HTMLCanvasElement;
  #program!: WebGLProgram;
  #places = new Map<string, WebGLUniformLocation | null>();
  #shadow!: { texture: WebGLTexture; frame: WebGLFramebuffer };
  #drawn: Drawn[] = [];
  /** Triangles of bodies, to find what is under the pointer. */
  readonly triangles = new Map<string, Uint32Array>();
  /** Middle and radius of what is lit [m]. */
  #lit: { at: Point; radius: number } = { at: [0, 0, 0], radius: 1 };

  constructor(canvas: HTMLCanvasElement) {
    const gl = canvas.getContext("webgl2", { antialias: true, premultipliedAlpha: true });
    if (!gl) throw new Error("this browser has no WebGL2, or none for this canvas");
    this.#gl = gl;
    this.#canvas = canvas;
    this.restart();
  }

  /** Makes everything again, as after the context was lost. */
  restart(): void {
    const gl = this.#gl;
    this.#program = program(gl);
    this.#places.clear();
    const texture = gl.createTexture();
    gl.bindTexture(gl.TEXTURE_2D, texture);
    gl.texStorage2D(gl.TEXTURE_2D, 1, gl.DEPTH_COMPONENT24, SHADOW, SHADOW);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_COMPARE_MODE, gl.COMPARE_REF_TO_TEXTURE);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.LINEAR);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_S, gl.CLAMP_TO_EDGE);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_T, gl.CLAMP_TO_EDGE);
    const frame = gl.createFramebuffer();
    gl.bindFramebuffer(gl.FRAMEBUFFER, frame);
    gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.DEPTH_ATTACHMENT, gl.TEXTURE_2D, texture, 0);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    this.#shadow = { texture, frame };
    this.#drawn = [];
  }

  /** Draws this simulation from now on. */
  show(simulation: Simulation): void {
    this.clear();
    simulation.bodies.forEach(({ name }, index) => {
      const indices = simulation.indices(name);
      this.triangles.set(name, indices);
      const colour = COLOURS[index % COLOURS.length]!;
      const drawn = this.#make(simulation.positions(name), simulation.normals(name), indices, colour);
      this.#drawn.push({ ...drawn, body: name });
    });
    for (const { name, shape, poses } of simulation.colliders) {
      const { positions, indices } = simulation.colliderSurface(name);
      const isPlane = shape === "plane";
      const drawn = this.#make(positions, normalsOf(positions, indices), indices, isPlane ? PLANE : COLLIDER);
      this.#drawn.push({ ...drawn, isPlane, collider: name, deforms: poses > 0 });
    }
    this.#lit = ball(simulation);
  }

  /** Has nothing to draw. */
  clear(): void {
    const gl = this.#gl;
    for (const { vertices, buffers } of this.#drawn) {
      gl.deleteVertexArray(vertices);
      buffers.forEach((buffer) => gl.deleteBuffer(buffer));
    }
    this.#drawn = [];
    this.triangles.clear();
  }

  #make(places: Float32Array, normals: Float32Array, indices: Uint32Array, colour: Point): Drawn {
    const gl = this.#gl;
    const vertices = gl.createVertexArray();
    gl.bindVertexArray(vertices);
    const buffers = [places, normals].map((numbers, location) => {
      const buffer = gl.createBuffer();
      gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
      gl.bufferData(gl.ARRAY_BUFFER, numbers, gl.DYNAMIC_DRAW);
      gl.enableVertexAttribArray(location);
      gl.vertexAttribPointer(location, 3, gl.FLOAT, false, 0, 0);
      return buffer;
    });
    const elements = gl.createBuffer();
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, elements);
    gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, indices, gl.STATIC_DRAW);
    gl.bindVertexArray(null);
    // What has no triangles, as a chain, is seen as points.
    const isPoints = indices.length === 0;
    const count = isPoints ? places.length / 3 : indices.length;
    const [placesBuffer, normalsBuffer] = buffers as [WebGLBuffer, WebGLBuffer];
    return {
      vertices, buffers: [...buffers, elements], places: placesBuffer, normals: normalsBuffer,
      count, isPoints, colour, isPlane: false, deforms: false,
    };
  }

  #uniform(name: string): WebGLUniformLocation | null {
    let place = this.#places.get(name);
    if (place === undefined) {
      place = this.#gl.getUniformLocation(this.#program, name);
      this.#places.set(name, place);
    }
    return place;
  }

  /** Draws the state of now. */
  draw(simulation: Simulation, camera: Camera): void {
    const gl = this.#gl;
    if (gl.isContextLost()) return;
    this.#fetch(simulation);
    const poses = this.#drawn.map(({ collider }) => (collider ? Float32Array.from(simulation.colliderPose(collider)) : IDENTITY));
    const { at, radius } = this.#lit;
    const light = product(orthographic(1.3 * radius, 0.1 * radius, 8 * radius), lookAt(add(at, LIGHT, 4 * radius), at));
    gl.useProgram(this.#program);
    gl.enable(gl.DEPTH_TEST);
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.#shadow.frame);
    gl.viewport(0, 0, SHADOW, SHADOW);
    gl.clear(gl.DEPTH_BUFFER_BIT);
    gl.bindTexture(gl.TEXTURE_2D, null);
    gl.enable(gl.POLYGON_OFFSET_FILL);
    gl.polygonOffset(2, 2);
    this.#pass(light, light, poses, (one) => !one.isPlane);
    gl.disable(gl.POLYGON_OFFSET_FILL);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    gl.viewport(0, 0, this.#canvas.width, this.#canvas.height);
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    gl.bindTexture(gl.TEXTURE_2D, this.#shadow.texture);
    gl.uniform3fv(this.#uniform("eye"), camera.eye);
    gl.uniform3fv(this.#uniform("sun"), LIGHT);
    gl.uniform3fv(this.#uniform("middle"), camera.at);
    const seen = product(camera.projection(), camera.view());
    this.#pass(seen, light, poses, (one) => !one.isPlane);
    // Planes after all else, for they fade away.
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
    gl.uniform1f(this.#uniform("fade"), 5 * camera.radius);
    this.#pass(seen, light, poses, (one) => one.isPlane);
    gl.uniform1f(this.#uniform("fade"), 0);
    gl.disable(gl.BLEND);
  }

  /** Brings places and normals to the buffers. */
  #fetch(simulation: Simulation): void {
    const gl = this.#gl;
    const write = (buffer: WebGLBuffer, numbers: Float32Array) => {
      gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
      gl.bufferSubData(gl.ARRAY_BUFFER, 0, numbers);
    };
    for (const { body, collider, deforms, places, normals } of this.#drawn) {
      if (body) {
        write(places, simulation.positionsView(body));
        write(normals, simulation.normalsView(body));
      } else if (collider && deforms) {
        const { positions, indices } = simulation.colliderSurface(collider);
        write(places, positions);
        write(normals, normalsOf(positions, indices));
      }
    }
  }

  #pass(camera: Matrix, light: Matrix, poses: Float32Array[], isIn: (one: Drawn) => boolean): void {
    const gl = this.#gl;
    gl.uniformMatrix4fv(this.#uniform("camera"), false, camera);
    gl.uniformMatrix4fv(this.#uniform("light"), false, light);
    this.#drawn.forEach((one, index) => {
      if (!isIn(one)) return;
      gl.uniformMatrix4fv(this.#uniform("pose"), false, poses[index]!);
      gl.uniform3fv(this.#uniform("colour"), one.colour);
      gl.bindVertexArray(one.vertices);
      if (one.isPoints) gl.drawArrays(gl.POINTS, 0, one.count);
      else gl.drawElements(gl.TRIANGLES, one.count, gl.UNSIGNED_INT, 0);
    });
    gl.bindVertexArray(null);
  }

  /** Gives all back. */
  dispose(): void {
    this.clear();
    this.#gl.deleteProgram(this.#program);
    this.#gl.deleteTexture(this.#shadow.texture);
    this.#gl.deleteFramebuffer(this.#shadow.frame);
  }
}

/** A ball around all bodies, and colliders of a size. */
export function ball(simulation: Simulation): { at: Point; radius: number } {
  const [low, high] = [[Infinity, Infinity, Infinity], [-Infinity, -Infinity, -Infinity]];
  const take = (places: Float32Array) => places.forEach((x, index) => {
    low[index % 3] = Math.min(low[index % 3]!, x);
    high[index % 3] = Math.max(high[index % 3]!, x);
  });
  take(simulation.positionsView());
  for (const { name, shape } of simulation.colliders) {
    if (shape !== "plane" && shape !== "heightfield") take(simulation.colliderSurface(name).positions);
  }
  const at = low.map((x, axis) => 0.5 * (x + high[axis]!)) as Point;
  const radius = 0.5 * Math.hypot(...low.map((x, axis) => high[axis]! - x));
  return Number.isFinite(radius) ? { at, radius: radius || 1 } : { at: [0, 0, 0], radius: 1 };
}

function program(gl: WebGL2RenderingContext): WebGLProgram {
  const program = gl.createProgram();
  for (const [kind, source] of [[gl.VERTEX_SHADER, VERTEX], [gl.FRAGMENT_SHADER, FRAGMENT]] as const) {
    const shader = gl.createShader(kind);
    if (!shader) continue;
    gl.shaderSource(shader, source);
    gl.compileShader(shader);
    gl.attachShader(program, shader);
  }
  gl.linkProgram(program);
  if (!gl.getProgramParameter(program, gl.LINK_STATUS) && !gl.isContextLost()) {
    throw new Error(`the shader was not linked: ${gl.getProgramInfoLog(program) ?? ""}`);
  }
  return program;
}
