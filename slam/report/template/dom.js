// Elements are built, never parsed from text: nothing in the data can become markup.
const SVG = "http://www.w3.org/2000/svg";

function fill(element, attributes, children) {
  for (const [name, value] of Object.entries(attributes || {})) {
    if (value === null || value === undefined || value === false) continue;
    if (name.startsWith("on")) element.addEventListener(name.slice(2), value);
    else if (name === "css") Object.assign(element.style, value);
    else element.setAttribute(name, value === true ? "" : value);
  }
  for (const child of children.flat(Infinity)) {
    if (child !== null && child !== undefined) element.append(child);
  }
  return element;
}
const h = (tag, attributes, ...children) => fill(document.createElement(tag), attributes, children);
const s = (tag, attributes, ...children) => fill(document.createElementNS(SVG, tag), attributes, children);
const byId = (id) => document.getElementById(id);

const styles = getComputedStyle(document.documentElement);
const cssColor = (name) => styles.getPropertyValue("--" + name).trim();

const themeListeners = [];
const onTheme = (listener) => themeListeners.push(listener);
function startTheme() {
  const changed = () => themeListeners.forEach((listener) => listener());
  const dark = matchMedia("(prefers-color-scheme: dark)");
  dark.addEventListener("change", changed);
  byId("theme").addEventListener("click", () => {
    const root = document.documentElement;
    const isDark = root.dataset.theme ? root.dataset.theme === "dark" : dark.matches;
    root.dataset.theme = isDark ? "light" : "dark";
    changed();
  });
}

const isNumber = (value) => typeof value === "number" && Number.isFinite(value);

/// Three or four significant digits, without an exponent where that reads well.
function digits(value, significant = 3) {
  if (!isNumber(value)) return "–";
  const size = Math.abs(value);
  if (size === 0) return "0";
  if (size < 1e-4 || size >= 1e7) return value.toExponential(significant - 1);
  const decimals = Math.max(0, significant - 1 - Math.floor(Math.log10(size)));
  return value.toLocaleString("en", {minimumFractionDigits: decimals, maximumFractionDigits: decimals});
}

/// [text, unit] with a prefix that suits the size.
function withUnit(value, unit) {
  if (!isNumber(value)) return ["–", ""];
  const size = Math.abs(value);
  if (unit === "m" && size < 0.1 && size > 0) return [digits(value * 1000), "mm"];
  if (unit === "m" && size >= 10000) return [digits(value / 1000, 4), "km"];
  if (unit === "MB" && size >= 1024) return [digits(value / 1024), "GB"];
  if (unit === "s" && size >= 120) {
    const whole = Math.round(value);
    return [Math.floor(whole / 60) + ":" + String(whole % 60).padStart(2, "0"), "min"];
  }
  return [digits(value), unit];
}

const humanise = (key) => {
  const words = key.replace(/_/g, " ").replace(/\b(vo|imu|rpe|ate|fps)\b/g, (word) => word.toUpperCase());
  return words.charAt(0).toUpperCase() + words.slice(1);
};
