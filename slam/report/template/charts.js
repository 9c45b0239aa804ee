// Which plots there are.
const column = (name) => (hasSeries(name) ? series[name] : null);
const scaled = (name, factor) => column(name) && series[name].map((value) => (value === null ? null : value * factor));

// Truth may come less often than frames: errors are joined across the frames between.
function errorPlots() {
  const parent = byId("error-plots");
  const small = (name) => { const all = column(name); return all && quantile(sorted(all), 0.9) < 0.1; };
  const millimetres = small("graph_error_m") && (!column("vo_error_m") || small("vo_error_m"));
  const factor = millimetres ? 1000 : 1;
  timePlot(parent, {
    title: column("graph_error_m") || column("vo_error_m") ? "Position error" : "Position uncertainty", unit: millimetres ? "mm" : "m", time: series.time_s, fromZero: true, lines: [
      {label: "1σ", values: scaled("position_sigma_m", factor), color: "truth", width: 1.2, dash: [4, 4]},
      {label: "VO", values: scaled("vo_error_m", factor), color: "vo", join: true},
      {label: "Graph", values: scaled("graph_error_m", factor), color: "graph", join: true, width: 2}]});
  timePlot(parent, {
    title: "Rotation error", unit: "deg", time: series.time_s, fromZero: true, lines: [
      {label: "VO", values: column("vo_error_deg"), color: "vo", join: true},
      {label: "Graph", values: column("graph_error_deg"), color: "graph", join: true, width: 2}]});
}

/// Values of all trajectories on the stamps of the main one; null outside of a trajectory's span.
function onMainStamps(trajectory, values) {
  const times = main_trajectory.time;
  return Array.from(times, (time) => {
    if (time < trajectory.time[0] - 1e-3 || time > trajectory.time[trajectory.count - 1] + 1e-3) return null;
    const i = indexAt(trajectory.time, time);
    const j = Math.min(i + 1, trajectory.count - 1);
    const span = trajectory.time[j] - trajectory.time[i];
    const part = span > 0 ? Math.max(0, (time - trajectory.time[i]) / span) : 0;
    return values[i] + (values[j] - values[i]) * part;
  });
}

function axisPlots() {
  if (!main_trajectory) return;
  const parent = byId("axis-plots");
  const time = Array.from(main_trajectory.time);
  const start = Array.from(main_trajectory.rotation.subarray(0, 4));
  const angles = {};
  for (const [name, trajectory] of Object.entries(trajectories)) {
    angles[name] = attitude(trajectory, start);
    const turns = Math.round((angles[name][2][0] || 0) / 360) * 360;
    angles[name][2] = angles[name][2].map((yaw) => yaw - turns);
  }
  const lines = (values) => Object.entries(trajectories).map(([name, trajectory]) => ({
    label: {truth: "Truth", vo: "VO", graph: "Graph"}[name], color: name === "truth" ? "band" : name,
    width: {truth: 6, vo: 1.5, graph: 1.8}[name], values: onMainStamps(trajectory, values(name, trajectory))}));
  ["x", "y", "z"].forEach((title, k) => timePlot(parent, {title, unit: "m", time, height: 180,
    lines: lines((name, trajectory) => Array.from({length: trajectory.count}, (_, i) => trajectory.position[3 * i + k] + data.origin[k]))}));
  ["Roll", "Pitch", "Yaw"].forEach((title, k) => timePlot(parent, {title, note: "since the start, about world axes", unit: "deg", time, height: 180,
    lines: lines((name) => angles[name][k])}));
}

function sensorPlots() {
  const parent = byId("sensor-plots");
  const three = (prefix, factor) => ["x", "y", "z"].map((axisName, k) => ({
    label: axisName, values: scaled(prefix + axisName, factor), color: ["graph", "vo", "third"][k]}));
  timePlot(parent, {title: "Speed", unit: "m/s", time: series.time_s, fromZero: true, lines: [{label: "Speed", values: column("speed_m_s"), color: "graph"}]});
  timePlot(parent, {title: "Inliers of visual odometry", unit: "points", time: series.time_s, fromZero: true,
    lines: [{label: "Inliers", values: column("inliers"), color: "third", width: 1.2}]});
  timePlot(parent, {title: "Gyroscope bias", unit: "mrad/s", time: series.time_s, lines: three("gyro_bias_", 1000)});
  timePlot(parent, {title: "Accelerometer bias", unit: "m/s²", time: series.time_s, lines: three("accel_bias_", 1)});
}

function runtimePlots() {
  const parent = byId("runtime-plots");
  timePlot(parent, {title: "Time per frame", unit: "ms", time: series.time_s, fromZero: true, lines: [{label: "Frame", values: column("frame_ms"), color: "graph", width: 1.2}]});
  timePlot(parent, {title: "Resident memory", unit: "MB", time: series.time_s, fromZero: true, lines: [{label: "Memory", values: column("memory_mb"), color: "third"}]});
}
