// The 3-D picture: robots with light and soft shadow, the floor, and the overlays of their balance.
"use strict";

const MESH_VERTEX = `#version 300 es
uniform mat4 view; uniform mat4 frames[FRAMES]; uniform vec3 ground; uniform vec3 sun; uniform vec3 middle; uniform int pass; uniform float grow;
in vec3 position; in vec3 normal; in vec3 colour; in float frame;
out vec3 n; out vec3 c; out vec3 at; out float world;
void main() {
  mat4 m = frames[int(frame)];
  n = mat3(m) * normal;
  vec4 p = m * vec4(position + grow * normal, 1.0);
  c = colour;
  world = frame < 0.5 ? 1.0 : 0.0;
  at = p.xyz;
  float height = dot(ground, p.xyz);
  if (pass == 1) p.xyz -= sun * max(height, 0.0) / dot(ground, sun);
  if (pass == 1 || pass == 2) {
    c = pass == 1 ? vec3(1.0, 0.0, 0.0) : vec3(0.0, exp(-max(height, 0.0) / 0.07), 0.0);
    if (world > 0.5) p.x += 1e3;
    gl_Position = vec4((p.xy - middle.xy) / SPAN, 0.0, 1.0);
  } else gl_Position = view * p;
}`.replace("SPAN", "0.9");
const SHADE = `
uniform sampler2D shade; uniform vec3 middle; uniform vec2 dark;
float shaded(vec3 at) {
  vec2 uv = 0.5 + 0.5 * (at.xy - middle.xy) / 0.9;
  if (any(lessThan(uv, vec2(0.0))) || any(greaterThan(uv, vec2(1.0)))) return 1.0;
  vec2 edge = min(uv, 1.0 - uv);
  vec2 s = texture(shade, uv).rg * smoothstep(0.0, 0.12, min(edge.x, edge.y));
  return (1.0 - dark.x * s.r) * (1.0 - dark.y * s.g);
}`;
const MESH_FRAGMENT = `#version 300 es
precision highp float;
precision highp int;
uniform vec3 sun; uniform vec4 tint; uniform int pass; uniform vec3 eye;
in vec3 n; in vec3 c; in vec3 at; in float world; out vec4 colour;
${SHADE}
void main() {
  if (pass != 0) { colour = pass == 3 ? tint : vec4(c, 1.0); return; }
  vec3 normal = normalize(n), to = normalize(eye - at), base = tint.r < 0.0 ? mix(c, vec3(0.5), tint.g) : tint.rgb;
  base *= base;
  float key = max(dot(normal, sun), 0.0), fill = max(dot(normal, vec3(-0.62, 0.55, 0.35)), 0.0);
  vec3 sky = mix(vec3(0.20, 0.19, 0.18), vec3(0.46, 0.49, 0.54), 0.5 + 0.5 * normal.z);
  float gloss = pow(max(dot(normal, normalize(sun + to)), 0.0), 38.0);
  float rim = pow(1.0 - max(dot(normal, to), 0.0), 4.0);
  vec3 light = base * (sky + key * vec3(0.66, 0.63, 0.58) + fill * vec3(0.12, 0.14, 0.18)) + 0.16 * gloss + 0.10 * rim;
  if (world > 0.5) light *= shaded(at);
  colour = vec4(sqrt(light), tint.a);
}`;
const FLAT_VERTEX = `#version 300 es
uniform mat4 view;
in vec3 position; in vec4 colour; out vec4 c;
void main() { c = colour; gl_Position = view * vec4(position, 1.0); }`;
const FLAT_FRAGMENT = `#version 300 es
precision highp float;
precision highp int;
in vec4 c; uniform float fade; out vec4 colour;
void main() { colour = vec4(c.rgb, c.a * fade); }`;
const FLOOR_VERTEX = `#version 300 es
uniform mat4 view; uniform vec3 ground; uniform vec3 middle;
in vec2 corner; out vec3 at;
void main() {
  at = vec3(middle.xy + corner, 0.0);
  at.z = -dot(ground.xy, at.xy) / ground.z;
  gl_Position = view * vec4(at, 1.0);
}`;
const FLOOR_FRAGMENT = `#version 300 es
precision highp float;
precision highp int;
uniform vec3 line; uniform vec3 floor_colour; uniform vec3 carpet_colour; uniform vec2 carpet; uniform float reach; in vec3 at; out vec4 colour;
${SHADE}
float lines(float cell, float wide) {
  vec2 unit = at.xy / cell, fine = fwidth(unit);
  vec2 near = abs(fract(unit - 0.5) - 0.5) / (fine * wide);
  return clamp(1.3 - min(near.x, near.y), 0.0, 1.0) * clamp(1.2 - 2.5 * max(fine.x, fine.y), 0.0, 1.0);
}
void main() {
  float away = length(at.xy - middle.xy) / reach, far = 1.0 - smoothstep(0.8, 4.5, away);
  bool green = all(lessThan(abs(at.xy), carpet));
  vec3 base = mix(green ? carpet_colour : floor_colour, line, (green ? 0.4 : 1.0) * max(0.16 * lines(0.1, 1.0), 0.5 * lines(0.5, 1.2)));
  colour = vec4(base * shaded(at), far);
}`;
const BLUR_VERTEX = `#version 300 es
in vec2 corner; out vec2 uv;
void main() { uv = 0.5 + 0.5 * corner; gl_Position = vec4(corner, 0.0, 1.0); }`;
const BLUR_FRAGMENT = `#version 300 es
precision highp float;
precision highp int;
uniform sampler2D source; uniform vec2 way; in vec2 uv; out vec4 colour;
void main() {
  vec2 sum = vec2(0.0);
  float all = 0.0;
  for (int i = -4; i <= 4; i++) {
    float weight = exp(-float(i * i) / 7.0);
    sum += weight * vec2(texture(source, uv + way * float(i)).r, texture(source, uv + 2.6 * way * float(i)).g);
    all += weight;
  }
  colour = vec4(sum / all, 0.0, 1.0);
}`;
const SUN = unit([0.38, -0.42, 0.82]);
const CREASE_COSINE = 0.6; // cosine of the angle over which an edge is drawn sharp
const CORNER_SIZE = 10; // numbers of a corner: position, normal, colour, link
const CASTER_CELL = 0.016; // m
const SHADOW_SIZE = { software: 128, card: 256 }; // pixels of the picture of the shadow
const REPORT_TIME = 170; // ms in which an object moves to where it is reported: they are reported as often
const SHADOW_REACH = 1.6; // m from the middle of the picture of the shadow to a robot that may cast some into it
const BLUR_STEP = 0.0047; // of that picture, between two samples of its blur
const RIBBON_WIDTH = 0.003, HALF_BAR_WIDTH = 0.006; // m: breadth of a line on the ground, half the breadth of a load's bar
const ARROW_SCALE = 0.18; // m/(N s)
const QUIET_COLOURS = [-1, 0.6, 0, 1], OWN_COLOURS = [-1, 0, 0, 1]; // tint of shapes in the colours that they have; the second number is the share of grey

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
  const near = 0.05, far = 60, f = 1 / Math.tan(0.3) / Math.max(1, 0.8 / aspect);
  const project = [f / aspect, 0, 0, 0, 0, f, 0, 0, 0, 0, (far + near) / (near - far), -1, 0, 0, (2 * far * near) / (near - far), 0];
  return multiply(project, [...view, dot(right), dot(up), dot(back), 1]);
}

