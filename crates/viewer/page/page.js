// @ts-check
// Entry point: passes the server's events to the panels and to the lists of mazes and recordings.

import * as api from "./api.js";
import { CompareBar } from "./compare_bar.js";
import { clearError, copy, query, setAttributes, setText, showError } from "./dom.js";
import { isExported } from "./embedded.js";
import { listen } from "./events.js";
import { Ghosts } from "./ghost.js";
import { findRecording, installCopyButton, linkUrl, parseLink } from "./link.js";
import { MazeList } from "./mazes.js";
import { Panel } from "./panel.js";
import { RecordingList } from "./recordings.js";
import { RunForm } from "./run.js";

const LIVE = "live";
/** The parts of the page that need the server. */
const NEEDS_SERVER = "aside section, .run, .export, [name=close], #show-live, #compare, [name=vehicle]";
/** The parts of a panel that need the server, unless the page keeps the run. */
const NEEDS_RUN = ".history, .log";

/** @type {Map<string, Panel>} */
const panels = new Map();
/** ID of the panel that receives keyboard shortcuts. */
let active = "";
/** @type {RunForm | undefined} */
let runForm;
/** @type {api.ServerEvent | undefined} */
let lastEvent;
/** The message when the server does not reply. */
const unreachable = query(document, "#offline").textContent ?? "";
/** The element that had the focus when the connection was lost. @type {HTMLElement | null} */
let focusedOnline = null;

const [info, style] = await Promise.all([api.pageInfo(), api.drawingStyle()]).catch((error) => {
  showError(error);
  throw error;
});
const compareBar = new CompareBar(panels);
const ghosts = new Ghosts(panels);
const showLiveButton = query(document, "#show-live", HTMLButtonElement);
showLiveButton.onclick = () => showLive()?.element.focus();
installCopyButton(query(document, "#compare"), () => linkUrl(info.server, shownPanels(), compareBar.kind));
// A link to recordings shows no live run.
if (parseLink(location.hash)?.live !== null) showLive();
for (const id of info.opened) openPanel(id);
const mazes = info.live && !info.trial ? new MazeList(confirmMaze) : undefined;
if (!mazes) query(document, ".bar a").hidden = true;
mazes?.load().catch(showError);
const recordings = new RecordingList(
  (id) => openPanel(id).element.scrollIntoView({ block: "nearest" }),
  async (file) => {
    if (!mazes) throw new Error(`${file.name} is not a recording, and this page loads no mazes.`);
    await mazes.open(file);
  },
);
let recordingsVersion = NaN;
let openIds = info.opened;

/** Links are opened one after the other. */
let opening = openLink();
addEventListener("hashchange", () => (opening = opening.then(openLink)));

if (isExported) showExported();
else listen(
  (event) => {
    // The simulator was restarted. Its new runs and recordings reuse the IDs on this page.
    if (event.server !== info.server) return location.reload();
    lastEvent = event;
    updateLive(event);
    void compareBar.sync();
    mazes?.setCurrent(event.maze);
    // Compare with the previous event, not with the panels: a recording may have opened after this event was sent.
    for (const id of openIds) if (!event.opened.includes(id)) remove(id);
    openIds = event.opened;
    if (!info.records || event.recordings === recordingsVersion) return;
    recordingsVersion = event.recordings;
    void recordings.refresh();
  },
  showConnection,
);

/**
 * Says whether the server can be reached, and disables what needs the server.
 * @param {boolean} connected
 * @param {string} [reason] the reply of a server that refuses the connection
 */
function showConnection(connected, reason) {
  api.setConnected(connected);
  setAttributes(query(document, "#status"), { "data-connected": connected });
  setText(document, "#status", connected ? "Connected" : "Connection lost, reconnecting…");
  query(document, "#offline").hidden = connected;
  if (!connected) setText(document, "#offline", reason ? `Cannot connect: ${reason}` : unreachable);
  if (connected) {
    for (const part of document.querySelectorAll("[inert]")) part.removeAttribute("inert");
    if (document.activeElement === document.body) focusedOnline?.focus();
    focusedOnline = null;
    return;
  }
  clearError();
  for (const { timeline } of panels.values()) if (timeline.playing) timeline.moveLinked(timeline.target);
  const { activeElement } = document;
  if (activeElement instanceof HTMLElement && activeElement !== document.body) focusedOnline = activeElement;
  for (const part of document.querySelectorAll(NEEDS_SERVER)) part.setAttribute("inert", "");
  for (const { element, source } of panels.values()) {
    for (const part of element.querySelectorAll(NEEDS_RUN)) part.toggleAttribute("inert", !api.isKept(source));
  }
}

/** Says that the page is exported, and disables dropping files on the page. */
function showExported() {
  setText(document, "#status", "Exported recording");
  for (const part of document.querySelectorAll("aside section")) part.setAttribute("inert", "");
}

/** Returns the panel of the live simulation, which is opened if the user has closed it. */
function showLive() {
  if (!info.live || panels.has(LIVE)) return panels.get(LIVE);
  const live = openPanel(LIVE);
  if (info.own) live.hint = `${info.own} has not reported a state yet.`;
  runForm = new RunForm(live.element, info);
  if (lastEvent) updateLive(lastEvent);
  return live;
}

/** @param {api.ServerEvent} event */
function updateLive(event) {
  const live = panels.get(LIVE);
  if (event.run !== null) live?.follow(event.run, event.states ?? 0, event.annotations ?? 0);
  live?.timeline.pace.update(event.pace);
  runForm?.show(event);
}

/** Asks whether to load a maze, which the live simulation then shows. @param {string} maze */
async function confirmMaze(maze) {
  if (!runForm) showLive();
  const choice = (await runForm?.confirmMaze(maze)) ?? "";
  if (choice) showLive();
  return choice;
}

