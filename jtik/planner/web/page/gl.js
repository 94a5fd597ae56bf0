// WebGL with one shader. Every solid is a unit mesh, scaled, stretched along z and placed by a pose; lines are ribbons
// of constant width in pixels. Back faces are left out: in software every pixel costs.

import { add, cross, dot, IDENTITY, multiply, norm, sub, unit } from "./math.js";

const VERTEX = `
attribute vec3 position;
attribute vec3 normal;
attribute float end;
uniform mat4 pose, view;
uniform vec3 size;
uniform float stretch;
varying vec3 facing;
varying vec3 place;
void main() {
  vec3 local = position * size + vec3(0.0, 0.0, end * stretch);
  vec4 world = pose * vec4(local, 1.0);
  facing = mat3(pose) * (normal / size);
  place = world.xyz;
  gl_Position = view * world;
}`;

const FRAGMENT = `
precision mediump float;
uniform vec4 colour;
uniform float lit, fade;
uniform vec3 eye;
varying vec3 facing;
varying vec3 place;
const vec3 LAMP = vec3(0.342, -0.440, 0.830);
void main() {
  vec3 shown = colour.rgb;
  if (lit > 0.0) {
    vec3 n = normalize(facing + vec3(0.0, 0.0, 1e-6));
    vec3 e = normalize(eye - place);
    float lamp = max(0.0, dot(n, LAMP));
    float light = 0.64 + 0.12 * n.z + 0.26 * lamp + 0.10 * max(0.0, dot(n, e));
    float shine = pow(max(0.0, dot(reflect(-e, n), LAMP)), 24.0);
    shown = mix(shown, shown * light + 0.12 * shine, lit);
  }
  float alpha = colour.a * (fade > 0.0 ? clamp(1.25 - length(place.xy) / fade, 0.0, 1.0) : 1.0);
  gl_FragColor = vec4(shown * alpha, alpha);
}`;

