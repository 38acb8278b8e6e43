// @ts-check
// Joins the parts: the server's events, the lists of mazes and recordings, a panel for each source.

import * as api from "./api.js";
import { clearProblem, part, pause, report, set, write } from "./dom.js";
import { listen } from "./events.js";
import { MazeList } from "./mazes.js";
import { Panel } from "./panel.js";
import { RecordingList } from "./recordings.js";
import { RunForm } from "./run.js";

const LIVE = "live";

/** @type {Map<string, Panel>} */
const panels = new Map();
/** The panel that keys go to. */
let active = "";
/** @type {RunForm | undefined} */
let runForm;

const [facts, drawing] = await Promise.all([api.pageFacts(), api.drawingFacts()]).catch((problem) => {
  report(problem);
  throw problem;
});
if (facts.live) {
  const { element } = openPanel(LIVE);
  runForm = new RunForm(element, facts.strategies, liveStates);
}
for (const { id } of facts.opened) openPanel(id);
const mazes = facts.live ? new MazeList(liveStates) : undefined;
mazes?.load().catch(report);
const recordings = new RecordingList((id) => openPanel(id).element.scrollIntoView({ block: "nearest" }));
let recordingsHeard = NaN;
let openHeard = facts.opened.map(({ id }) => id);

listen(
  (event) => {
    // Another simulator by now: its runs and recordings have the same numbers as those shown here.
    if (event.server !== facts.server) return location.reload();
    if (event.run !== null) panels.get(LIVE)?.follow(event.run, event.states ?? 0);
    mazes?.mark(event.maze);
    runForm?.show(event.mouse);
    // What was not open yet when this was told may be open by now, what has been open is not.
    for (const id of openHeard) if (!event.opened.includes(id)) remove(id);
    openHeard = event.opened;
    if (!facts.records || event.recordings === recordingsHeard) return;
    recordingsHeard = event.recordings;
    void recordings.list();
  },
  (connected) => {
    set(part(document, "#status"), "data-connected", connected);
    write(document, "#status", connected ? "connected" : "connection lost, trying again");
  },
);

function liveStates() {
  return panels.get(LIVE)?.timeline.states ?? 0;
}

/** @param {string} id */
function openPanel(id) {
  const panel = new Panel(id, drawing);
  const { element } = panel;
  const all = part(document, "#panels");
  panels.set(id, panel);
  all.append(element);
  element.addEventListener("focusin", () => activate(id));
  element.addEventListener("pointerdown", () => activate(id));
  activate(id);
  const close = part(element, "[name=close]", HTMLButtonElement);
  close.hidden = id === LIVE;
  close.onclick = () => {
    remove(id);
    // It may have been closed elsewhere.
    api.closeRecording(id).catch((problem) => problem.gone || report(problem));
  };
  void panel.begin();
  return panel;
}

/** @param {string} id */
function activate(id) {
  active = id;
  part(document, "#panels").classList.toggle("several", panels.size > 1);
  for (const [other, { element }] of panels) element.classList.toggle("active", other === id);
}

/** Takes away a panel. If it has the focus, the one beside it gets that. @param {string} id */
function remove(id) {
  const panel = panels.get(id);
  if (!panel) return;
  const ids = [...panels.keys()];
  const at = ids.indexOf(id);
  const beside = ids[at + 1] ?? ids[at - 1] ?? "";
  const focused = panel.element.contains(document.activeElement);
  panel.close();
  panels.delete(id);
  activate(active === id ? beside : active);
  if (focused) (panels.get(beside)?.element ?? part(document, "[name=file]", HTMLInputElement)).focus();
}

const zmq = part(document, "#zmq", HTMLButtonElement);
const { hostname } = location;
const isLocal = /^(127\..*|(.*\.)?localhost|\[::1\])$/.test(hostname);
// Another machine reaches the simulator where it has found this page.
const address = isLocal ? facts.zmq : facts.zmq.replace(/0\.0\.0\.0|\[::\]/, hostname);
write(zmq, "span", address);
zmq.hidden = !facts.live;
// Browsers have no clipboard for pages of other machines without https.
if (!navigator.clipboard) {
  part(zmq, "svg", SVGElement).remove();
  zmq.title = "";
}
zmq.onclick = async () => {
  if (!navigator.clipboard) return;
  await navigator.clipboard.writeText(address);
  zmq.classList.add("copied");
  await pause(1500);
  zmq.classList.remove("copied");
};

const keys = part(document, "#keys", HTMLDialogElement);
part(document, "#help").onclick = () => keys.showModal();
part(document, "[name=dismiss]").onclick = clearProblem;

document.addEventListener("keydown", (event) => {
  const { key, target } = event;
  if (event.defaultPrevented || event.ctrlKey || event.altKey || event.metaKey) return;
  if (!(target instanceof Element) || target.closest("dialog")) return;
  // Keys that mean something to the element in focus are its own.
  if (target.matches("select, input:not([type=range], [type=checkbox])")) return;
  if (key === " " && target.matches("button, a, [type=checkbox]")) return;
  if (key === "?") keys.showModal();
  else if (key === "/" && mazes) mazes.search();
  else if (!panels.get(active)?.timeline.press(event)) return;
  event.preventDefault();
});
