// The 3-D picture: the robot, its shadow, what it stands on, and the points of its balance.
"use strict";

const MESH_VERTEX = `#version 300 es
uniform mat4 view; uniform mat4 frames[FRAMES]; uniform vec3 ground; uniform vec3 sun; uniform bool shadow;
in vec3 position; in vec3 normal; in vec3 colour; in float frame;
out vec3 n; out vec3 c;
void main() {
  mat4 m = frames[int(frame)];
  vec4 p = m * vec4(position, 1.0);
  if (shadow) p.xyz -= sun * max(dot(ground, p.xyz) - 0.0015, 0.0) / dot(ground, sun);
  n = mat3(m) * normal;
  c = colour;
  gl_Position = view * p;
}`;
const MESH_FRAGMENT = `#version 300 es
precision highp float;
uniform vec3 sun; uniform vec4 tint; uniform bool shadow;
in vec3 n; in vec3 c; out vec4 colour;
void main() {
  if (shadow) { colour = tint; return; }
  vec3 normal = normalize(n);
  float light = 0.34 + 0.2 * (0.5 + 0.5 * normal.z) + 0.5 * max(dot(normal, sun), 0.0);
  vec3 base = tint.r < 0.0 ? c : tint.rgb;
  colour = vec4(base * light, tint.a);
}`;
const FLAT_VERTEX = `#version 300 es
uniform mat4 view;
in vec3 position; in vec4 colour; out vec4 c;
void main() { c = colour; gl_Position = view * vec4(position, 1.0); }`;
const FLAT_FRAGMENT = `#version 300 es
precision highp float;
in vec4 c; uniform float fade; out vec4 colour;
void main() { colour = vec4(c.rgb, c.a * fade); }`;
const GRID_VERTEX = `#version 300 es
uniform mat4 view; uniform vec3 ground; uniform vec2 middle;
in vec2 corner; out vec2 at;
void main() {
  at = middle + corner;
  gl_Position = view * vec4(at, -(ground.x * at.x + ground.y * at.y) / ground.z, 1.0);
}`;
const GRID_FRAGMENT = `#version 300 es
precision highp float;
uniform vec3 line; uniform vec2 middle; in vec2 at; out vec4 colour;
float lines(float cell, float wide) {
  vec2 unit = at / cell;
  vec2 near = abs(fract(unit - 0.5) - 0.5) / (fwidth(unit) * wide);
  return clamp(1.3 - min(near.x, near.y), 0.0, 1.0);
}
void main() {
  float far = 1.0 - smoothstep(1.5, 5.0, length(at - middle));
  colour = vec4(line, far * max(0.35 * lines(0.1, 1.0), 0.8 * lines(0.5, 1.4)));
}`;
const SUN = unit([0.35, -0.45, 0.82]);
const CREASE = 0.7; // cosine of the angle over which an edge is drawn sharp
const RIBBON = 0.003; // m, breadth of a line on the ground
const BAR = 0.004; // m, half the breadth of a load's bar

function unit(v) {
  const n = Math.hypot(...v) || 1;
  return v.map((x) => x / n);
}

function cross(a, b) {
  return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
}

function minus(a, b) {
  return a.map((x, i) => x - b[i]);
}

function multiply(a, b) {
  const out = new Float32Array(16);
  for (let column = 0; column < 4; column++)
    for (let row = 0; row < 4; row++)
      for (let k = 0; k < 4; k++) out[4 * column + row] += a[4 * k + row] * b[4 * column + k];
  return out;
}

// The projection of a camera that looks from `eye` at `aim`, z up.
function cameraMatrix(eye, aim, aspect) {
  const back = unit(minus(eye, aim)), right = unit(cross([0, 0, 1], back)), up = cross(back, right);
  const dot = (v) => -(v[0] * eye[0] + v[1] * eye[1] + v[2] * eye[2]);
  const view = [right, up, back].flatMap((_, i) => [right[i], up[i], back[i], 0]);
  const near = 0.05, far = 60, f = 1 / Math.tan(0.32) / Math.max(1, 0.8 / aspect);
  const project = [f / aspect, 0, 0, 0, 0, f, 0, 0, 0, 0, (far + near) / (near - far), -1, 0, 0, (2 * far * near) / (near - far), 0];
  return multiply(project, [...view, dot(right), dot(up), dot(back), 1]);
}

