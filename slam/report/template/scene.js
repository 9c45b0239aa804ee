// The 3-D view: map points, trajectories, ground grid and the body axes at the play-head.
const VIRIDIS = [[68, 1, 84], [72, 40, 120], [62, 73, 137], [49, 104, 142], [38, 130, 142], [31, 158, 137],
  [53, 183, 121], [110, 206, 88], [181, 222, 43], [253, 231, 37]];
const HEAT = [[38, 110, 200], [64, 170, 190], [120, 200, 120], [240, 205, 70], [235, 130, 50], [205, 45, 60]];

function ramp(palette, part) {
  const x = Math.max(0, Math.min(1, part || 0)) * (palette.length - 1);
  const i = Math.min(palette.length - 2, Math.floor(x));
  return palette[i].map((value, k) => value + (palette[i + 1][k] - value) * (x - i));
}
const rgb = (hex) => [1, 3, 5].map((i) => parseInt(hex.slice(i, i + 2), 16));
const LAYER_NAMES = {truth: "Ground truth", vo: "Visual odometry", graph: "Graph"};

class Scene {
  constructor(canvas) {
    const gl = canvas.getContext("webgl2", {antialias: true, alpha: true, premultipliedAlpha: false, preserveDrawingBuffer: true});
    if (!gl) throw new Error("WebGL 2 is not available");
    Object.assign(this, {canvas, gl, dirty: false, follow: false, mapColor: "height", graphColor: "plain", mapSize: 1});
    this.visible = {truth: true, vo: true, graph: true, map: true};
    this.painter = new Painter(gl);
    this.camera = new OrbitCamera(canvas, () => this.redraw());
    this.lines = {};
    this.decodeMap();
    this.frame();
    this.build();
    new ResizeObserver(() => this.redraw()).observe(canvas);
    clock.on(() => this.redraw());
    onTheme(() => { this.build(); this.redraw(); });
  }

  decodeMap() {
    if (!data.map) return;
    const cells = new Int16Array(bytes(data.map.points).buffer);
    const points = new Float32Array(cells.length);
    for (let i = 0; i < cells.length; ++i) points[i] = cells[i] * data.map.scale + data.map.center[i % 3];
    this.map = {points, count: data.map.count, intensity: data.map.intensity ? bytes(data.map.intensity) : null};
    this.mapColor = "height";
  }

  /// Centre and radius of what there is, without the map's outliers.
  frame() {
    const low = [], high = [];
    for (let k = 0; k < 3; ++k) {
      let values = [];
      for (const line of Object.values(trajectories)) {
        for (let i = k; i < line.position.length; i += 3) values.push(line.position[i]);
      }
      const path = sorted(values);
      low[k] = path[0] || 0; high[k] = path[path.length - 1] || 0;
      if (!this.map) continue;
      values = [];
      const step = 3 * Math.max(1, Math.floor(this.map.count / 20000));
      for (let i = k; i < this.map.points.length; i += step) values.push(this.map.points[i]);
      const points = sorted(values);
      low[k] = Math.min(low[k], quantile(points, 0.03)); high[k] = Math.max(high[k], quantile(points, 0.97));
    }
    this.low = low; this.high = high;
    this.radius = Math.max(0.3, 0.5 * Math.hypot(...subtract(high, low)));
    this.camera.reset(low.map((value, k) => 0.5 * (value + high[k])), this.radius);
  }

  build() {
    this.sky = rgb(cssColor("sky")).map((value) => value / 255);
    for (const [name, line] of Object.entries(trajectories)) {
      const old = this.lines[name] || {};
      this.lines[name] = {
        count: line.count,
        positions: this.painter.buffer(line.position, old.positions),
        times: this.painter.buffer(line.time, old.times),
        colors: this.painter.buffer(this.lineColors(name, line), old.colors),
        halo: this.painter.buffer(new Uint8Array(3 * line.count).fill(0).map((_, i) => this.sky[i % 3] * 255), old.halo),
      };
    }
    this.buildMap();
    this.buildGrid();
  }

  lineColors(name, line) {
    const colors = new Uint8Array(3 * line.count);
    const plain = rgb(cssColor(name === "truth" ? "band" : name));
    const column = this.graphColor === "rotation" ? "graph_error_deg" : "graph_error_m";
    const byError = name === "graph" && this.graphColor !== "plain" && hasSeries(column);
    if (byError) {
      const errors = sorted(series[column]);
      this.errorRange = [0, quantile(errors, 0.98), column.endsWith("deg") ? "°" : "m"];
    }
    for (let i = 0; i < line.count; ++i) {
      colors.set(byError ? ramp(HEAT, seriesAt(column, line.time[i]) / this.errorRange[1]) : plain, 3 * i);
    }
    return colors;
  }

  buildMap() {
    if (!this.map) return;
    const {points, count, intensity} = this.map;
    const colors = new Uint8Array(3 * count);
    const dark = this.sky[0] < 0.5;
    const plain = rgb(cssColor("truth"));
    const span = Math.max(1e-6, this.high[2] - this.low[2]);
    for (let i = 0; i < count; ++i) {
      const light = intensity ? intensity[i] / 255 : 0.6;
      let color = plain;
      if (this.mapColor === "height") {
        color = ramp(VIRIDIS, (points[3 * i + 2] - this.low[2]) / span);
        color = color.map((value) => (dark ? value * (0.5 + 0.7 * light) + 12 : value * (0.55 + 0.5 * light)));
      } else if (this.mapColor === "brightness") {
        color = Array(3).fill(dark ? 45 + 205 * light : 15 + 190 * light);
      }
      for (let k = 0; k < 3; ++k) colors[3 * i + k] = Math.min(255, color[k]);
    }
    const old = this.cloud || {};
    this.cloud = {count, positions: old.positions || this.painter.buffer(points), colors: this.painter.buffer(colors, old.colors)};
  }