export class Renderer {
  constructor(canvas) {
    this.software = inSoftware();
    const gl = canvas.getContext("webgl", { antialias: !this.software, premultipliedAlpha: true });
    if (gl === null) throw new Error("this browser has no WebGL, which the spatial view needs");
    this.gl = gl;
    this.large = gl.getExtension("OES_element_index_uint") !== null; // meshes of any size
    const program = gl.createProgram();
    for (const [type, text] of [[gl.VERTEX_SHADER, VERTEX], [gl.FRAGMENT_SHADER, FRAGMENT]]) {
      const shader = gl.createShader(type);
      gl.shaderSource(shader, text);
      gl.compileShader(shader);
      if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(shader));
      gl.attachShader(program, shader);
    }
    gl.bindAttribLocation(program, 0, "position");
    gl.linkProgram(program);
    gl.useProgram(program);
    this.at = Object.fromEntries(["pose", "view", "size", "stretch", "colour", "lit", "fade", "eye"].map((name) => [name, gl.getUniformLocation(program, name)]));
    this.attributes = ["position", "normal", "end"].map((name) => gl.getAttribLocation(program, name));
    this.meshes = { capsule: null, box: this.mesh(box()), cylinder: this.mesh(cylinder()), ring: this.mesh(ring()), cone: this.mesh(cone()) };
    this.capsules = [this.mesh(capsule(8, 18)), this.mesh(capsule(14, 40))];
    this.ribbon = { buffer: gl.createBuffer(), count: 0 };
    gl.enable(gl.DEPTH_TEST);
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
  }

  mesh(vertices) {
    const { gl } = this;
    const buffer = gl.createBuffer();
    gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
    gl.bufferData(gl.ARRAY_BUFFER, outward(new Float32Array(vertices)), gl.STATIC_DRAW);
    return { buffer, count: vertices.length / 7, closed: true };
  }

  // A mesh of corners, position and normal (6 numbers each), and the corners of its triangles.
  indexed(corners, triangles) {
    const { gl } = this;
    const buffer = gl.createBuffer();
    gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
    gl.bufferData(gl.ARRAY_BUFFER, corners, gl.STATIC_DRAW);
    const index = gl.createBuffer();
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, index);
    gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, triangles, gl.STATIC_DRAW);
    return { buffer, index, count: triangles.length };
  }

  // A picture begins: `shown` is the height at which its pixels are seen; a `fine` one has rounder solids.
  begin(width, height, shown, fine, background, view, eye) {
    const { gl } = this;
    this.meshes.capsule = this.capsules[fine ? 1 : 0];
    gl.viewport(0, 0, width, height);
    gl.clearColor(...background, 1);
    gl.depthMask(true);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    gl.uniformMatrix4fv(this.at.view, false, view);
    gl.uniform3fv(this.at.eye, eye);
    this.frame = { shown, eye };
  }

  // What is drawn from here on lies on top of what was drawn before.
  onTop() {
    this.gl.clear(this.gl.DEPTH_BUFFER_BIT);
  }

  draw(mesh, pose, size, colour, { stretch = 0, alpha = 1, lit = 1, fade = 0 } = {}) {
    const { gl, at } = this;
    const { buffer, index, count, closed } = typeof mesh === "string" ? this.meshes[mesh] : mesh;
    gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
    [[3, 0], [3, 12], [1, 24]].forEach(([width, offset], k) => {
      if (this.attributes[k] < 0) return;
      if (index && offset === 24) return gl.disableVertexAttribArray(this.attributes[k]); // its value is then 0
      gl.enableVertexAttribArray(this.attributes[k]);
      gl.vertexAttribPointer(this.attributes[k], width, gl.FLOAT, false, index ? 24 : 28, offset);
    });
    gl.uniformMatrix4fv(at.pose, false, pose);
    gl.uniform3fv(at.size, size);
    gl.uniform1f(at.stretch, stretch);
    gl.uniform4f(at.colour, ...colour, alpha);
    gl.uniform1f(at.lit, lit);
    gl.uniform1f(at.fade, fade);
    gl.depthMask(alpha === 1);
    if (closed) gl.enable(gl.CULL_FACE);
    else gl.disable(gl.CULL_FACE);
    if (!index) return gl.drawArrays(gl.TRIANGLES, 0, count);
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, index);
    gl.drawElements(gl.TRIANGLES, count, gl.UNSIGNED_INT, 0);
  }

  // Line segments as pairs of points, facing the eye, `width` pixels wide.
  lines(pairs, colour, width, options = {}) {
    if (pairs.length === 0) return;
    const { gl } = this;
    const { shown, eye } = this.frame;
    const perPixel = (2 * Math.tan(FIELD / 2)) / shown;
    const data = [];
    for (const [a, b] of pairs) {
      const along = sub(b, a);
      if (norm(along) === 0) continue;
      const corner = (point, sign) => {
        const toEye = sub(eye, point);
        const side = unit(cross(along, toEye));
        const half = 0.5 * width * perPixel * norm(toEye) * sign;
        return [point[0] + side[0] * half, point[1] + side[1] * half, point[2] + side[2] * half, 0, 0, 1, 0];
      };
      const [p, q, r, s] = [corner(a, 1), corner(a, -1), corner(b, 1), corner(b, -1)];
      data.push(...p, ...q, ...r, ...r, ...q, ...s);
    }
    gl.bindBuffer(gl.ARRAY_BUFFER, this.ribbon.buffer);
    gl.bufferData(gl.ARRAY_BUFFER, new Float32Array(data), gl.DYNAMIC_DRAW);
    this.ribbon.count = data.length / 7;
    this.draw(this.ribbon, IDENTITY, [1, 1, 1], colour, { lit: 0, ...options });
  }
}

export const FIELD = 0.72; // angle of view [rad]

// Whether pictures are drawn by the processor: a context that is made for its name alone says so.
function inSoftware() {
  const gl = document.createElement("canvas").getContext("webgl");
  const named = gl?.getExtension("WEBGL_debug_renderer_info");
  const name = named ? gl.getParameter(named.UNMASKED_RENDERER_WEBGL) : "";
  gl?.getExtension("WEBGL_lose_context")?.loseContext();
  return /swiftshader|llvmpipe|softpipe|software|basic render/i.test(name);
}