// A frame's matrix from a place, a quaternion (w, x, y, z) and a scale of each axis.
function frameMatrix(out, at, [x0, y0, z0], [w, x, y, z], [a, b, c] = [1, 1, 1]) {
  const n = 2 / (w * w + x * x + y * y + z * z);
  out.set([
    a * (1 - n * (y * y + z * z)), a * n * (x * y + w * z), a * n * (x * z - w * y), 0,
    b * n * (x * y - w * z), b * (1 - n * (x * x + z * z)), b * n * (y * z + w * x), 0,
    c * n * (x * z + w * y), c * n * (y * z - w * x), c * (1 - n * (x * x + y * y)), 0,
    x0, y0, z0, 1,
  ], 16 * at);
}

// Corners with normals, smooth but sharp over an edge, and the three indices of each triangle, of a body's pieces.
function triangles({ vertices, faces }, pieces, body) {
  const out = [], indices = [];
  let v0 = 0, f0 = 0;
  for (const piece of pieces) {
    if (piece.body !== body) {
      v0 += piece.vertices;
      f0 += piece.faces;
      continue;
    }
    const sums = Array.from({ length: piece.vertices }, () => [0, 0, 0]), flats = [];
    const corner = (i) => [0, 1, 2].map((k) => vertices.at(v0 + i, k));
    for (let f = f0; f < f0 + piece.faces; f++) {
      const three = [0, 1, 2].map((k) => faces.at(f, k));
      const [a, b, c] = three.map(corner), normal = cross(minus(b, a), minus(c, a)); // as long as the face is large
      flats.push([three, unit(normal)]);
      for (const i of three) sums[i] = sums[i].map((x, k) => x + normal[k]);
    }
    const smooth = sums.map(unit), colour = piece.colour.map((x) => x / 255), shared = {};
    const add = (i, normal) => out.push(...corner(i), ...normal, ...colour, piece.link) / CORNER_SIZE - 1;
    for (const [three, flat] of flats)
      for (const i of three) {
        const along = smooth[i].reduce((sum, x, k) => sum + x * flat[k], 0);
        indices.push(along > CREASE_COSINE ? (shared[i] ??= add(i, smooth[i])) : add(i, flat));
      }
    v0 += piece.vertices;
    f0 += piece.faces;
  }
  return [new Float32Array(out), new Uint32Array(indices)];
}

