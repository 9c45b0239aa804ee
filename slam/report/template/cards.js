// Header facts and the main figures.
const ERRORS = [
  // key, label, unit, text of the card's title
  ["ate_se3_rmse_m", "ATE, SE(3) aligned", "m", "Root mean square position error after the best rigid alignment"],
  ["ate_posyaw_rmse_m", "ATE, yaw aligned", "m", "After aligning position and yaw only"],
  ["ate_sim3_rmse_m", "ATE, Sim(3) aligned", "m", "After aligning the scale as well"],
  ["rpe_1m_rmse_m", "RPE over 1 m", "m", "Root mean square relative error over one metre of path"],
  ["rpe_frame_rmse_m", "RPE per frame", "m", "Relative error from frame to frame"],
  ["rpe_frame_rmse_deg", "Rotation per frame", "°", "Relative rotation error from frame to frame"],
  ["t_rel_percent", "KITTI translation", "%", "Drift over 100 to 800 m of path"],
  ["r_rel_deg_per_100m", "KITTI rotation", "°/100 m", "Rotation drift over 100 to 800 m of path"],
  ["sub_t_rel_percent", "Drift over short segments", "%", "As KITTI translation, over segments that fit into the path"],
  ["sub_r_rel_deg_per_100m", "Rotation drift, short segments", "°/100 m", "As KITTI rotation, over segments that fit into the path"],
  ["end_error_percent", "End error", "%", "Error of the last position, per path length"],
  ["rotation_end_deg", "Rotation at the end", "°", "Rotation error of the last pose"],
];
const CARD_ERRORS = ["ate_se3_rmse_m", "rpe_1m_rmse_m", "t_rel_percent", "end_error_percent", "rotation_end_deg"];

function changeChip(before, after) {
  if (!isNumber(before) || !isNumber(after) || before <= 0) return null;
  const change = 100 * (after / before - 1);
  const kind = change < -0.5 ? "good" : change > 0.5 ? "bad" : "same";
  const text = Math.abs(change) < 0.5 ? "±0 %" : (change < 0 ? "−" : "+") + Math.abs(change).toFixed(0) + " %";
  return h("span", {class: "chip " + kind, title: "graph against visual odometry"}, text);
}

function card(label, value, unit, beside, hint) {
  const [text, shown] = withUnit(value, unit);
  return h("div", {class: "card", title: hint}, h("span", {class: "label"}, label),
    h("span", {class: "value"}, text, shown ? h("small", {}, shown) : null), h("span", {class: "beside"}, beside));
}

function errorCard(key) {
  const [, label, unit, hint] = ERRORS.find((entry) => entry[0] === key);
  const vo = (metrics.vo || {})[key], graph = (metrics.graph || {})[key];
  if (!isNumber(vo) && !isNumber(graph)) return null;
  if (!isNumber(graph)) return card(label, vo, unit, "visual odometry", hint);
  const [text, shown] = withUnit(vo, unit);
  return card(label, graph, unit, isNumber(vo) ? [`VO ${text} ${shown}`, changeChip(vo, graph)] : "graph", hint);
}

function showCards() {
  const cards = CARD_ERRORS.map(errorCard);
  const counters = metrics.counters || {};
  if (isNumber(metrics.coverage)) {
    const share = metrics.coverage <= 1 ? 100 * metrics.coverage : metrics.coverage;
    const missing = counters.frames_missing;
    cards.push(card("Coverage", share, "%", isNumber(missing) ? `${missing} frames missing` : "of all frames", "Frames that have a pose"));
  }
  if (isNumber(metrics.frames_per_second)) {
    const real = isNumber(metrics.duration_s) && isNumber(metrics.frames) && metrics.duration_s > 0
      ? metrics.frames_per_second * metrics.duration_s / metrics.frames : null;
    cards.push(card("Frame rate", metrics.frames_per_second, "frames/s", real ? digits(real, 2) + "× real time" : "end to end"));
  }
  if (isNumber(metrics.peak_memory_mb)) cards.push(card("Peak memory", metrics.peak_memory_mb, "MB", "resident"));
  byId("cards").append(...cards.filter(Boolean));
}

function showFacts() {
  const fact = (label, value, unit) => (isNumber(value) ? h("li", {}, h("b", {}, withUnit(value, unit).join(" ")), " " + label) : null);
  const facts = [
    typeof metrics.format === "string" ? h("li", {}, h("b", {}, metrics.format), " format") : null,
    isNumber(metrics.frames) ? h("li", {}, h("b", {}, metrics.frames.toLocaleString("en")), " frames") : null,
    fact("long", metrics.duration_s, "s"), fact("of path", metrics.path_length_m, "m"),
    metrics.graph || metrics.vo ? null : h("li", {}, "no ground truth"),
  ];
  byId("facts").append(...facts.filter(Boolean));
}

function showWarnings() {
  const list = byId("notes");
  const warnings = Array.isArray(metrics.warnings) ? metrics.warnings.filter((text) => typeof text === "string") : [];
  list.prepend(...warnings.map((text) => h("li", {}, text)));
  byId("warnings").hidden = list.children.length === 0;
}
