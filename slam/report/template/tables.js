// Tables, and the results as text for papers and notes.
function resultRows() {
  const vo = metrics.vo || {}, graph = metrics.graph || {}, online = metrics.online || {};
  const known = ERRORS.map(([key, label, unit]) => [key, label, unit]);
  const others = Object.keys({...vo, ...graph}).filter((key) => !known.some((entry) => entry[0] === key))
    .map((key) => [key, humanise(key), ""]);
  return [...known, ...others].map(([key, label, unit]) => ({label, unit, isError: known.some((entry) => entry[0] === key), vo: vo[key], online: online[key], graph: graph[key]}))
    .filter((row) => isNumber(row.vo) || isNumber(row.graph));
}

const plainNumber = (value) => (isNumber(value) ? String(Number(value.toPrecision(4))) : "–");

const EXPORTS = {
  Markdown: (rows) => ["| metric | unit | VO | graph |", "|---|---|---:|---:|",
    ...rows.map((row) => `| ${row.label.replace(/\|/g, "\\|")} | ${row.unit} | ${plainNumber(row.vo)} | ${plainNumber(row.graph)} |`)].join("\n") + "\n",
  LaTeX: (rows) => {
    const safe = (text) => text.replace(/[\\{}]/g, "").replace(/[%_&#$]/g, "\\$&").replace(/°/g, "$^\\circ$");
    const body = rows.map((row) => `${safe(row.label)} [${safe(row.unit)}] & ${plainNumber(row.vo)} & ${plainNumber(row.graph)} \\\\`);
    return ["\\begin{tabular}{lrr}", "\\toprule", "Metric & VO & Graph \\\\", "\\midrule", ...body, "\\bottomrule", "\\end{tabular}", ""].join("\n");
  },
  CSV: (rows) => ["metric,unit,vo,graph",
    ...rows.map((row) => [`"${row.label.replace(/"/g, '""')}"`, row.unit, isNumber(row.vo) ? row.vo : "", isNumber(row.graph) ? row.graph : ""].join(","))].join("\n") + "\n",
};

async function copyText(text) {
  try {
    await navigator.clipboard.writeText(text);
  } catch (refused) {  // pages opened from a file may not be allowed to
    const area = h("textarea", {}, text);
    document.body.append(area);
    area.select();
    document.execCommand("copy");
    area.remove();
  }
}

function copyButton(name, rows) {
  const button = h("button", {type: "button", title: "Copy the table as " + name, onclick: async () => {
    await copyText(EXPORTS[name](rows));
    button.textContent = "Copied";
    setTimeout(() => { button.textContent = name; }, 1200);
  }}, name);
  return button;
}

function showResults() {
  const rows = resultRows();
  if (rows.length === 0) return;
  const both = metrics.vo && metrics.graph;
  const cell = (row, name, other) => {
    const [text, unit] = withUnit(row[name], row.unit);
    const best = both && row.isError && isNumber(row[name]) && isNumber(row[other]) && row[name] < row[other];
    return h("td", {class: best ? "best" : null}, text, " ", h("small", {}, unit));
  };
  const head = (name, label) => h("th", {}, h("span", {class: "swatch " + name}), label);
  byId("results").append(
    h("div", {class: "tools"}, Object.keys(EXPORTS).map((name) => copyButton(name, rows))),
    h("h3", {}, "Results", h("small", {}, "against ground truth")),
    h("div", {class: "scroll"}, h("table", {},
      h("thead", {}, h("tr", {}, h("th", {}, ""), metrics.vo ? head("vo", "VO") : null, metrics.online ? h("th", {title: "the estimate at the time of each frame"}, "Online") : null, metrics.graph ? head("graph", "Graph") : null, both ? h("th", {}, "") : null)),
      h("tbody", {}, rows.map((row) => h("tr", {}, h("th", {}, row.label),
        metrics.vo ? cell(row, "vo", "graph") : null, metrics.online ? cell(row, "online", "") : null, metrics.graph ? cell(row, "graph", "vo") : null,
        both ? h("td", {}, row.isError ? changeChip(row.vo, row.graph) : null) : null))))));
}

function valueText(value) {
  if (Array.isArray(value)) return value.map((entry) => digits(entry)).join(", ");
  return typeof value === "number" || value === null ? digits(value) : String(value);
}

const CALIBRATION = [
  // key, label, factor, unit, key of the standard deviation
  ["disparity_offset_px", "Disparity offset", 1, "px", "disparity_offset_sigma_px"],
  ["focal_error", "Focal length, relative error", 100, "%", "focal_error_sigma"],
  ["time_offset_s", "Time offset camera to IMU", 1000, "ms", "time_offset_sigma_s"],
  ["camera_rotation_rad", "Camera turned against the IMU", 180 / Math.PI, "deg", "camera_rotation_sigma_rad"],
  ["gravity_m_s2", "Gravity", 1, "m/s²", "gravity_sigma_m_s2"],
  ["gyro_bias", "Gyroscope bias at the end", 1000, "mrad/s", null],
  ["accel_bias", "Accelerometer bias at the end", 1, "m/s²", null],
];

function calibrationRows() {
  const found = metrics.calibration || {};
  const used = new Set(CALIBRATION.flatMap((entry) => [entry[0], entry[4]]));
  const rows = CALIBRATION.filter(([key]) => isNumber(found[key]) || Array.isArray(found[key])).map(([key, label, factor, unit, sigma]) => {
    const scale = (value) => (isNumber(value) ? value * factor : null);
    const value = Array.isArray(found[key]) ? found[key].map(scale) : scale(found[key]);
    const spread = (each) => (isNumber(each) ? " ± " + digits(each * factor, 2) : "");
    if (Array.isArray(value) && Array.isArray(found[sigma])) {
      return [label, value.map((each, axis) => digits(each) + spread(found[sigma][axis])).join(", "), unit];
    }
    return [label, valueText(value) + spread(found[sigma]), unit];
  });
  const others = Object.entries(found).filter(([key, value]) => !used.has(key) && (isNumber(value) || Array.isArray(value)));
  return [...rows, ...others.map(([key, value]) => [humanise(key), valueText(value), ""])];
}

function smallTable(parent, title, note, rows) {
  if (rows.length === 0) return;
  parent.append(h("div", {class: "panel table"}, h("h3", {}, title, h("small", {}, note)), h("div", {class: "scroll"}, h("table", {}, h("tbody", {},
    rows.map(([label, value, unit]) => h("tr", {}, h("th", {}, label), h("td", {}, value, " ", h("small", {}, unit || "")))))))));
}

function showTables() {
  const counters = Object.entries(metrics.counters || {}).filter(([, value]) => isNumber(value))
    .map(([key, value]) => [humanise(key), value.toLocaleString("en"), ""]);
  smallTable(byId("sensor-tables"), "Calibration", "estimated during the run", calibrationRows());
  smallTable(byId("sensor-tables"), "Counters", "what was missing, bridged or refused", counters);
}