// The triangles with corners in one cube of edge `CASTER_CELL` joined: the shadow needs no more of them.
function coarse(numbers, indices) {
  const first = new Map(), out = [];
  const joined = (i) => {
    const at = CORNER_SIZE * i, cube = [0, 1, 2].map((k) => Math.round(numbers[at + k] / CASTER_CELL)).join() + "," + numbers[at + 9];
    return first.get(cube) ?? (first.set(cube, i), i);
  };
  for (let i = 0; i < indices.length; i += 3) {
    const [a, b, c] = [0, 1, 2].map((k) => joined(indices[i + k]));
    if (a !== b && b !== c && c !== a) out.push(a, b, c);
  }
  return new Uint32Array(out);
}

// A ball of radius 1, a cube of edge 1, or an upright cylinder of diameter and height 1, as triangles. What is in the
// frame 0 is ground, on which shadows fall; balls and cylinders, in the frame 1, cast some.
// The ball has dark spots, so that one that has no tint is seen to roll.
function ball() {
  const out = [], n = 14;
  const point = (i, k) => [Math.sin((Math.PI * i) / n) * Math.cos((2 * Math.PI * k) / n), Math.sin((Math.PI * i) / n) * Math.sin((2 * Math.PI * k) / n), Math.cos((Math.PI * i) / n)];
  for (let i = 0; i < n; i++)
    for (let k = 0; k < n; k++)
      for (const [a, b] of [[0, 0], [1, 0], [1, 1], [0, 0], [1, 1], [0, 1]]) {
        const p = point(i + a, k + b);
        out.push(...p, ...p, ...(Math.max(...p.map(Math.abs)) > 0.93 ? [0.12, 0.12, 0.14] : [0.93, 0.93, 0.95]), 1);
      }
  return new Float32Array(out);
}

function cylinder() {
  const out = [], n = 24;
  const rim = (k, z) => [0.5 * Math.cos((2 * Math.PI * k) / n), 0.5 * Math.sin((2 * Math.PI * k) / n), z];
  const add = (p, normal) => out.push(...p, ...normal, 1, 1, 1, 1);
  for (let k = 0; k < n; k++) {
    for (const [a, z] of [[0, -0.5], [1, -0.5], [1, 0.5], [0, -0.5], [1, 0.5], [0, 0.5]]) add(rim(k + a, z), [...rim(k + a, 0).slice(0, 2).map((x) => 2 * x), 0]);
    for (const side of [-1, 1]) for (const p of [[0, 0, 0.5 * side], rim(k + (side < 0 ? 1 : 0), 0.5 * side), rim(k + (side < 0 ? 0 : 1), 0.5 * side)]) add(p, [0, 0, side]);
  }
  return new Float32Array(out);
}