/** The panels in the order in which they are shown. */
function shownPanels() {
  const ids = [...document.querySelectorAll(".panel")].map((element) => element.getAttribute("data-source") ?? "");
  return ids.flatMap((id) => panels.get(id) ?? []);
}

/** Shows the runs and states of the link in the address, if there is one. */
async function openLink() {
  const link = parseLink(location.hash);
  if (!link) return;
  // The link has no effect after a reload, so the page stays as the user left it.
  history.replaceState(null, "", location.pathname + location.search);
  const isSameServer = link.server === info.server;
  if (link.kind) compareBar.setKind(link.kind);
  if (link.live) await openLive(link.live, isSameServer).catch(showError);
  /** @type {Set<string>} */
  const used = new Set();
  for (const target of link.recordings) {
    const free = openIds.filter((id) => !used.has(id));
    const id = await findRecording(free, target, isSameServer).catch(showError);
    if (!id) continue;
    used.add(id);
    const panel = panels.get(id) ?? openPanel(id);
    panel.showState(0, target.index);
    activate(id);
    panel.element.scrollIntoView({ block: "nearest" });
  }
}

/** @param {{ run: number, index: number }} target @param {boolean} isSameServer */
async function openLive({ run, index }, isSameServer) {
  const live = showLive();
  if (!live) throw new Error("The live run of this link is not available: this page shows only recordings.");
  const isCurrent = isSameServer && (await api.source(LIVE)).run === run;
  if (!isCurrent) throw new Error("The live run of this link has been reset since, so its states are gone.");
  live.showState(run, index);
}

/** @param {string} id */
function openPanel(id) {
  const panel = new Panel(id, style, info);
  const { element } = panel;
  panels.set(id, panel);
  // The live simulation comes first.
  const list = query(document, "#panels");
  list.insertBefore(element, id === LIVE ? list.firstChild : null);
  compareBar.add(panel);
  void ghosts.update();
  const copyButton = installCopyButton(element, () => linkUrl(info.server, [panel]));
  panel.onShow = () => {
    copyButton.disabled = !panel.shown;
    void compareBar.sync();
    void ghosts.update();
  };
  element.addEventListener("focusin", () => activate(id));
  element.addEventListener("pointerdown", () => activate(id));
  activate(id);
  const close = query(element, "[name=close]", HTMLButtonElement);
  close.title = id === LIVE ? "Close this panel (the simulation continues)" : "Close recording";
  close.onclick = () => {
    remove(id);
    // Another page may already have closed the recording.
    if (id !== LIVE) api.closeRecording(id).catch((error) => error.isNotFound || showError(error));
  };
  void panel.load();
  return panel;
}

/** @param {string} id */
function activate(id) {
  active = id;
  query(document, "#panels").classList.toggle("several", panels.size > 1);
  query(document, "#nothing-open").hidden = panels.size > 0;
  showLiveButton.hidden = !info.live || panels.has(LIVE);
  for (const [other, { element }] of panels) element.classList.toggle("active", other === id);
}

/** Removes a panel. If the panel has the focus, a neighbour receives the focus. @param {string} id */
function remove(id) {
  const panel = panels.get(id);
  if (!panel) return;
  const { nextElementSibling, previousElementSibling } = panel.element;
  const beside = nextElementSibling ?? previousElementSibling;
  const neighbour = (beside instanceof HTMLElement && beside.dataset.source) || "";
  const focused = panel.element.contains(document.activeElement);
  panels.delete(id);
  compareBar.remove(panel);
  panel.close();
  void ghosts.update();
  activate(active === id ? neighbour : active);
  const fallback = showLiveButton.hidden ? query(document, "[name=file]") : showLiveButton;
  if (focused) (panels.get(neighbour)?.element ?? fallback).focus();
}

const zmq = query(document, "#zmq", HTMLButtonElement);
const { hostname } = location;
const isLocal = /^(127\..*|(.*\.)?localhost|\[::1\])$/.test(hostname);
// Other machines reach the simulator under the same host name as this page.
const address = (isLocal ? info.zmq : info.zmq?.replace(/0\.0\.0\.0|\[::\]/, hostname)) ?? "";
setText(zmq, "span", address);
zmq.hidden = !info.live || info.trial;
// Browsers offer the clipboard only to https and local pages.
if (!navigator.clipboard) {
  query(zmq, "svg", SVGElement).remove();
  zmq.title = "";
}
zmq.onclick = () => navigator.clipboard && copy(zmq, address);

const keys = query(document, "#keys", HTMLDialogElement);
query(document, "#help").onclick = () => keys.showModal();
query(document, "[name=dismiss]").onclick = clearError;

document.addEventListener("keydown", (event) => {
  const { key, target } = event;
  // Some keyboards type brackets with AltGr, which some systems report as Ctrl and Alt.
  const hasModifier = event.ctrlKey || event.altKey || event.metaKey;
  if (event.defaultPrevented || (hasModifier && !event.getModifierState("AltGraph"))) return;
  if (!(target instanceof Element) || target.closest("dialog")) return;
  // The focused element keeps the keys that it handles itself.
  if (target.matches("select, input:not([type=range], [type=checkbox])")) {
    // In a search field, the first press of Escape clears the text.
    const isCleared = !(target instanceof HTMLInputElement && target.type === "search" && target.value);
    if (key === "Escape" && isCleared) panels.get(active)?.element.focus({ preventScroll: true });
    return;
  }
  if (key === " " && target.matches("button, a, [type=checkbox]")) return;
  if (key === "?") keys.showModal();
  else if (key === "/" && mazes && !api.isOffline()) mazes.focusSearch();
  else if (!panels.get(active)?.handleKey(event)) return;
  event.preventDefault();
});
