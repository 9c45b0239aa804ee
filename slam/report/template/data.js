// The page's data: see slam/report/page_data.hpp for the layout.
const data = JSON.parse(byId("data").textContent);
const metrics = data.metrics || {};

function bytes(text) {
  const binary = atob(text || "");
  const out = new Uint8Array(binary.length);
  for (let i = 0; i < binary.length; ++i) out[i] = binary.charCodeAt(i);
  return out;
}
const floats = (text) => new Float32Array(bytes(text).buffer);

/// {count, time, position, rotation}; positions count from data.origin.
function decodeTrajectory(packed) {
  return {
    count: packed.count, time: floats(packed.time),
    position: floats(packed.position), rotation: floats(packed.rotation),
  };
}
const trajectories = {};
for (const name of ["truth", "vo", "graph"]) {
  if (data.trajectories[name]) trajectories[name] = decodeTrajectory(data.trajectories[name]);
}
const main_trajectory = trajectories.graph || trajectories.vo || trajectories.truth || null;

const series = {};
for (const [name, packed] of Object.entries(data.series || {})) {
  // uPlot wants null for gaps.
  series[name] = Array.from(floats(packed), (value) => (Number.isFinite(value) ? value : null));
}
const hasSeries = (name) => name in series && series[name].some((value) => value !== null);

/// Index of the last entry of sorted `times` that is not after `time` (at least 0).
function indexAt(times, time) {
  let low = 0, high = times.length - 1;
  while (low < high) {
    const middle = (low + high + 1) >> 1;
    if (times[middle] <= time) low = middle; else high = middle - 1;
  }
  return low;
}

/// {position [3], rotation [4]} at `time`, interpolated.
function poseAt(trajectory, time) {
  const i = indexAt(trajectory.time, time);
  const j = Math.min(i + 1, trajectory.count - 1);
  const span = trajectory.time[j] - trajectory.time[i];
  const part = span > 0 ? Math.min(1, Math.max(0, (time - trajectory.time[i]) / span)) : 0;
  const blend = (values, width, sign) => Array.from({length: width}, (_, k) =>
    values[i * width + k] * (1 - part) + sign * values[j * width + k] * part);
  let dot = 0;
  for (let k = 0; k < 4; ++k) dot += trajectory.rotation[i * 4 + k] * trajectory.rotation[j * 4 + k];
  const rotation = blend(trajectory.rotation, 4, dot < 0 ? -1 : 1);
  const norm = Math.hypot(...rotation) || 1;
  return {position: blend(trajectory.position, 3, 1), rotation: rotation.map((q) => q / norm)};
}

function seriesAt(name, time) {
  if (!series[name] || !series.time_s) return null;
  return series[name][indexAt(series.time_s, time)];
}

const multiply = ([ax, ay, az, aw], [bx, by, bz, bw]) => [
  aw * bx + ax * bw + ay * bz - az * by, aw * by - ax * bz + ay * bw + az * bx,
  aw * bz + ax * by - ay * bx + az * bw, aw * bw - ax * bx - ay * by - az * bz];

/// Roll, pitch and yaw [deg] of R(t) R_start^T: turns about world axes since the start, which has
/// no gimbal lock for whatever way the sensor is mounted.
function attitude(trajectory, start) {
  const inverse = [-start[0], -start[1], -start[2], start[3]];
  const angles = [[], [], []];
  const turn = 180 / Math.PI;
  for (let i = 0; i < trajectory.count; ++i) {
    const [x, y, z, w] = multiply(Array.from(trajectory.rotation.subarray(4 * i, 4 * i + 4)), inverse);
    const now = [
      Math.atan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y)) * turn,
      Math.asin(Math.max(-1, Math.min(1, 2 * (w * y - z * x)))) * turn,
      Math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z)) * turn];
    now.forEach((angle, k) => {
      const before = i > 0 ? angles[k][i - 1] : 0;
      angles[k].push(k === 1 ? angle : angle - 360 * Math.round((angle - before) / 360));
    });
  }
  return angles;
}

const sorted = (values) => Array.from(values).filter(Number.isFinite).sort((a, b) => a - b);
const quantile = (ordered, part) => ordered[Math.min(ordered.length - 1, Math.floor(part * ordered.length))];