function cube() {
  const out = [];
  for (let axis = 0; axis < 3; axis++)
    for (const side of [-0.5, 0.5])
      for (const [u, v] of [[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]]) {
        const p = [0, 0, 0], n = [0, 0, 0];
        p[axis] = side;
        n[axis] = 2 * side;
        [p[(axis + 1) % 3], p[(axis + 2) % 3]] = side > 0 ? [u, v] : [v, u]; // seen from outside each turns to the left
        out.push(...p, ...n, 1, 1, 1, 0);
      }
  return new Float32Array(out);
}

class Scene {
  constructor(canvas) {
    this.canvas = canvas;
    const software = /swiftshader|llvmpipe|software/i.test(renderer());
    const gl = (this.gl = canvas.getContext("webgl2", { alpha: false, antialias: !software, stencil: true }));
    if (!gl) throw new Error("this browser draws no 3-D pictures (WebGL 2)");
    Object.assign(this, { software, sharpest: software ? 1 : 2, sharpness: software ? 1 : 2, shadow: SHADOW_SIZE[software ? "software" : "card"] });
    this.flat = this.program(FLAT_VERTEX, FLAT_FRAGMENT);
    this.floor = this.program(FLOOR_VERTEX, FLOOR_FRAGMENT);
    this.blur = this.program(BLUR_VERTEX, BLUR_FRAGMENT);
    this.mesh = this.program(MESH_VERTEX.replace("FRAMES", 32), MESH_FRAGMENT);
    this.solid = { position: 3, normal: 3, colour: 3, frame: 1 };
    this.ball = this.buffer(this.mesh, this.solid, ball());
    this.cube = this.buffer(this.mesh, this.solid, cube());
    this.cylinder = this.buffer(this.mesh, this.solid, cylinder());
    this.drawn = this.buffer(this.flat, { position: 3, colour: 4 }, new Float32Array());
    const square = [-1, -1, 1, -1, 1, 1, -1, -1, 1, 1, -1, 1];
    this.plane = this.buffer(this.floor, { corner: 2 }, new Float32Array(square.map((x) => 20 * x)));
    this.square = this.buffer(this.blur, { corner: 2 }, new Float32Array(square));
    this.targets = [0, 1].map(() => this.target());
    this.frames = new Float32Array(16 * 32);
    this.one = new Float32Array(16 * 32);
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
    const places = {};
    return { program, at: (name) => (places[name] ??= gl.getUniformLocation(program, name)) };
  }