// A frame's matrix from a place and a quaternion (w, x, y, z).
function frameMatrix(out, at, [x0, y0, z0], [w, x, y, z], size = 1) {
  const n = size / (w * w + x * x + y * y + z * z);
  out.set([
    size - 2 * n * (y * y + z * z), 2 * n * (x * y + w * z), 2 * n * (x * z - w * y), 0,
    2 * n * (x * y - w * z), size - 2 * n * (x * x + z * z), 2 * n * (y * z + w * x), 0,
    2 * n * (x * z + w * y), 2 * n * (y * z - w * x), size - 2 * n * (x * x + y * y), 0,
    x0, y0, z0, 1,
  ], 16 * at);
}

// Triangles with normals: smooth, but sharp over an edge.
function triangles(vertices, faces, pieces) {
  const out = [];
  let v0 = 0, f0 = 0;
  for (const piece of pieces) {
    const sums = Array.from({ length: piece.vertices }, () => [0, 0, 0]), flats = [];
    const corner = (i) => [0, 1, 2].map((k) => vertices.at(v0 + i, k));
    for (let f = f0; f < f0 + piece.faces; f++) {
      const three = [0, 1, 2].map((k) => faces.at(f, k));
      const [a, b, c] = three.map(corner), normal = cross(minus(b, a), minus(c, a)); // as long as the face is large
      flats.push([three, unit(normal)]);
      for (const i of three) sums[i] = sums[i].map((x, k) => x + normal[k]);
    }
    const smooth = sums.map(unit);
    for (const [three, flat] of flats)
      for (const i of three) {
        const along = smooth[i].reduce((sum, x, k) => sum + x * flat[k], 0);
        out.push(...corner(i), ...(along > CREASE ? smooth[i] : flat), ...piece.colour.map((x) => x / 255), piece.link);
      }
    v0 += piece.vertices;
    f0 += piece.faces;
  }
  return new Float32Array(out);
}

// A ball of radius 1 as triangles in the frame 0.
function ball() {
  const out = [], n = 18;
  const point = (i, k) => {
    const polar = (Math.PI * i) / n, around = (2 * Math.PI * k) / n;
    return [Math.sin(polar) * Math.cos(around), Math.sin(polar) * Math.sin(around), Math.cos(polar)];
  };
  for (let i = 0; i < n; i++)
    for (let k = 0; k < n; k++)
      for (const [a, b] of [[0, 0], [1, 0], [1, 1], [0, 0], [1, 1], [0, 1]]) {
        const p = point(i + a, k + b);
        out.push(...p, ...p, 1, 1, 1, 0);
      }
  return new Float32Array(out);
}

class Scene {
  constructor(canvas, data) {
    this.canvas = canvas;
    this.data = data;
    const gl = (this.gl = canvas.getContext("webgl2", { alpha: false, antialias: true, stencil: true }));
    if (!gl) throw new Error("this browser draws no 3-D pictures (WebGL 2)");
    this.count = 1 + data.links.length;
    this.mesh = this.program(MESH_VERTEX.replace("FRAMES", this.count), MESH_FRAGMENT);
    this.flat = this.program(FLAT_VERTEX, FLAT_FRAGMENT);
    this.grid = this.program(GRID_VERTEX, GRID_FRAGMENT);
    const solid = { position: 3, normal: 3, colour: 3, frame: 1 };
    this.robot = this.buffer(this.mesh, solid, triangles(data.tables.vertices, data.tables.faces, data.pieces));
    this.ball = this.buffer(this.mesh, solid, ball());
    this.drawn = this.buffer(this.flat, { position: 3, colour: 4 }, new Float32Array());
    this.plane = this.buffer(this.grid, { corner: 2 }, new Float32Array([-6, -6, 6, -6, 6, 6, -6, -6, 6, 6, -6, 6]));
    this.frames = new Float32Array(16 * this.count);
    this.one = new Float32Array(16 * this.count);
  }

