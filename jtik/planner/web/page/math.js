// Vectors as arrays, 4x4 matrices as column-major Float32Arrays (as WebGL takes them), quaternions (w, x, y, z).

export const add = (a, b) => a.map((value, k) => value + b[k]);
export const sub = (a, b) => a.map((value, k) => value - b[k]);
export const scale = (a, factor) => a.map((value) => value * factor);
export const dot = (a, b) => a.reduce((sum, value, k) => sum + value * b[k], 0);
export const norm = (a) => Math.hypot(...a);
export const unit = (a) => (norm(a) > 0 ? scale(a, 1 / norm(a)) : a);
export const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
export const transposed = (A) => A[0].map((_, k) => A.map((row) => row[k]));
export const mix = (a, b, share) => a.map((value, k) => value + (b[k] - value) * share);

export function rotate(q, v) {
  const [w, x, y, z] = q;
  const t = [2 * (y * v[2] - z * v[1]), 2 * (z * v[0] - x * v[2]), 2 * (x * v[1] - y * v[0])];
  return [
    v[0] + w * t[0] + y * t[2] - z * t[1],
    v[1] + w * t[1] + z * t[0] - x * t[2],
    v[2] + w * t[2] + x * t[1] - y * t[0],
  ];
}

export function quaternionProduct(a, b) {
  const [w, x, y, z] = a;
  return [
    w * b[0] - x * b[1] - y * b[2] - z * b[3],
    w * b[1] + x * b[0] + y * b[3] - z * b[2],
    w * b[2] - x * b[3] + y * b[0] + z * b[1],
    w * b[3] + x * b[2] - y * b[1] + z * b[0],
  ];
}

export const quaternionOf = (axis, angle) => [Math.cos(angle / 2), ...scale(unit(axis), Math.sin(angle / 2))];

export function matrixOfRotation(axis, angle) {
  const q = quaternionOf(axis, angle);
  return transposed([[1, 0, 0], [0, 1, 0], [0, 0, 1]].map((e) => rotate(q, e)));
}

// A point of a body, from the pose of its frame: poses has 7 numbers a frame, position and quaternion.
export function place(poses, frame, point) {
  const at = 7 * frame;
  const [w, x, y, z] = [poses[at + 3], poses[at + 4], poses[at + 5], poses[at + 6]];
  const [a, b, c] = point;
  const t0 = 2 * (y * c - z * b);
  const t1 = 2 * (z * a - x * c);
  const t2 = 2 * (x * b - y * a);
  return [
    poses[at] + a + w * t0 + y * t2 - z * t1,
    poses[at + 1] + b + w * t1 + z * t0 - x * t2,
    poses[at + 2] + c + w * t2 + x * t1 - y * t0,
  ];
}

export function multiply(A, B) {
  const C = new Float32Array(16);
  for (let i = 0; i < 4; i++) {
    for (let j = 0; j < 4; j++) {
      let sum = 0;
      for (let k = 0; k < 4; k++) sum += A[4 * k + i] * B[4 * j + k];
      C[4 * j + i] = sum;
    }
  }
  return C;
}

export function perspective(angle, aspect, near, far) {
  const f = 1 / Math.tan(angle / 2);
  return new Float32Array([f / aspect, 0, 0, 0, 0, f, 0, 0, 0, 0, (far + near) / (near - far), -1, 0, 0, (2 * far * near) / (near - far), 0]);
}

export function lookAt(eye, at, up) {
  const z = unit(sub(eye, at));
  const x = unit(cross(up, z));
  const y = cross(z, x);
  return new Float32Array([x[0], y[0], z[0], 0, x[1], y[1], z[1], 0, x[2], y[2], z[2], 0, -dot(x, eye), -dot(y, eye), -dot(z, eye), 1]);
}

// A pose matrix from rows of a rotation (3, 3) and a position.
export function rigid(R, p) {
  return new Float32Array([R[0][0], R[1][0], R[2][0], 0, R[0][1], R[1][1], R[2][1], 0, R[0][2], R[1][2], R[2][2], 0, p[0], p[1], p[2], 1]);
}

export const IDENTITY = rigid([[1, 0, 0], [0, 1, 0], [0, 0, 1]], [0, 0, 0]);
