// A camera that orbits a point, and the little of matrices that it needs: 4 × 4, column by column.

/** A matrix of sixteen numbers, column by column. */
export type Matrix = Float32Array;

export function product(a: ArrayLike<number>, b: ArrayLike<number>): Matrix {
  const out = new Float32Array(16);
  for (let column = 0; column < 4; column++) {
    for (let row = 0; row < 4; row++) {
      let sum = 0;
      for (let k = 0; k < 4; k++) sum += a[4 * k + row]! * b[4 * column + k]!;
      out[4 * column + row] = sum;
    }
  }
  return out;
}

export type Point = [number, number, number];

export const add = (a: Point, b: Point, times = 1): Point => [a[0] + times * b[0], a[1] + times * b[1], a[2] + times * b[2]];
export const dot = (a: Point, b: Point): number => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
export const cross = (a: Point, b: Point): Point => [
  a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0],
];
export const unit = (a: Point): Point => {
  const length = Math.hypot(...a) || 1;
  return [a[0] / length, a[1] / length, a[2] / length];
};

/** What brings the world in front of an eye that looks along −z. */
export function lookAt(eye: Point, at: Point): Matrix {
  const back = unit(add(eye, at, -1));
  const side = unit(cross(Math.abs(back[1]) > 0.999 ? [0, 0, 1] : [0, 1, 0], back));
  const up = cross(back, side);
  return new Float32Array([
    side[0], up[0], back[0], 0, side[1], up[1], back[1], 0, side[2], up[2], back[2], 0,
    -dot(side, eye), -dot(up, eye), -dot(back, eye), 1,
  ]);
}

export function perspective(angle: number, aspect: number, near: number, far: number): Matrix {
  const f = 1 / Math.tan(angle / 2);
  const depth = 1 / (near - far);
  return new Float32Array([f / aspect, 0, 0, 0, 0, f, 0, 0, 0, 0, (far + near) * depth, -1, 0, 0, 2 * far * near * depth, 0]);
}

export function orthographic(half: number, near: number, far: number): Matrix {
  return new Float32Array([1 / half, 0, 0, 0, 0, 1 / half, 0, 0, 0, 0, -2 / (far - near), 0, 0, 0, -(far + near) / (far - near), 1]);
}

/** Vertical angle of view [rad]. */
const ANGLE = 0.7;
/** How far up or down it may look from [rad]. */
const STEEPEST = 1.5;

/** An eye that looks at a point. */
export class Camera {
  at: Point = [0, 0, 0];
  distance = 3;
  /** About the y axis, and up [rad]. */
  yaw = 0.5;
  pitch = 0.3;
  /** Width by height of the picture. */
  aspect = 1;
  /** Radius of what is to be seen [m]. */
  radius = 1;

  get eye(): Point {
    const [flat, up] = [Math.cos(this.pitch), Math.sin(this.pitch)];
    return add(this.at, [flat * Math.sin(this.yaw), up, flat * Math.cos(this.yaw)], this.distance);
  }

  /** Brings a ball into view. */
  frame(at: Point, radius: number): void {
    this.at = at;
    this.radius = Math.max(radius, 1e-3);
    const narrow = ANGLE / 2 * Math.min(1, this.aspect);
    this.distance = this.radius / Math.sin(narrow);
  }

  orbit(yaw: number, pitch: number): void {
    this.yaw += yaw;
    this.pitch = Math.min(STEEPEST, Math.max(-STEEPEST, this.pitch + pitch));
  }

  zoom(factor: number): void {
    this.distance = Math.min(20 * this.radius, Math.max(0.2 * this.radius, this.distance * factor));
  }

  view(): Matrix {
    return lookAt(this.eye, this.at);
  }

  projection(): Matrix {
    return perspective(ANGLE, this.aspect, this.distance / 100, this.distance + 40 * this.radius);
  }

  /** The way through a point of the picture, each coordinate from −1 to 1, y up. */
  ray(x: number, y: number): Point {
    const back = unit(add(this.eye, this.at, -1));
    const side = unit(cross([0, 1, 0], back));
    const up = cross(back, side);
    const half = Math.tan(ANGLE / 2);
    return unit(add(add(add([0, 0, 0], back, -1), side, x * half * this.aspect), up, y * half));
  }
}