  program(vertex, fragment) {
    const gl = this.gl, program = gl.createProgram();
    for (const [kind, text] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, text);
      gl.compileShader(shader);
      gl.attachShader(program, shader);
    }
    gl.linkProgram(program);
    if (!gl.getProgramParameter(program, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(program));
    const at = (name) => gl.getUniformLocation(program, name);
    return { program, at };
  }

  buffer({ program }, fields, numbers) {
    const gl = this.gl, array = gl.createVertexArray(), buffer = gl.createBuffer();
    const width = Object.values(fields).reduce((a, b) => a + b, 0);
    gl.bindVertexArray(array);
    gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
    gl.bufferData(gl.ARRAY_BUFFER, numbers, gl.DYNAMIC_DRAW);
    let offset = 0;
    for (const [name, size] of Object.entries(fields)) {
      const place = gl.getAttribLocation(program, name);
      gl.enableVertexAttribArray(place);
      gl.vertexAttribPointer(place, size, gl.FLOAT, false, 4 * width, 4 * offset);
      offset += size;
    }
    return { array, buffer, width, count: numbers.length / width };
  }

  draw(moment, camera, colours) {
    const { gl, data, canvas } = this;
    const [r, g, b] = colours.background;
    gl.viewport(0, 0, canvas.width, canvas.height);
    gl.clearColor(r, g, b, 1);
    gl.clearStencil(0);
    gl.depthMask(true);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT | gl.STENCIL_BUFFER_BIT);
    gl.enable(gl.DEPTH_TEST);
    gl.blendFunc(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA);
    const view = cameraMatrix(camera.eye, camera.aim, canvas.width / canvas.height);
    this.place(moment);
    gl.useProgram(this.mesh.program);
    gl.uniformMatrix4fv(this.mesh.at("view"), false, view);
    gl.uniform3fv(this.mesh.at("sun"), SUN);
    gl.uniform3fv(this.mesh.at("ground"), data.floor);
    gl.uniformMatrix4fv(this.mesh.at("frames"), false, this.frames);
    this.solids(this.robot, [-1, 0, 0, 1], false);

    gl.enable(gl.BLEND);
    gl.depthMask(false);
    gl.useProgram(this.grid.program);
    gl.uniformMatrix4fv(this.grid.at("view"), false, view);
    gl.uniform3fv(this.grid.at("ground"), data.floor);
    gl.uniform2fv(this.grid.at("middle"), camera.aim.slice(0, 2));
    gl.uniform3fv(this.grid.at("line"), colours.grid);
    gl.bindVertexArray(this.plane.array);
    gl.drawArrays(gl.TRIANGLES, 0, 6);

    gl.useProgram(this.mesh.program);
    gl.enable(gl.STENCIL_TEST); // each point of the ground is darkened once
    gl.stencilFunc(gl.EQUAL, 0, 1);
    gl.stencilOp(gl.KEEP, gl.KEEP, gl.INCR);
    this.solids(this.robot, [0, 0, 0, colours.shadow], true);
    gl.disable(gl.STENCIL_TEST);

