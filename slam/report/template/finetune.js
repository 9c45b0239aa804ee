// The page of a fine-tuning: see slam/report/finetune_page.cpp for the data.
const data = JSON.parse(byId("data").textContent);
const curves = data.curves || {};
const measure = Object.fromEntries(data.measures.map((each) => [each.key, each]));

/// Lines over the epochs, each look a point.
function epochPlot(parent, {title, note, unit, lines}) {
  const epochs = curves.epoch || [];
  const drawn = lines.filter((line) => line.values && line.values.some(isNumber));
  if (epochs.length < 2 || drawn.length === 0) return;
  let plot = null;
  const keys = legendKeys(drawn, () => plot);
  const show = (i) => keys.values.forEach((value, k) => { value.textContent = isNumber(drawn[k].values[i]) ? digits(drawn[k].values[i], 4) : ""; });
  const box = h("div", {});
  parent.append(h("div", {class: "panel plot"}, h("h3", {}, title, note ? h("small", {}, note) : null, keys.element), box));
  const height = 230;
  plot = new uPlot({
    width: Math.max(200, box.clientWidth), height, legend: {show: false},
    cursor: {sync: {key: SYNC.key, setSeries: false, scales: ["x", null]}, drag: {x: false, y: false}, y: false, points: {size: 8}},
    scales: {x: {time: false}, y: {range: (u, low, high) => uPlot.rangeNum(low, high, 0.1, true)}},
    axes: [axis({size: 44, label: "epoch", incrs: [1, 2, 5, 10, 20, 50, 100]}), axis({size: 58, label: unit, values: (u, ticks) => ticks.map((t) => axisText(t, ticks))})],
    series: [{}, ...drawn.map((line) => ({
      label: line.label, stroke: () => cssColor(line.color), width: line.width || 1.8, dash: line.dash, spanGaps: false,
      points: {show: epochs.length <= 60, size: 5}}))],
    hooks: {setCursor: [(u) => show(isNumber(u.cursor.idx) ? u.cursor.idx : epochs.length - 1)]},
  }, [epochs, ...drawn.map((line) => line.values)], box);
  show(epochs.length - 1);
  new ResizeObserver(() => plot.setSize({width: Math.max(200, box.clientWidth), height})).observe(box);
  onTheme(() => plot.redraw(false));
}

/// [%] against the networks as given.
function changes(key) {
  const values = curves[key] || [];
  const first = values[0];
  return values.map((value) => (isNumber(value) && isNumber(first) && first > 0 ? 100 * (value - first) / first : null));
}

function showCurves() {
  const parent = byId("curve-plots");
  const line = (key, label, more) => ({label, values: curves[key], color: measure[key].color, ...more});
  epochPlot(parent, {title: "Self-supervised loss", note: "per dimension", unit: "loss", lines: [
    line("learned_loss", "learned from", {dash: [5, 4], width: 1.4}), line("held_out_loss", "held out")]});
  epochPlot(parent, {title: "True errors", note: "against the networks as given", unit: "%", lines: [
    ["vo_ate_m", "VO ATE"], ["imu_rotation_deg", "IMU rotation"], ["graph_ate_m", "Graph ATE"]]
    .map(([key, label]) => ({label, values: changes(key), color: measure[key].color}))});
  const scaled = (key, label) => ({label, color: measure[key].color, values: (curves[key] || []).map((v) => (isNumber(v) ? v * 1000 : null))});
  epochPlot(parent, {title: "Position error", note: "ATE", unit: "mm", lines: [scaled("vo_ate_m", "VO"), scaled("graph_ate_m", "Graph")]});
  epochPlot(parent, {title: "Motion error", note: "RPE per frame", unit: "mm", lines: [scaled("vo_rpe_m", "VO"), scaled("graph_rpe_m", "Graph")]});
  epochPlot(parent, {title: "Rotation error", note: "RPE per frame", unit: "deg", lines: [line("vo_rpe_deg", "VO"), line("graph_rpe_deg", "Graph")]});
  epochPlot(parent, {title: "IMU rotation", note: "open integration over 5 s", unit: "deg", lines: [line("imu_rotation_deg", "IMU")]});
  epochPlot(parent, {title: "IMU position", note: "open integration over 5 s", unit: "m", lines: [line("imu_position_m", "IMU")]});
}

[startTheme, showCurves, showSections].forEach(attempt);