  buffer({ program }, fields, numbers, indices = null) {
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
    if (indices) {
      gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, gl.createBuffer());
      gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, indices, gl.STATIC_DRAW);
    }
    return { array, buffer, width, count: numbers.length / width, indices: indices?.length ?? 0 };
  }

  target() {
    const gl = this.gl, texture = gl.createTexture(), frame = gl.createFramebuffer();
    gl.bindTexture(gl.TEXTURE_2D, texture);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA8, this.shadow, this.shadow, 0, gl.RGBA, gl.UNSIGNED_BYTE, null);
    for (const side of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) gl.texParameteri(gl.TEXTURE_2D, side, gl.LINEAR);
    for (const side of [gl.TEXTURE_WRAP_S, gl.TEXTURE_WRAP_T]) gl.texParameteri(gl.TEXTURE_2D, side, gl.CLAMP_TO_EDGE);
    gl.bindFramebuffer(gl.FRAMEBUFFER, frame);
    gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, texture, 0);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    return { texture, frame };
  }

  // Fewer pixels where pictures take long, more where there is time; `interval` in ms from one picture to the next.
  adapt(interval) {
    this.pace = (this.pace ?? 33) + 0.08 * (Math.min(interval, 300) - (this.pace ?? 33));
    const factor = this.pace > 45 ? 0.97 : this.pace < 38 ? 1.02 : 1;
    this.sharpness = Math.min(Math.max(this.sharpness * factor, Math.min(0.5, this.sharpest)), this.sharpest);
  }

  // Shapes of a run's robot with the ground under it, and of other bodies in its world.
  load(run) {
    run.models ??= run.header.bodies.map(({ links }, body) => {
      const [numbers, indices] = triangles(run.shapes, run.header.pieces, body);
      return { links, shape: this.buffer(this.mesh, this.solid, numbers, indices), caster: this.buffer(this.mesh, this.solid, numbers, coarse(numbers, indices)) };
    });
  }

  // The other robots of the world of an actor.
  others({ run, moment, shift }) {
    return moment.others.map((other) => ({ moment: other, shift, model: run.models[other.body] }));
  }

  // actors: [{run, moment, shift, model}], options: {colours, camera, overlays, push}
  draw(actors, { colours, camera, overlays, push }) {
    const { gl, canvas } = this, aspect = canvas.width / canvas.height;
    this.view = cameraMatrix(camera.eye, camera.aim, aspect);
    this.header = actors[0].run.header;
    this.moving = actors[0].moment.objects;
    [this.middle, this.eye] = [camera.ground, camera.eye];
    this.shadows(actors);
    gl.viewport(0, 0, canvas.width, canvas.height);
    gl.clearColor(...colours.background, 1);
    gl.depthMask(true);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT | gl.STENCIL_BUFFER_BIT);
    gl.enable(gl.DEPTH_TEST);
    gl.enable(gl.CULL_FACE);
    this.begin(camera, colours);
    for (const actor of actors) {
      this.place(actor);
      this.solids(actor.model.shape, OWN_COLOURS, 0);
      for (const other of this.others(actor)) {
        this.place(other);
        this.solids(other.model.shape, QUIET_COLOURS, 0);
      }
    }
    for (const actor of actors) this.lights(actor);
    this.objects();
    gl.disable(gl.CULL_FACE);
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA);
    gl.depthMask(false);
    this.ground(camera, colours);
    this.flats(this.lines(), 1);
    if (overlays.estimate) for (const actor of actors) this.outline(actor, colours);
    for (const actor of actors) this.marks(actor, overlays, push);
    gl.disable(gl.BLEND);
  }

  begin(camera, colours) {
    const { gl, mesh } = this;
    gl.useProgram(mesh.program);
    gl.uniformMatrix4fv(mesh.at("view"), false, this.view);
    gl.uniform3fv(mesh.at("eye"), camera.eye);
    this.light(mesh, colours);
  }

  light(program, colours) {
    const { gl } = this;
    gl.uniform3fv(program.at("sun"), SUN);
    gl.uniform3fv(program.at("ground"), this.header.floor);
    gl.uniform3fv(program.at("middle"), this.middle);
    if (!colours) return;
    gl.bindTexture(gl.TEXTURE_2D, this.targets[0].texture);
    gl.uniform1i(program.at("shade"), 0);
    gl.uniform2fv(program.at("dark"), colours.shadow);
  }

  // The shadow on the floor, by the sun (red) and by closeness (green), blurred.
  shadows(actors) {
    const { gl, targets } = this;
    gl.disable(gl.DEPTH_TEST);
    gl.viewport(0, 0, this.shadow, this.shadow);
    gl.bindFramebuffer(gl.FRAMEBUFFER, targets[0].frame);
    gl.clearColor(0, 0, 0, 1);
    gl.clear(gl.COLOR_BUFFER_BIT);
    gl.enable(gl.BLEND);
    gl.blendEquation(gl.MAX);
    gl.useProgram(this.mesh.program);
    gl.bindTexture(gl.TEXTURE_2D, null);
    this.light(this.mesh);
    const near = ({ moment: { torso } }) => Math.hypot(torso[0] - this.middle[0], torso[1] - this.middle[1]) < SHADOW_REACH;
    for (const actor of [...actors, ...actors.flatMap((each) => this.others(each)).filter(near)]) {
      this.place(actor);
      for (const pass of [1, 2]) this.solids(actor.model.caster, [0, 0, 0, 1], pass);
    }
    for (const pass of [1, 2]) this.objects(pass);
    gl.blendEquation(gl.FUNC_ADD);
    gl.disable(gl.BLEND);
    gl.useProgram(this.blur.program);
    gl.bindVertexArray(this.square.array);
    [[BLUR_STEP, 0], [0, BLUR_STEP]].forEach((way, i) => {
      gl.bindFramebuffer(gl.FRAMEBUFFER, targets[1 - i].frame);
      gl.bindTexture(gl.TEXTURE_2D, targets[i].texture);
      gl.uniform2fv(this.blur.at("way"), way);
      gl.drawArrays(gl.TRIANGLES, 0, 6);
    });
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
  }

  place({ moment, shift, model }, pose = moment) {
    frameMatrix(this.frames, 0, [0, 0, 0], [1, 0, 0, 0]);
    model.links.forEach((_, i) => {
      const at = pose.position.slice(3 * i, 3 * i + 3).map((x, k) => x + shift[k]);
      frameMatrix(this.frames, 1 + i, at, pose.attitude.slice(4 * i, 4 * i + 4));
    });
    this.gl.useProgram(this.mesh.program);
    this.gl.uniformMatrix4fv(this.mesh.at("frames"), false, this.frames);
  }

  solids(shapes, tint, pass, grow = 0) {
    const gl = this.gl;
    gl.uniform4fv(this.mesh.at("tint"), tint);
    gl.uniform1i(this.mesh.at("pass"), pass);
    gl.uniform1f(this.mesh.at("grow"), grow);
    gl.bindVertexArray(shapes.array);
    if (shapes.indices) gl.drawElements(gl.TRIANGLES, shapes.indices, gl.UNSIGNED_INT, 0);
    else gl.drawArrays(gl.TRIANGLES, 0, shapes.count);
  }

  single(shapes, at, attitude, size, tint, pass = 0) {
    for (const frame of [0, 1]) frameMatrix(this.one, frame, at, attitude, size);
    this.gl.useProgram(this.mesh.program);
    this.gl.uniformMatrix4fv(this.mesh.at("frames"), false, this.one);
    this.solids(shapes, tint, pass);
  }

  objects(pass = 0) {
    for (const [n, object] of this.header.objects.entries()) {
      const pose = object.moves ? this.moving[n] : objectPose(object); // the moving ones come first
      if (!pose) continue;
      const { shape, size, colour } = object, { position, attitude } = pose;
      if (shape === "ball") this.single(this.ball, position, attitude, size.map((edge) => 0.5 * edge), OWN_COLOURS, pass);
      else this.single(shape === "pole" ? this.cylinder : this.cube, position, attitude, size, [...colour.map((x) => x / 255), 1], pass);
    }
  }

  ground(camera, colours) {
    const { gl, floor } = this;
    gl.useProgram(floor.program);
    gl.uniformMatrix4fv(floor.at("view"), false, this.view);
    this.light(floor, colours);
    gl.uniform3fv(floor.at("line"), colours.grid);
    gl.uniform3fv(floor.at("floor_colour"), colours.floor);
    gl.uniform3fv(floor.at("carpet_colour"), colours.carpet);
    gl.uniform2fv(floor.at("carpet"), (this.header.field?.size ?? [0, 0]).map((edge) => 0.5 * edge));
    gl.uniform1f(floor.at("reach"), Math.max(1, Math.hypot(...minus(camera.eye, camera.aim)) / 2));
    gl.bindVertexArray(this.plane.array);
    gl.drawArrays(gl.TRIANGLES, 0, 6);
  }

  // White lines of the field.
  lines() {
    const { field, floor } = this.header, out = [];
    for (const [x, y, u, v, width] of field?.stripes ?? []) {
      const [a, b] = unit([u - x, v - y]).map((part) => 0.5 * width * part); // along it; (-b, a) is across
      const corner = (px, py, along, across) => [px + along * a - across * b, py + along * b + across * a];
      const quad = [corner(x, y, -1, -1), corner(u, v, 1, -1), corner(u, v, 1, 1), corner(x, y, -1, 1)];
      for (const i of [0, 1, 2, 0, 2, 3]) out.push(...quad[i], -(floor[0] * quad[i][0] + floor[1] * quad[i][1]) / floor[2], 1, 1, 1, 1);
    }
    return out;
  }

  // The estimated pose as an outline, whatever it is behind.
  outline(actor, colours) {
    const { gl } = this;
    this.place(actor, actor.run.estimate(actor.moment));
    gl.disable(gl.DEPTH_TEST);
    gl.enable(gl.STENCIL_TEST);
    gl.stencilFunc(gl.ALWAYS, 1, 1);
    gl.stencilOp(gl.KEEP, gl.KEEP, gl.REPLACE);
    gl.colorMask(false, false, false, false);
    this.solids(actor.model.shape, [0, 0, 0, 1], 3);
    gl.colorMask(true, true, true, true);
    gl.stencilFunc(gl.EQUAL, 0, 1);
    this.solids(actor.model.shape, [...colours.estimate, 1], 3, 0.003);
    gl.clear(gl.STENCIL_BUFFER_BIT);
    gl.disable(gl.STENCIL_TEST);
    gl.enable(gl.DEPTH_TEST);
  }

  // Overlays, solid where they are seen and faint through the body.
  marks(actor, overlays, push) {
    const { gl } = this, { run, moment, shift } = actor;
    this.place(actor);
    const moved = (corners) => corners.map((p) => p.map((x, k) => x + shift[k])), { colours } = run.header;
    if (overlays.footsteps) this.flats(moment.footprints.flatMap(({ kind, corners }) => ribbon(moved(corners), colours[kind], 0.9)), 1);
    const support = overlays.support ? this.support(moved(moment.support.corners), moment.support.tips, colours) : [];
    const { com, com_ground: below } = moment.points, { colour } = run.header.points.find(({ name }) => name === "com");
    const plumb = overlays.com ? ribbon(moved([com, below]), colour, 0.9, false) : [];
    const arrow = push && Math.hypot(...push) > 0.02 ? this.arrow(actor, push) : [];
    this.flats([...support, ...arrow, ...(overlays.forces ? this.bars(run, moment) : [])], 1);
    this.balls(actor, overlays, 1);
    gl.disable(gl.DEPTH_TEST);
    this.flats([...support, ...plumb, ...arrow], 0.4);
    this.balls(actor, overlays, 0.55);
    gl.enable(gl.DEPTH_TEST);
  }

  flats(numbers, fade) {
    const { gl, drawn, flat } = this;
    if (!numbers.length) return;
    gl.useProgram(flat.program);
    gl.uniformMatrix4fv(flat.at("view"), false, this.view);
    gl.uniform1f(flat.at("fade"), fade);
    gl.bindVertexArray(drawn.array);
    gl.bindBuffer(gl.ARRAY_BUFFER, drawn.buffer);
    gl.bufferData(gl.ARRAY_BUFFER, new Float32Array(numbers), gl.DYNAMIC_DRAW);
    gl.drawArrays(gl.TRIANGLES, 0, numbers.length / drawn.width);
  }

  balls({ run, moment, shift }, overlays, fade) {
    run.header.points.forEach((point) => {
      const at = moment.points[point.name].map((x, k) => x + shift[k]), r = point.radius;
      if (!overlays[point.overlay] || at.some(Number.isNaN)) return;
      this.single(this.ball, at, [1, 0, 0, 0], point.name === "com" ? [r, r, r] : [r, r, 0.35 * r], [...point.colour.map((c) => c / 255), fade]);
    });
  }

  // LEDs that shine, a lamp for each group.
  lights(actor) {
    if (!actor.moment.lights.some((c) => c > 5)) return;
    this.place(actor);
    actor.run.header.lamps.forEach(({ link, at: [x, y, z], radius }, i) => {
      const rgb = actor.moment.lights.slice(3 * i, 3 * i + 3).map((c) => c / 255), m = this.frames.subarray(16 * link, 16 * link + 16);
      if (!rgb.some((c) => c > 0.02)) return;
      this.single(this.ball, [0, 1, 2].map((k) => m[k] * x + m[4 + k] * y + m[8 + k] * z + m[12 + k]), [1, 0, 0, 0], [radius, radius, radius], [...rgb, 1]);
    });
  }

  support(corners, tips, colours) {
    if (corners.length < 3) return [];
    const colour = colours[tips ? "lost" : "safe"], rgb = colour.map((c) => c / 255), area = [];
    for (let i = 1; i < corners.length - 1; i++)
      for (const p of [corners[0], corners[i], corners[i + 1]]) area.push(...p, ...rgb, 0.22);
    return [...area, ...ribbon(corners, colour, 1)];
  }

  bars({ header }, moment) {
    const { safe, lost } = header.colours, out = [];
    header.cells.forEach((cell, i) => {
      const force = Math.max(moment.loads[i], 0), share = Math.min(force / cell.range, 1);
      const rgb = safe.map((c, k) => (c + share * (lost[k] - c)) / 255);
      const m = this.frames.subarray(16 * cell.link, 16 * cell.link + 16), [x, y, z] = cell.at;
      const at = [0, 1, 2].map((k) => m[k] * x + m[4 + k] * y + m[8 + k] * z + m[12 + k]), top = at[2] + header.newton * force;
      const [a, b] = unit([this.eye[1] - at[1], at[0] - this.eye[0]]).map((x) => HALF_BAR_WIDTH * x); // it faces the camera
      const quad = [[-a, -b, at[2]], [a, b, at[2]], [a, b, top], [-a, -b, at[2]], [a, b, top], [-a, -b, top]];
      for (const [dx, dy, height] of quad) out.push(at[0] + dx, at[1] + dy, height, ...rgb, 1);
    });
    return out;
  }

  // A push, N s, forward and to the left of the robot; its head touches the shell.
  arrow({ moment, shift }, [x, y]) {
    const c = Math.cos(moment.heading), s = Math.sin(moment.heading), way = [ARROW_SCALE * (c * x - s * y), ARROW_SCALE * (s * x + c * y), 0];
    const along = unit(way), head = moment.torso.map((p, k) => p + shift[k] - 0.09 * along[k] + (k === 2 ? 0.06 : 0)), tail = minus(head, way);
    const side = [-along[1], along[0], 0], rgb = [0.988, 0.769, 0.098, 1], out = [];
    const neck = head.map((p, k) => p - 0.035 * along[k]);
    for (const wide of [side, [0, 0, 1]]) {
      const p = (q, w) => [...q.map((v, k) => v + w * wide[k]), ...rgb];
      out.push(...p(tail, 0.007), ...p(tail, -0.007), ...p(neck, -0.007), ...p(tail, 0.007), ...p(neck, -0.007), ...p(neck, 0.007));
      out.push(...p(neck, 0.02), ...p(neck, -0.02), ...p(head, 0));
    }
    return out;
  }

  // Where a point of the world is on the canvas, in its pixels on the page; null behind the camera.
  project([x, y, z]) {
    const m = this.view, w = m[3] * x + m[7] * y + m[11] * z + m[15];
    if (w <= 0) return null;
    const [u, v] = [0, 1].map((k) => (m[k] * x + m[4 + k] * y + m[8 + k] * z + m[12 + k]) / w);
    return [0.5 * (1 + u) * this.canvas.clientWidth, 0.5 * (1 - v) * this.canvas.clientHeight];
  }
}

