// @ts-check
// Links to runs at a state. The fragment of the URL names each run and its state, such as
// `#server=1a2b&live=3@120&recording=1:search.mcap@85&link=phase`. States are numbered from 0.

import * as api from "./api.js";
import { isLinkKind } from "./compare_bar.js";
import { copy, query } from "./dom.js";

/**
 * @typedef {import("./panel.js").Panel} Panel
 * @typedef {import("./compare_bar.js").LinkKind} LinkKind
 * @typedef {{ run: number, index: number }} LiveTarget
 * @typedef {{ id: string, name: string, index: number }} RecordingTarget
 * @typedef {{ server: string, live: LiveTarget | null, recordings: RecordingTarget[], kind: LinkKind | null }} Link
 */

/** The maximum number of recordings in a link. */
const MAX_RECORDINGS = 8;

/**
 * Returns the URL that shows panels at their states. Leaves out the token of the page, which is secret.
 * @param {string} server the ID of the server @param {Iterable<Panel>} panels @param {LinkKind} [kind] how the panels are linked
 */
export function linkUrl(server, panels, kind) {
  const parameters = new URLSearchParams({ server });
  for (const { id, source, shown } of panels) {
    if (!source || !shown) continue;
    const run = id === "live" ? `${source.run}` : `${id}:${source.title}`;
    parameters.append(id === "live" ? "live" : "recording", `${run}@${shown.index}`);
  }
  if (kind) parameters.set("link", kind);
  const url = new URL(location.href);
  url.searchParams.delete("token");
  url.hash = `${parameters}`;
  return url.href;
}

/** Returns the link in the fragment of a URL, or null if there is none. @param {string} hash @returns {Link | null} */
export function parseLink(hash) {
  const parameters = new URLSearchParams(hash.slice(1));
  const live = /^(\d+)@(\d+)$/.exec(parameters.get("live") ?? "");
  const recordings = parameters.getAll("recording").flatMap((text) => {
    const [, id, name, state] = /^(\d+):(.*)@(\d+)$/s.exec(text) ?? [];
    return state ? [{ id, name, index: Number(state) }] : [];
  });
  recordings.splice(MAX_RECORDINGS);
  if (!live && recordings.length === 0) return null;
  const kind = parameters.get("link");
  return {
    server: parameters.get("server") ?? "",
    live: live && { run: Number(live[1]), index: Number(live[2]) },
    recordings,
    kind: isLinkKind(kind) ? kind : null,
  };
}

/**
 * Returns the ID of the recording in a link. If the recording is not open, opens it from the folder of recordings.
 * @param {string[]} open the IDs of the open recordings, without those of earlier targets @param {RecordingTarget} target
 * @param {boolean} isSameServer false if the IDs in the link belong to another server
 */
export async function findRecording(open, { id, name }, isSameServer) {
  const sources = await Promise.all(open.map((id) => api.source(id).catch(() => null)));
  const isNamed = sources.filter((source) => source?.title === name);
  const found = (isSameServer && isNamed.find((source) => source?.id === id)) || isNamed[0];
  if (found) return found.id;
  return api.openRecording(name).catch((error) => {
    if (!(error instanceof api.ApiError && error.isNotFound)) throw error;
    throw new Error(`The recording of this link is not available: ${name} (open its file)`);
  });
}

/** Makes a button copy a link. If the browser does not allow that, the link is shown for copying. */
/** @param {ParentNode} parent @param {() => string} url @returns {HTMLButtonElement} */
export function installCopyButton(parent, url) {
  const button = query(parent, "[name=copy-link]", HTMLButtonElement);
  button.onclick = () => copy(button, url()).catch(() => showLink(url()));
  return button;
}

/** @param {string} url */
function showLink(url) {
  const dialog = query(document, "#link-dialog", HTMLDialogElement);
  const input = query(dialog, "input", HTMLInputElement);
  input.value = url;
  dialog.showModal();
  input.select();
}
