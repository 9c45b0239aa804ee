// Box plots of the relative pose error, and time per stage.
function boxGlyph(box, name, x, width, y) {
  const middle = x + width / 2;
  const line = (x1, y1, x2, y2, extra = "") => s("line", {class: `${name}-line ${extra}`, x1, y1, x2, y2});
  const [text, unit] = withUnit(box.median, "m");
  return s("g", {},
    line(middle, y(box.high), middle, y(box.q3)), line(middle, y(box.q1), middle, y(box.low)),
    line(middle - width / 4, y(box.high), middle + width / 4, y(box.high)),
    line(middle - width / 4, y(box.low), middle + width / 4, y(box.low)),
    s("rect", {class: `box ${name}-box`, x, width, y: y(box.q3), height: Math.max(1, y(box.q1) - y(box.q3)), rx: 2}),
    line(x, y(box.median), x + width, y(box.median), "median"),
    s("title", {}, `median ${text} ${unit}, ${box.count} samples, largest ${withUnit(box.max, "m").join(" ")}`));
}

function showBoxes() {
  const rows = (data.rpe || []).filter((row) => row.graph || row.vo);
  if (rows.length === 0) return;
  const [W, H, left, bottom, top] = [600, 540, 54, 38, 12];  // as tall as the table beside it
  const highest = Math.max(...rows.flatMap((row) => [row.graph, row.vo]).filter(Boolean).map((box) => box.high), 1e-9) * 1.06;
  const small = highest < 0.2;
  const y = (value) => H - bottom - (H - bottom - top) * value / highest;
  const power = Math.pow(10, Math.floor(Math.log10(highest / 3)));
  const step = power * [1, 2, 5, 10].find((factor) => highest / (factor * power) <= 6);
  const out = s("svg", {viewBox: `0 0 ${W} ${H}`, role: "img", "aria-label": "Relative pose error per path length"});
  for (let i = 0; i * step <= highest; ++i) {
    out.append(s("line", {class: "gridline", x1: left, x2: W, y1: y(i * step), y2: y(i * step)}),
      s("text", {x: left - 6, y: y(i * step) + 4, "text-anchor": "end"}, axisText(i * step * (small ? 1000 : 1), [0, step * (small ? 1000 : 1)])));
  }
  const pitch = (W - left) / rows.length;
  rows.forEach((row, i) => {
    const shown = ["vo", "graph"].filter((name) => row[name]);
    const width = Math.min(44, pitch / (shown.length + 1.2));
    const begin = left + pitch * (i + 0.5) - (width * shown.length + 8 * (shown.length - 1)) / 2;
    shown.forEach((name, k) => out.append(boxGlyph(row[name], name, begin + k * (width + 8), width, y)));
    out.append(s("text", {x: left + pitch * (i + 0.5), y: H - bottom + 18, "text-anchor": "middle"}, `${digits(row.length_m, 2).replace(/\.0$/, "")} m`));
  });
  out.append(s("text", {x: 12, y: top, transform: `rotate(-90 12 ${top})`, "text-anchor": "end"}, small ? "mm" : "m"));
  const keys = ["vo", "graph"].filter((name) => rows.some((row) => row[name]));
  byId("boxes").append(
    h("span", {class: "key-inline"}, keys.map((name) => [h("span", {class: "swatch " + name, css: {marginLeft: "12px", marginRight: "6px"}}), LAYER_NAMES[name]])),
    h("h3", {}, "Relative pose error", h("small", {}, "per path length")), h("div", {class: "boxes"}, out));
}

function showTiming() {
  const stages = Object.entries(metrics.timing_ms || {}).filter(([, stage]) => stage && isNumber(stage.mean));
  if (stages.length === 0) return;
  stages.sort(([, a], [, b]) => b.mean - a.mean);
  const top = Math.max(...stages.map(([, stage]) => Math.max(stage.mean, stage.p99 || 0)), 1e-9);
  const bar = (name, value) => h("i", {class: name, css: {width: (100 * (value || 0) / top) + "%"}});
  const cell = (value) => h("td", {}, digits(value));
  byId("timing").append(
    h("span", {class: "key-inline"}, h("i", {class: "mean"}), "mean", h("i", {class: "p99"}), "99th percentile"),
    h("h3", {}, "Time per stage", h("small", {}, "milliseconds")),
    h("div", {class: "scroll"}, h("table", {}, h("thead", {}, h("tr", {}, ["", "", "mean", "p50", "p99", "max"].map((title) => h("th", {}, title)))),
      h("tbody", {}, stages.map(([name, stage]) => h("tr", {}, h("th", {}, humanise(name)),
        h("td", {class: "wide"}, h("div", {class: "stagebar"}, bar("p99", stage.p99), bar("mean", stage.mean))),
        cell(stage.mean), cell(stage.p50), cell(stage.p99), cell(stage.max)))))));
}
