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
  runForm = new RunForm(element, facts.strategies);
}
for (const { id } of facts.opened) openPanel(id);
const mazes = facts.live ? new MazeList(() => panels.get(LIVE)?.timeline.states ?? 0) : undefined;
mazes?.load().catch(report);
const recordings = new RecordingList((id) => openPanel(id).element.scrollIntoView({ block: "nearest" }));
let recordingsHeard = NaN;

listen(
  (event) => {
    // Another simulator by now: its runs and recordings have the same numbers as those shown here.
    if (event.server !== facts.server) return location.reload();
    if (event.run !== null) panels.get(LIVE)?.follow(event.run, event.states ?? 0);
    mazes?.mark(event.maze);
    runForm?.show(event.mouse);
    if (!facts.records || event.recordings === recordingsHeard) return;
    recordingsHeard = event.recordings;
    recordings.list().catch(report);
  },
  (connected) => {
    set(part(document, "#status"), "data-connected", connected);
    write(document, "#status", connected ? "connected" : "connection lost, trying again");
  },
);

/** @param {string} id */
function openPanel(id) {
  const panel = new Panel(id, drawing);
  const { element } = panel;
  const all = part(document, "#panels");
  panels.set(id, panel);
  all.append(element);
  /** @param {string} to */
  const activate = (to) => {
    active = to;
    all.classList.toggle("several", panels.size > 1);
    for (const [other, { element }] of panels) element.classList.toggle("active", other === to);
  };
  element.addEventListener("focusin", () => activate(id));
  element.addEventListener("pointerdown", () => activate(id));
  activate(id);
  const close = part(element, "[name=close]", HTMLButtonElement);
  close.hidden = id === LIVE;
  close.onclick = () => {
    panel.close();
    panels.delete(id);
    activate([...panels.keys()][0] ?? "");
    api.closeRecording(id).catch(report);
  };
  void panel.begin();
  return panel;
}

const zmq = part(document, "#zmq", HTMLButtonElement);
write(zmq, "span", facts.zmq);
zmq.hidden = !facts.live;
zmq.onclick = async () => {
  // Browsers have no clipboard for pages of other machines without https; the address can be selected.
  if (!navigator.clipboard) return;
  await navigator.clipboard.writeText(facts.zmq);
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
  else if (key === "/" && mazes) part(document, "#mazes input").focus();
  else if (!panels.get(active)?.timeline.press(event)) return;
  event.preventDefault();
});