// Pose of an object on its way from the last one that was reported, `before`, since the time `since`, ms.
function objectPose({ position, attitude, before, since }) {
  const share = before ? Math.min((performance.now() - since) / REPORT_TIME, 1) : 1;
  if (share === 1) return { position, attitude };
  const flip = attitude.reduce((sum, x, k) => sum + x * before.attitude[k], 0) < 0 ? -1 : 1;
  return { position: position.map((x, k) => before.position[k] + share * (x - before.position[k])), attitude: attitude.map((x, k) => flip * before.attitude[k] * (1 - share) + share * x) };
}

function renderer() {
  const gl = document.createElement("canvas").getContext("webgl"), extension = gl?.getExtension("WEBGL_debug_renderer_info");
  const name = extension ? gl.getParameter(extension.UNMASKED_RENDERER_WEBGL) : "";
  gl?.getExtension("WEBGL_lose_context")?.loseContext();
  return name;
}

// A line on the ground as triangles, closed or not.
function ribbon(corners, colour, alpha, closed = true) {
  const out = [], rgb = colour.map((c) => c / 255);
  corners.slice(0, closed ? undefined : -1).forEach((a, i) => {
    const b = corners[(i + 1) % corners.length], way = unit(minus(b, a)), level = Math.hypot(way[0], way[1]) > 0.05;
    const side = (level ? [-way[1], way[0], 0] : [0.7, 0.7, 0]).map((x) => 0.5 * RIBBON_WIDTH * x);
    const p = (q, s) => q.map((x, k) => x + s * side[k]);
    for (const v of [p(a, 1), p(a, -1), p(b, -1), p(a, 1), p(b, -1), p(b, 1)]) out.push(...v, ...rgb, alpha);
  });
  return out;
}
