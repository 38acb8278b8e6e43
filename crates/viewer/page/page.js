// @ts-check
// Joins the parts: the server's events, the list of mazes, the recordings and a panel for each source.

import * as api from "./api.js";
import { clearProblem, part, report, write } from "./dom.js";
import { Events } from "./events.js";
import { MazeList } from "./mazes.js";
import { Panel } from "./panel.js";
import { RecordingList } from "./recordings.js";
import { RunForm } from "./run.js";

const LIVE = "live";

const panelsElement = part(document, "#panels", HTMLElement);
/** @type {Map<string, Panel>} */
const panels = new Map();
/** The panel that keys go to. */
let active = "";

const [facts, drawing] = await Promise.all([api.pageFacts(), api.drawingFacts()]);
const mazes = new MazeList(() => panels.get(LIVE)?.timeline.states ?? 0);
const recordings = new RecordingList(openPanel);
/** @type {RunForm | null} */
let runForm = null;
let recordingsHeard = 0;

/** @param {string} id */
function openPanel(id) {
    const panel = new Panel(id, drawing);
    panels.set(id, panel);
    panelsElement.append(panel.element);
    panelsElement.dataset.count = String(panels.size);
    const activate = () => {
        active = id;
        for (const [other, { element }] of panels) element.classList.toggle("active", other === id);
    };
    panel.element.addEventListener("focusin", activate);
    panel.element.addEventListener("pointerdown", activate);
    activate();
    const close = part(panel.element, "[name=close]", HTMLButtonElement);
    close.hidden = id === LIVE;
    close.onclick = () => {
        panel.close();
        panels.delete(id);
        panelsElement.dataset.count = String(panels.size);
        active = [...panels.keys()][0] ?? "";
        api.closeRecording(id).catch(report);
    };
    if (id === LIVE) runForm = new RunForm(panel.element, facts.strategies);
    void panel.begin();
    if (id !== LIVE) panel.element.scrollIntoView({ block: "nearest" });
}

if (facts.live) openPanel(LIVE);
for (const { id } of facts.opened) openPanel(id);

const zmq = part(document, "#zmq", HTMLButtonElement);
write(part(zmq, "span", HTMLElement), facts.zmq);
zmq.hidden = !facts.live;
zmq.onclick = async () => {
    await navigator.clipboard.writeText(facts.zmq);
    zmq.classList.add("copied");
    setTimeout(() => zmq.classList.remove("copied"), 1500);
};

if (facts.live) mazes.load().catch(report);
recordings.load(facts.records).catch(report);

const status = part(document, "#status", HTMLElement);
new Events(
    (event) => {
        if (event.run !== null) panels.get(LIVE)?.follow(event.run, event.states ?? 0);
        mazes.mark(event.maze);
        runForm?.show(event.mouse);
        if (event.recordings !== recordingsHeard) {
            recordingsHeard = event.recordings;
            recordings.load(facts.records).catch(report);
        }
    },
    (connected, again) => {
        status.dataset.connected = String(connected);
        write(status, connected ? "connected" : "connection lost, trying again");
        // It may be another simulator by now, whose runs have the same numbers.
        if (again) void panels.get(LIVE)?.begin();
    },
);

part(document, "[name=dismiss]", HTMLButtonElement).onclick = clearProblem;
const keys = part(document, "#keys", HTMLDialogElement);
part(document, "#help", HTMLButtonElement).onclick = () => keys.showModal();

document.addEventListener("keydown", (event) => {
    const { target } = event;
    if (event.defaultPrevented || event.ctrlKey || event.altKey || event.metaKey) return;
    if (!(target instanceof Element) || target.closest("dialog")) return;
    const slides = target instanceof HTMLInputElement && target.type === "range";
    // Keys that mean something to the element in focus are its own.
    if (target.closest("input, select, textarea") && !slides) {
        const checks = target instanceof HTMLInputElement && target.type === "checkbox";
        if (!checks || event.key === " ") return;
    }
    if (event.key === " " && target.closest("button, a, summary")) return;
    if (event.key === "?") keys.showModal();
    else if (event.key === "/") part(document, "[name=search]", HTMLInputElement).focus();
    else if (!panels.get(active)?.timeline.press(event)) return;
    event.preventDefault();
});