    this.flats(view, this.prints(moment), 1);
    const stands = this.support(moment);
    this.flats(view, [...stands, ...this.bars(moment)], 1);
    this.balls(moment, 1);
    gl.disable(gl.DEPTH_TEST); // and through the body
    this.flats(view, stands, 0.45);
    this.balls(moment, 0.5);
    gl.disable(gl.BLEND);
  }

  place(moment) {
    frameMatrix(this.frames, 0, [0, 0, 0], [1, 0, 0, 0]);
    this.data.links.forEach((_, i) => {
      frameMatrix(this.frames, 1 + i, moment.position.slice(3 * i, 3 * i + 3), moment.attitude.slice(4 * i, 4 * i + 4));
    });
  }

  solids(shapes, tint, shadow) {
    const gl = this.gl;
    gl.uniform4fv(this.mesh.at("tint"), tint);
    gl.uniform1i(this.mesh.at("shadow"), shadow);
    gl.bindVertexArray(shapes.array);
    gl.drawArrays(gl.TRIANGLES, 0, shapes.count);
  }

  flats(view, numbers, fade) {
    const { gl, drawn } = this;
    gl.useProgram(this.flat.program);
    gl.uniformMatrix4fv(this.flat.at("view"), false, view);
    gl.uniform1f(this.flat.at("fade"), fade);
    gl.bindVertexArray(drawn.array);
    gl.bindBuffer(gl.ARRAY_BUFFER, drawn.buffer);
    gl.bufferData(gl.ARRAY_BUFFER, new Float32Array(numbers), gl.DYNAMIC_DRAW);
    gl.drawArrays(gl.TRIANGLES, 0, numbers.length / drawn.width);
    gl.useProgram(this.mesh.program);
  }

  balls(moment, fade) {
    const gl = this.gl;
    this.data.points.forEach((point, i) => {
      const at = moment.points.slice(3 * i, 3 * i + 3);
      if (at.some(Number.isNaN)) return;
      frameMatrix(this.one, 0, at, [1, 0, 0, 0], point.radius);
      gl.uniformMatrix4fv(this.mesh.at("frames"), false, this.one);
      this.solids(this.ball, [...point.colour.map((c) => c / 255), fade], false);
    });
    gl.uniformMatrix4fv(this.mesh.at("frames"), false, this.frames);
  }

  prints(moment) {
    const kinds = ["planned", "made"];
    return moment.footprints.flatMap(({ kind, corners }) => outline(corners, this.data.colours[kinds[kind]], 0.9));
  }

  support(moment) {
    const { corners, tips } = moment.support;
    if (corners.length < 3) return [];
    const colour = this.data.colours[tips ? "lost" : "safe"], rgb = colour.map((c) => c / 255);
    const area = [];
    for (let i = 1; i < corners.length - 1; i++)
      for (const p of [corners[0], corners[i], corners[i + 1]]) area.push(...p, ...rgb, 0.25);
    return [...area, ...outline(corners, colour, 1)];
  }

  bars(moment) {
    const { safe, lost } = this.data.colours, out = [];
    this.data.cells.forEach((cell, i) => {
      const force = Math.max(moment.loads[i], 0), share = Math.min(force / cell.range, 1);
      const rgb = safe.map((c, k) => (c + share * (lost[k] - c)) / 255);
      const m = this.frames.subarray(16 * cell.link, 16 * cell.link + 16), [x, y, z] = cell.at;
      const at = [0, 1, 2].map((k) => m[k] * x + m[4 + k] * y + m[8 + k] * z + m[12 + k]);
      const top = at[2] + this.data.newton * force;
      for (const [a, b] of [[BAR, 0], [0, BAR], [BAR, BAR], [BAR, -BAR]]) {
        const quad = [[-a, -b, at[2]], [a, b, at[2]], [a, b, top], [-a, -b, at[2]], [a, b, top], [-a, -b, top]];
        for (const [dx, dy, height] of quad) out.push(at[0] + dx, at[1] + dy, height, ...rgb, 1);
      }
    });
    return out;
  }
}

// A closed line on the ground as triangles.
function outline(corners, colour, alpha) {
  const out = [], rgb = colour.map((c) => c / 255);
  corners.forEach((a, i) => {
    const b = corners[(i + 1) % corners.length], way = unit(minus(b, a));
    const side = [-way[1] * RIBBON * 0.5, way[0] * RIBBON * 0.5, 0];
    const p = (q, s) => [q[0] + s * side[0], q[1] + s * side[1], q[2]];
    for (const v of [p(a, 1), p(a, -1), p(b, -1), p(a, 1), p(b, -1), p(b, 1)]) out.push(...v, ...rgb, alpha);
  });
  return out;
}
