// Plots over time (uPlot). All share cursor, zoom and play-head.
const plots = [];
const SYNC = uPlot.sync("imslam");
let zooming = false;

function axis(extra) {
  const font = "11.5px system-ui, sans-serif";
  return {
    stroke: () => cssColor("soft"), font, labelFont: font, labelSize: 16, labelGap: 0, size: 46, gap: 4,
    grid: {stroke: () => cssColor("line"), width: 1}, ticks: {stroke: () => cssColor("line"), width: 1, size: 4}, ...extra,
  };
}

/// Marks the spans in which the estimate was degraded.
function shadeDegraded(u) {
  if (!hasSeries("degraded")) return;
  const {ctx, bbox} = u;
  ctx.save();
  ctx.fillStyle = cssColor("degraded");
  let begin = null;
  series.degraded.forEach((bad, i) => {
    const time = series.time_s[i];
    if (bad && begin === null) begin = time;
    const last = i === series.degraded.length - 1;
    if (begin === null || (bad && !last)) return;
    const left = Math.max(bbox.left, u.valToPos(begin, "x", true));
    const right = Math.min(bbox.left + bbox.width, u.valToPos(time, "x", true));
    if (right > left) ctx.fillRect(left, bbox.top, Math.max(right - left, 2), bbox.height);
    begin = null;
  });
  ctx.restore();
}

function zoomTogether(u, key) {
  if (key !== "x" || zooming) return;
  zooming = true;
  const {min, max} = u.scales.x;
  for (const other of plots) {
    if (other !== u) other.setScale("x", {min, max});
  }
  zooming = false;
}

function addPlayhead(u) {
  const line = h("div", {class: "playhead"});
  u.over.append(line);
  const move = () => {
    const x = u.valToPos(clock.now, "x");
    line.hidden = !(x >= 0 && x <= u.over.clientWidth);
    line.style.transform = `translateX(${x}px)`;
  };
  clock.on(move);
  u.hooks.setScale.push(move);
  u.hooks.setSize = [move];
  u.over.addEventListener("mousemove", (event) => {
    if (clock.playing || event.buttons) return;
    clock.set(u.posToVal(event.clientX - u.over.getBoundingClientRect().left, "x"));
  });
  move();
}

/// lines: [{label, values, color (name of a CSS variable), width, dash}]
function legendKeys(lines, plotOf) {
  const values = [];
  const buttons = lines.map((line, i) => {
    const value = h("b", {}, "");
    values.push(value);
    const mark = h("i", {});
    const paint = () => { mark.style.background = cssColor(line.color); };
    onTheme(paint);
    paint();
    const button = h("button", {type: "button", "aria-pressed": "true", onclick: () => {
      const shown = !plotOf().series[i + 1].show;
      plotOf().setSeries(i + 1, {show: shown});
      button.setAttribute("aria-pressed", shown);
    }}, mark, line.label, value);
    return button;
  });
  return {element: h("span", {class: "keys"}, buttons), values};
}

function timePlot(parent, {title, note, unit, time, lines, height = 210, fromZero = false}) {
  const drawn = lines.filter((line) => line.values && line.values.some((value) => value !== null));
  if (!time || drawn.length === 0) return;
  let plot = null;
  const keys = legendKeys(drawn, () => plot);
  const box = h("div", {});
  const panel = h("div", {class: "panel plot"}, h("h3", {}, title, note ? h("small", {}, note) : null, keys.element), box);
  parent.append(panel);
  const range = fromZero ? (u, low, high) => [0, (high || 1) * 1.08] : (u, low, high) => uPlot.rangeNum(low, high, 0.1, true);
  plot = new uPlot({
    width: Math.max(200, box.clientWidth), height, legend: {show: false},
    cursor: {sync: {key: SYNC.key, setSeries: false, scales: ["x", null]}, drag: {x: true, y: false}, y: false, points: {size: 6}},
    scales: {x: {time: false}, y: {range}},
    axes: [axis({size: 30, values: (u, ticks) => ticks.map((t) => t + " s")}), axis({label: unit, values: (u, ticks) => ticks.map((t) => axisText(t, ticks))})],
    series: [{}, ...drawn.map((line) => ({
      label: line.label, stroke: () => cssColor(line.color), width: line.width || 1.6, dash: line.dash, spanGaps: !!line.join,
      points: {show: false}}))],
    hooks: {
      drawClear: [shadeDegraded], setScale: [zoomTogether],
    },
  }, [time, ...drawn.map((line) => line.values)], box);
  plots.push(plot);
  addPlayhead(plot);
  const showValues = () => keys.values.forEach((value, i) => {
    const now = drawn[i].values[indexAt(time, clock.now)];
    value.textContent = isNumber(now) ? digits(now) : "";
  });
  clock.on(showValues);
  showValues();
  new ResizeObserver(() => plot.setSize({width: Math.max(200, box.clientWidth), height})).observe(box);
  onTheme(() => plot.redraw(false));
}

function axisText(value, ticks) {
  const step = ticks.length > 1 ? Math.abs(ticks[1] - ticks[0]) : 1;
  if (Math.abs(value) > 0 && (step < 1e-4 || Math.abs(value) >= 1e6)) return value.toExponential(1);
  let decimals = 0;  // as many as the step needs: 2.5 has one, 0.0025 four
  while (decimals < 9 && Math.abs(step * 10 ** decimals - Math.round(step * 10 ** decimals)) > 1e-6 * step * 10 ** decimals) ++decimals;
  return value.toFixed(decimals);
}
