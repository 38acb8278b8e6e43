function (root, { width, height, walls, start, goals, poses, changes }) {
  const SIZE = 20, SVG = "http://www.w3.org/2000/svg", [EAST, NORTH] = [2, 16];
  const [SOUTH, WEST, VISITED] = [4, 8, 1];
  const element = (parent, name, attributes) => {
    const child = document.createElementNS(SVG, name);
    for (const key in attributes) child.setAttribute(key, attributes[key]);
    return parent.appendChild(child);
  };
  const control = (name, properties) =>
    root.appendChild(Object.assign(document.createElement(name), properties));
  const left = (cell) => (cell % width) * SIZE;
  const top = (cell) => (height - 1 - Math.floor(cell / width)) * SIZE;
  const number = (text, at) => parseInt(text.slice(at, at + 2), 36);
  root.textContent = "";
  const svg = document.createElementNS(SVG, "svg");
  svg.setAttribute("viewBox", `-2 -2 ${width * SIZE + 4} ${height * SIZE + 4}`);
  svg.style.cssText = "display: block; width: 480px; max-width: 100%; background: white";
  root.appendChild(svg);
  const count = width * height, cells = [], texts = [], sides = [];
  for (let cell = 0; cell < count; cell++) {
    cells.push(element(svg, "rect", { x: left(cell), y: top(cell), width: SIZE, height: SIZE }));
  }
  for (let cell = 0; cell < count; cell++) {
    const [x, y] = [left(cell), top(cell)];
    const goal = goals.includes(cell), text = { x: x + SIZE / 2, y: y + SIZE / 2 + 2.6 };
    texts.push(element(svg, "text", { ...text, "font-size": 7, "text-anchor": "middle",
      "font-family": "sans-serif", fill: goal ? "#067" : "#555" }));
    const east = { x1: x + SIZE, y1: y, x2: x + SIZE, y2: y + SIZE };
    const north = { x1: x, y1: y, x2: x + SIZE, y2: y };
    const there = Number(walls[cell]);
    sides.push([cell, NORTH, cell + width, SOUTH, there & 1, element(svg, "line", north)]);
    sides.push([cell, EAST, (cell + 1) % width ? cell + 1 : -1, WEST, there & 2,
      element(svg, "line", east)]);
  }
  element(svg, "rect", { width: width * SIZE, height: height * SIZE, fill: "none",
    stroke: "#a22", "stroke-width": 2 });
  const trail = element(svg, "polyline", { fill: "none", stroke: "#27c", "stroke-width": 2,
    "stroke-opacity": 0.6, "stroke-linejoin": "round" });
  const mouse = element(svg, "path", { d: "M0-7L5 6L0 3L-5 6Z", fill: "#06c" });
  const button = control("button", { textContent: "Play", type: "button" });
  const slider = control("input", { type: "range", min: 0, max: changes.length - 1 });
  slider.style.cssText = "width: 320px; max-width: 60%; vertical-align: middle";
  slider.setAttribute("aria-label", "State");
  const label = control("span", {});
  let weights, flags, shown = changes.length, timer;
  const show = (state) => {
    if (state < shown) {
      [weights, flags, shown] = [new Array(count).fill(0), new Array(count).fill(0), -1];
    }
    while (shown < state) {
      const text = changes[++shown];
      for (let at = 0; at < text.length; at += 6) {
        const cell = number(text, at);
        [weights[cell], flags[cell]] = [number(text, at + 2), number(text, at + 4)];
      }
    }
    for (let cell = 0; cell < count; cell++) {
      texts[cell].textContent = weights[cell] === 255 ? "∞" : weights[cell];
      const fill = flags[cell] & VISITED ? "#e3edf8" : "#fff";
      cells[cell].setAttribute("fill", goals.includes(cell) ? "#cde" : fill);
    }
    for (const [cell, flag, other, opposite, there, line] of sides) {
      const known = flags[cell] & flag || (flags[other] ?? 0) & opposite;
      line.setAttribute("stroke", known ? (there ? "#a22" : "#e80") : there ? "#ccc" : "none");
      line.setAttribute("stroke-width", known ? 2 : 1);
    }
    const centre = (at) => {
      const cell = number(poses, 3 * at);
      return [left(cell) + SIZE / 2, top(cell) + SIZE / 2];
    };
    trail.setAttribute("points", Array.from({ length: state + 1 }, (_, at) => centre(at)).join(" "));
    const angle = 90 * "NESW".indexOf(poses[3 * state + 2]);
    mouse.setAttribute("transform", `translate(${centre(state)}) rotate(${angle})`);
    label.textContent = ` ${state + 1} / ${changes.length}`;
    slider.value = state;
  };
  const stop = () => { clearInterval(timer); timer = undefined; button.textContent = "Play"; };
  const step = () => {
    if (!root.isConnected || shown >= changes.length - 1) stop(); else show(shown + 1);
  };
  button.onclick = () => {
    if (timer !== undefined) return stop();
    if (shown >= changes.length - 1) show(0);
    button.textContent = "Pause";
    timer = setInterval(step, Math.min(200, Math.max(25, 12000 / changes.length)));
  };
  slider.oninput = () => { stop(); show(Number(slider.value)); };
  show(changes.length - 1);
}
