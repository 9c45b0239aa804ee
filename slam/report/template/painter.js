// Two WebGL 2 programs: lines of any width in pixels, and round points.
const LINE_VERTEX = `#version 300 es
in vec2 corner; in vec3 a; in vec3 b; in vec3 colorA; in vec3 colorB; in float timeA;
uniform mat4 view; uniform vec2 size; uniform float width; uniform float now; uniform float nearest;
out vec3 color; out float faded; out float across;
void main() {
  vec4 A = view * vec4(a, 1.0), B = view * vec4(b, 1.0);
  if (A.w < nearest && B.w < nearest) { gl_Position = vec4(2.0, 2.0, 2.0, 1.0); return; }
  if (A.w < nearest) A = mix(A, B, (nearest - A.w) / (B.w - A.w));
  if (B.w < nearest) B = mix(B, A, (nearest - B.w) / (A.w - B.w));
  vec2 along = (B.xy / B.w - A.xy / A.w) * size;
  float reach = length(along);
  along = reach > 1e-6 ? along / reach : vec2(1.0, 0.0);
  vec2 offset = (vec2(-along.y, along.x) * corner.y + along * (corner.x * 2.0 - 1.0) * 0.35) * (width + 1.0);
  vec4 P = corner.x < 0.5 ? A : B;
  gl_Position = P + vec4(offset / size * P.w, 0.0, 0.0);
  color = mix(colorA, colorB, corner.x);
  faded = timeA > now ? 1.0 : 0.0;
  across = corner.y * (width + 1.0);
}`;
const LINE_FRAGMENT = `#version 300 es
precision highp float;
in vec3 color; in float faded; in float across;
uniform float width; uniform float alpha; out vec4 result;
void main() {
  float edge = clamp((width + 1.0 - abs(across)) * 0.5, 0.0, 1.0);
  result = vec4(color, alpha * edge * mix(1.0, 0.22, faded));
}`;
const POINT_VERTEX = `#version 300 es
in vec3 a; in vec3 colorA;
uniform mat4 view; uniform float diameter; uniform vec2 limits; uniform vec2 fog;
out vec3 color; out float haze;
void main() {
  gl_Position = view * vec4(a, 1.0);
  gl_PointSize = clamp(diameter / max(gl_Position.w, 1e-6), limits.x, limits.y);
  color = colorA;
  haze = clamp((gl_Position.w - fog.x) / fog.y, 0.0, 0.72);
}`;
const POINT_FRAGMENT = `#version 300 es
precision highp float;
in vec3 color; in float haze; uniform vec3 sky; uniform float alpha; out vec4 result;
void main() {
  if (length(gl_PointCoord - 0.5) > 0.5) discard;
  result = vec4(mix(color, sky, haze), alpha);
}`;

function makeProgram(gl, vertex, fragment) {
  const program = gl.createProgram();
  for (const [kind, text] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
    const shader = gl.createShader(kind);
    gl.shaderSource(shader, text);
    gl.compileShader(shader);
    if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(shader));
    gl.attachShader(program, shader);
  }
  gl.linkProgram(program);
  if (!gl.getProgramParameter(program, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(program));
  const uniforms = {};
  for (let i = 0; i < gl.getProgramParameter(program, gl.ACTIVE_UNIFORMS); ++i) {
    const {name} = gl.getActiveUniform(program, i);
    uniforms[name] = gl.getUniformLocation(program, name);
  }
  return {program, uniforms, at: (name) => gl.getAttribLocation(program, name)};
}

class Painter {
  constructor(gl) {
    this.gl = gl;
    this.lines = makeProgram(gl, LINE_VERTEX, LINE_FRAGMENT);
    this.points = makeProgram(gl, POINT_VERTEX, POINT_FRAGMENT);
    this.corners = this.buffer(new Float32Array([0, -1, 0, 1, 1, -1, 1, 1]));
  }

  buffer(values, old) {
    const {gl} = this;
    const buffer = old || gl.createBuffer();
    gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
    gl.bufferData(gl.ARRAY_BUFFER, values, gl.DYNAMIC_DRAW);
    return buffer;
  }

  attribute(program, name, buffer, width, type, stride, offset, divisor) {
    const {gl} = this;
    const place = program.at(name);
    if (place < 0) return;
    gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
    gl.enableVertexAttribArray(place);
    gl.vertexAttribPointer(place, width, type, type === gl.UNSIGNED_BYTE, stride, offset);
    gl.vertexAttribDivisor(place, divisor);
  }

  /// shape: {count, positions, colors (uint8 rgb), times}; `step` 1 joins all points to one line,
  /// 2 makes each pair a segment of its own.
  drawLine(shape, {view, size, width, alpha, now, nearest, step = 1}) {
    const {gl, lines} = this;
    const segments = step === 1 ? shape.count - 1 : shape.count / 2;
    if (segments < 1) return;
    gl.useProgram(lines.program);
    gl.uniformMatrix4fv(lines.uniforms.view, false, view);
    gl.uniform2fv(lines.uniforms.size, size);
    gl.uniform1f(lines.uniforms.width, width);
    gl.uniform1f(lines.uniforms.alpha, alpha);
    gl.uniform1f(lines.uniforms.now, now);
    gl.uniform1f(lines.uniforms.nearest, nearest);
    this.attribute(lines, "corner", this.corners, 2, gl.FLOAT, 8, 0, 0);
    this.attribute(lines, "a", shape.positions, 3, gl.FLOAT, 12 * step, 0, 1);
    this.attribute(lines, "b", shape.positions, 3, gl.FLOAT, 12 * step, 12, 1);
    this.attribute(lines, "colorA", shape.colors, 3, gl.UNSIGNED_BYTE, 3 * step, 0, 1);
    this.attribute(lines, "colorB", shape.colors, 3, gl.UNSIGNED_BYTE, 3 * step, 3, 1);
    this.attribute(lines, "timeA", shape.times, 1, gl.FLOAT, 4 * step, 0, 1);
    gl.drawArraysInstanced(gl.TRIANGLE_STRIP, 0, 4, segments);
  }

  drawPoints(shape, {view, diameter, limits, fog, sky, alpha = 1}) {
    const {gl, points} = this;
    gl.useProgram(points.program);
    gl.uniformMatrix4fv(points.uniforms.view, false, view);
    gl.uniform1f(points.uniforms.diameter, diameter);
    gl.uniform2fv(points.uniforms.limits, limits);
    gl.uniform2fv(points.uniforms.fog, fog);
    gl.uniform3fv(points.uniforms.sky, sky);
    gl.uniform1f(points.uniforms.alpha, alpha);
    this.attribute(points, "a", shape.positions, 3, gl.FLOAT, 12, 0, 0);
    this.attribute(points, "colorA", shape.colors, 3, gl.UNSIGNED_BYTE, 3, 0, 0);
    gl.drawArrays(gl.POINTS, 0, shape.count);
  }
}
