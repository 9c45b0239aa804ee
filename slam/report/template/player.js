// The panel around the 3-D view: legend, colours, viewpoints, play controls.
const ICONS = {play: "M3 1.5v11l9-5.5z", pause: "M3 1.5h3v11H3zM8 1.5h3v11H8z"};
const VIEWPOINTS = {Orbit: [-1.05, 0.6], Top: [-Math.PI / 2, 1.5706], Side: [-Math.PI / 2, 0], Front: [0, 0]};

function legend(scene) {
  const rows = ["truth", "vo", "graph"].filter((name) => trajectories[name]).map((name) => [name, LAYER_NAMES[name]]);
  if (data.map) rows.push(["map", "Map"]);
  return h("div", {class: "glass legend"}, rows.map(([name, label]) =>
    h("label", {}, h("input", {type: "checkbox", checked: true, onchange: (event) => {
      scene.visible[name] = event.target.checked;
      scene.redraw();
    }}), h("span", {class: "swatch " + name}), label,
    name === "map" ? h("small", {}, data.map.total.toLocaleString("en") + " points") : null)));
}

function select(values, chosen, changed) {
  return h("select", {onchange: (event) => changed(event.target.value)},
    values.map(([value, label]) => h("option", {value, selected: value === chosen}, label)));
}

function choices(scene) {
  const rows = [];
  const bar = h("div", {hidden: true}, h("div", {class: "scalebar", css: {
    background: "linear-gradient(90deg," + HEAT.map((color) => `rgb(${color})`) + ")"}}), h("div", {class: "scaletext"}));
  const row = (label, control) => rows.push(h("span", {}, label), control);
  if (data.map) {
    const kinds = [["height", "height"], ...(data.map.intensity ? [["brightness", "brightness"]] : []), ["plain", "plain"]];
    row("Map by", select(kinds, scene.mapColor, (value) => { scene.mapColor = value; scene.buildMap(); scene.redraw(); }));
    row("Points", select([["0.6", "small"], ["1", "medium"], ["2", "large"]], "1", (value) => { scene.mapSize = +value; scene.redraw(); }));
  }
  const errors = [["plain", "plain"]];
  if (hasSeries("graph_error_m")) errors.push(["position", "position error"]);
  if (hasSeries("graph_error_deg")) errors.push(["rotation", "rotation error"]);
  if (trajectories.graph && errors.length > 1) {
    row("Graph by", select(errors, "plain", (value) => {
      scene.graphColor = value;
      scene.build();
      scene.redraw();
      bar.hidden = value === "plain";
      if (bar.hidden) return;
      const [, top, unit] = scene.errorRange;
      const [text, name] = withUnit(top, unit);
      bar.lastChild.replaceChildren(h("span", {}, "0"), h("span", {}, text + " " + name));
    }));
  }
  return rows.length ? h("div", {class: "glass"}, h("div", {class: "choices"}, rows), bar) : null;
}

function viewButtons(scene) {
  const follow = h("button", {type: "button", "aria-pressed": "false", title: "Keep the play-head in the middle", onclick: () => {
    scene.follow = !scene.follow;
    follow.setAttribute("aria-pressed", scene.follow);
    if (!scene.follow) scene.camera.target = scene.camera.center.slice();
    scene.redraw();
  }}, "Follow");
  return h("div", {class: "views"}, Object.entries(VIEWPOINTS).map(([name, [yaw, pitch]]) =>
    h("button", {type: "button", onclick: () => scene.camera.look(yaw, pitch)}, name)), follow);
}

function readout() {
  const box = h("div", {class: "readout"});
  const show = () => {
    const {position} = poseAt(main_trajectory, clock.now);
    const parts = [["x", position[0] + data.origin[0]], ["y", position[1] + data.origin[1]], ["z", position[2] + data.origin[2]]]
      .map(([name, value]) => [name, value.toFixed(2) + " m"]);
    const error = seriesAt("graph_error_m", clock.now), speed = seriesAt("speed_m_s", clock.now);
    if (isNumber(error)) parts.push(["error", withUnit(error, "m").join(" ")]);
    if (isNumber(speed)) parts.push(["speed", speed.toFixed(2) + " m/s"]);
    box.replaceChildren(...parts.map(([name, value]) => h("span", {}, name + " ", h("b", {}, value))));
  };
  clock.on(show);
  show();
  return box;
}