// The corners of each triangle in the order that shows its outer face, where its normals point.
function outward(vertices) {
  for (let at = 0; at < vertices.length; at += 21) {
    const [a, b, c] = [0, 7, 14].map((k) => add([...vertices.subarray(at + k, at + k + 3)], [0, 0, vertices[at + k + 6]]));
    const normal = [3, 4, 5].map((k) => vertices[at + k] + vertices[at + 7 + k] + vertices[at + 14 + k]);
    if (dot(cross(sub(b, a), sub(c, a)), normal) >= 0) continue;
    const second = vertices.slice(at + 7, at + 14);
    vertices.copyWithin(at + 7, at + 14, at + 21);
    vertices.set(second, at + 14);
  }
  return vertices;
}

// Triangles as 7 numbers a vertex: position, normal, and 1 at the stretched end.
function surface(rows, columns, point) {
  const out = [];
  for (let i = 0; i < rows; i++) {
    for (let j = 0; j < columns; j++) {
      const [a, b, c, d] = [point(i, j), point(i + 1, j), point(i, j + 1), point(i + 1, j + 1)];
      out.push(...a, ...b, ...c, ...c, ...b, ...d);
    }
  }
  return out;
}

const TURN = 2 * Math.PI;

function capsule(rows, columns) {
  const half = rows / 2;
  return surface(rows + 1, columns, (i, j) => {
    const upper = i > half;
    const height = Math.PI * ((upper ? i - 1 : i) / rows - 0.5);
    const n = [Math.cos(height) * Math.cos((TURN * j) / columns), Math.cos(height) * Math.sin((TURN * j) / columns), Math.sin(height)];
    return [...n, ...n, upper ? 1 : 0];
  });
}

function cylinder(columns = 28) {
  const at = (j) => [Math.cos((TURN * j) / columns), Math.sin((TURN * j) / columns)];
  const side = surface(1, columns, (i, j) => [...at(j), 0, ...at(j), 0, i]);
  const lids = [0, 1].flatMap((end) => surface(1, columns, (i, j) => [...at(j).map((c) => c * i), 0, 0, 0, end ? 1 : -1, end]));
  return [...side, ...lids];
}

function cone(columns = 24) {
  const at = (j) => [Math.cos((TURN * j) / columns), Math.sin((TURN * j) / columns)];
  const side = surface(1, columns, (i, j) => [...at(j).map((c) => c * (1 - i)), i, ...at(j), 0.4, 0]);
  return [...side, ...surface(1, columns, (i, j) => [...at(j).map((c) => c * i), 0, 0, 0, -1, 0])];
}

function ring(rows = 44, columns = 5, thin = 0.022) {
  return surface(rows, columns, (i, j) => {
    const [a, b] = [(TURN * i) / rows, (TURN * j) / columns];
    const n = [Math.cos(a) * Math.cos(b), Math.sin(a) * Math.cos(b), Math.sin(b)];
    return [Math.cos(a) + thin * n[0], Math.sin(a) + thin * n[1], thin * n[2], ...n, 0];
  });
}

function box() {
  return [0, 1, 2].flatMap((axis) =>
    [-1, 1].flatMap((sign) =>
      surface(1, 1, (i, j) => {
        const [p, n] = [[0, 0, 0], [0, 0, 0]];
        p[axis] = n[axis] = sign;
        p[(axis + 1) % 3] = 2 * i - 1;
        p[(axis + 2) % 3] = 2 * j - 1;
        return [...p, ...n, 0];
      }),
    ),
  );
}

export function project(view, point, width, height) {
  const clip = (k) => view[k] * point[0] + view[4 + k] * point[1] + view[8 + k] * point[2] + view[12 + k];
  const w = clip(3);
  return [((clip(0) / w + 1) / 2) * width, ((1 - clip(1) / w) / 2) * height, w];
}

export { dot, multiply };