  buildGrid() {
    const power = Math.pow(10, Math.floor(Math.log10(this.radius / 4)));
    const step = power * [1, 2, 5, 10].find((factor) => factor * power >= this.radius / 5);
    const [cx, cy] = this.camera.center.map((value) => Math.round(value / step) * step);
    const half = Math.ceil(1.5 * this.radius / step);
    const z = this.low[2] - 0.02 * this.radius;
    const points = [];
    for (let i = -half; i <= half; ++i) {
      points.push(cx + i * step, cy - half * step, z, cx + i * step, cy + half * step, z);
      points.push(cx - half * step, cy + i * step, z, cx + half * step, cy + i * step, z);
    }
    this.gridStep = step;
    this.grid = this.segments(points, () => rgb(cssColor("faint")), this.grid);
  }

  segments(points, color, old = {}) {
    const count = points.length / 3;
    const colors = new Uint8Array(points.length);
    for (let i = 0; i < count; ++i) colors.set(color(i), 3 * i);
    return {
      count, positions: this.painter.buffer(new Float32Array(points), old.positions),
      colors: this.painter.buffer(colors, old.colors), times: this.painter.buffer(new Float32Array(count).fill(-1e30), old.times),
    };
  }

  /// x red, y green, z blue, and a dot for each trajectory.
  buildHead() {
    const shown = Object.keys(trajectories).filter((name) => this.visible[name]);
    const length = Math.max(0.02 * this.radius, 0.045 * this.camera.distance);
    const axes = [], heads = [], colors = [];
    const AXES = [[229, 72, 77], [48, 164, 108], [62, 99, 221]];
    for (const name of shown) {
      const {position, rotation} = poseAt(trajectories[name], clock.now);
      heads.push(...position);
      colors.push(rgb(cssColor(name)));
      if (name !== shown[shown.length - 1]) continue;
      if (this.follow) this.camera.target = position.slice();
      for (let k = 0; k < 3; ++k) {
        const axis = rotate(rotation, [0, 1, 2].map((i) => (i === k ? length : 0)));
        axes.push(...position, ...position.map((value, i) => value + axis[i]));
      }
    }
    this.axes = this.segments(axes, (i) => AXES[i >> 1], this.axes);
    this.heads = this.segments(heads, (i) => colors[i], this.heads);
    this.rims = this.segments(heads, () => this.sky.map((value) => value * 255), this.rims);
  }

  redraw() {
    if (this.dirty) return;
    this.dirty = true;
    requestAnimationFrame(() => { this.dirty = false; this.draw(); });
  }

  draw() {
    const {gl, canvas, painter, camera} = this;
    const ratio = Math.min(window.devicePixelRatio || 1, 2);
    const width = Math.round(canvas.clientWidth * ratio), height = Math.round(canvas.clientHeight * ratio);
    if (width < 2 || height < 2) return;
    if (canvas.width !== width || canvas.height !== height) Object.assign(canvas, {width, height});
    this.buildHead();
    gl.viewport(0, 0, width, height);
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    gl.enable(gl.BLEND);
    gl.blendFuncSeparate(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA, gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
    const view = camera.matrix(width / height);
    const common = {view, size: [width, height], now: 1e30, nearest: 0.002 * Math.max(camera.distance, camera.radius)};
    const sight = {view, sky: this.sky, fog: [camera.distance * 0.9, camera.radius * 5]};
    gl.disable(gl.DEPTH_TEST);
    painter.drawLine(this.grid, {...common, width: ratio * 0.5, alpha: 0.32, step: 2});
    gl.enable(gl.DEPTH_TEST);
    if (this.cloud && this.visible.map) {
      const diameter = this.mapSize * 0.0065 * this.radius * height / Math.tan(FIELD / 2) / 2;
      painter.drawPoints(this.cloud, {...sight, diameter, limits: [1.7 * ratio, 9 * ratio]});
    }
    gl.disable(gl.DEPTH_TEST);  // trajectories stay visible through walls
    for (const [name, wide] of [["truth", 7], ["vo", 1.9], ["graph", 2.6]]) {
      const line = this.lines[name];
      if (!line || !this.visible[name]) continue;
      const now = clock.now;
      if (name !== "truth") painter.drawLine({...line, colors: line.halo}, {...common, now, width: ratio * (wide + 2), alpha: 0.5});
      painter.drawLine(line, {...common, now, width: ratio * wide, alpha: 1});
    }
    painter.drawLine(this.axes, {...common, width: ratio * 3, alpha: 1, step: 2});
    const flat = {...sight, fog: [1e30, 1], diameter: 1e30};
    painter.drawPoints(this.rims, {...flat, limits: [1, 13 * ratio]});
    painter.drawPoints(this.heads, {...flat, limits: [1, 9 * ratio]});
  }
}