function playRates() {
  const natural = Math.max(1, (clock.end - clock.start) / 25);
  clock.rate = [1, 2, 5, 10, 20, 50, 100].find((rate) => rate >= natural) || 200;
  return [...new Set([0.5, 1, 2, 5, 10, 20, 50, clock.rate])].sort((a, b) => a - b).map((rate) => [String(rate), rate + "×"]);
}

function player() {
  const shape = s("path", {d: ICONS.play});
  const button = h("button", {type: "button", class: "play", "aria-label": "Play or pause", onclick: () => clock.play(!clock.playing)},
    s("svg", {viewBox: "0 0 14 14"}, shape));
  const slider = h("input", {type: "range", min: 0, max: 2000, value: 2000, "aria-label": "Time", oninput: (event) => {
    const chosen = clock.start + (clock.end - clock.start) * event.target.value / 2000;
    clock.play(false);  // moves the slider to the present time
    clock.set(chosen);
  }});
  const time = h("span", {class: "time"});
  const show = () => {
    slider.value = 2000 * (clock.now - clock.start) / Math.max(1e-9, clock.end - clock.start);
    time.textContent = clock.now.toFixed(2) + " / " + clock.end.toFixed(2) + " s";
    shape.setAttribute("d", clock.playing ? ICONS.pause : ICONS.play);
  };
  const rates = playRates();
  clock.on(show);
  show();
  return h("div", {class: "player"}, button, slider, time,
    h("label", {}, "Speed", select(rates, String(clock.rate), (value) => { clock.rate = +value; })));
}

/// The play-head on the drawings that the program made.
function markDrawings() {
  for (const drawing of document.querySelectorAll("svg.view")) {
    const [scale, x0, y0] = ["scale", "x0", "y0"].map((name) => parseFloat(drawing.dataset[name]));
    const side = drawing.parentElement.querySelector("figcaption").textContent.startsWith("Side");
    const marker = s("circle", {class: "now", r: 6});
    drawing.append(marker);
    const move = () => {
      const {position} = poseAt(main_trajectory, clock.now);
      const p = position.map((value, k) => value + data.origin[k]);
      marker.setAttribute("cx", x0 + scale * p[0]);
      marker.setAttribute("cy", y0 - scale * p[side ? 2 : 1]);
    };
    clock.on(move);
    move();
  }
}

function showTrajectory() {
  if (!main_trajectory && !data.map) return byId("trajectory").remove();
  if (!main_trajectory) byId("views").remove();
  const canvas = h("canvas", {tabindex: "0", "aria-label": "Interactive 3-D view"});
  const stage = h("div", {class: "stage"}, canvas);
  byId("scene").append(stage);
  try {
    const scene = new Scene(canvas);
    stage.append(
      h("div", {class: "overlay left"}, legend(scene), choices(scene)), h("div", {class: "overlay right"}, viewButtons(scene)),
      h("div", {class: "hint"}, `Grid ${digits(scene.gridStep, 1)} m · drag to turn · shift-drag to move · wheel to zoom`));
    scene.redraw();
  } catch (problem) {
    stage.replaceChildren(h("p", {class: "hint"}, "No 3-D view: " + problem.message));
    stage.style.minHeight = stage.style.height = "60px";
  }
  if (!main_trajectory) return;
  stage.append(readout());
  byId("scene").append(player());
  canvas.addEventListener("keydown", (event) => {
    const step = {ArrowLeft: -0.01, ArrowRight: 0.01}[event.key];
    if (step) clock.set(clock.now + step * (clock.end - clock.start));
    else if (event.key === " ") clock.play(!clock.playing);
    else return;
    event.preventDefault();
  });
  markDrawings();
}
