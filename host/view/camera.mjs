// The camera: around a point, with z upwards.
import { add, cross, dot, scale } from "./vectors.mjs";

/** Focal length over half the height of the picture. */
const FOCUS = 2.4;

export class Camera {
  constructor() {
    this.aim = [0, 0, 0];
    this.distance = 1;
    this.size = 1;
    this.yaw = -0.62;
    this.pitch = 0.5;
    this.width = this.height = 1;
  }

  /** Looks at a body of this centre and radius so that all of it is in the picture. */
  lookAt(centre, radius) {
    this.aim = centre;
    this.size = radius;
    this.zoomOut = 1;
    this.fit();
  }

  /** Takes over the size of the picture [CSS pixels]. */
  resize(width, height) {
    [this.width, this.height] = [Math.max(width, 1), Math.max(height, 1)];
    this.fit();
  }

  fit() {
    const narrow = Math.min(1, this.width / this.height);
    this.distance = ((this.size * FOCUS * 1.12) / narrow) * (this.zoomOut ?? 1);
  }

  turn(right, down) {
    this.yaw -= right / 160;
    this.pitch = Math.max(-1.5, Math.min(1.5, this.pitch + down / 160));
  }

  zoom(factor) {
    this.zoomOut = Math.max(0.25, Math.min(4, this.zoomOut * factor));
    this.fit();
  }

  /** Returns the unit vectors to the right, up and towards the viewer, and the eye. */
  axes() {
    const [cosYaw, sinYaw, cosPitch, sinPitch] = [Math.cos(this.yaw), Math.sin(this.yaw), Math.cos(this.pitch), Math.sin(this.pitch)];
    const towards = [cosPitch * sinYaw, -cosPitch * cosYaw, sinPitch];
    const right = [cosYaw, sinYaw, 0];
    return { right, up: cross(towards, right), towards, eye: add(this.aim, towards, this.distance) };
  }

  /** Returns the matrix from places [m] to the picture. */
  matrix() {
    const { right, up, towards, eye } = this.axes();
    const aspect = this.width / this.height;
    const near = Math.max(0.02 * this.distance, this.distance - 6 * this.size);
    const far = this.distance + 6 * this.size;
    const [deep, deeper] = [(far + near) / (near - far), (2 * far * near) / (near - far)];
    const column = (axis) => [(FOCUS / aspect) * right[axis], FOCUS * up[axis], deep * towards[axis], -towards[axis]];
    const back = [(-FOCUS / aspect) * dot(right, eye), -FOCUS * dot(up, eye), -deep * dot(towards, eye) + deeper, dot(towards, eye)];
    return new Float32Array([...column(0), ...column(1), ...column(2), ...back]);
  }

  /** Returns where a place [m] is in the picture [CSS pixels], and how many pixels a metre has there. */
  project(place) {
    const { right, up, towards, eye } = this.axes();
    const away = add(place, eye, -1);
    const pixelsPerM = (FOCUS * this.height) / (2 * Math.max(-dot(towards, away), 1e-6));
    return { x: this.width / 2 + pixelsPerM * dot(right, away), y: this.height / 2 - pixelsPerM * dot(up, away), pixelsPerM };
  }

  /** Returns the motion [m] at the depth of a place that goes so many pixels across the picture. */
  across(place, pixelsRight, pixelsDown) {
    const { right, up } = this.axes();
    const { pixelsPerM } = this.project(place);
    return add(scale(right, pixelsRight / pixelsPerM), up, -pixelsDown / pixelsPerM);
  }
}
