// @ts-check
// The server's events, while the tab is seen.

/** Milliseconds until a stream is opened again that the browser has given up. */
const RETRY = 2000;

export class Events {
    /** @type {EventSource | null} */
    #stream = null;
    #lost = false;
    #hear;
    #connected;

    /**
     * @param {(event: import("./api.js").ServerEvent) => void} hear
     * @param {(connected: boolean, again: boolean) => void} connected `again`: after it was lost
     */
    constructor(hear, connected) {
        this.#hear = hear;
        this.#connected = connected;
        document.addEventListener("visibilitychange", () => this.#open());
        this.#open();
    }

    #open() {
        this.#stream?.close();
        this.#stream = null;
        if (document.hidden) return;
        const stream = new EventSource("/events");
        this.#stream = stream;
        stream.onmessage = ({ data }) => this.#hear(JSON.parse(data));
        stream.onopen = () => {
            this.#connected(true, this.#lost);
            this.#lost = false;
        };
        stream.onerror = () => {
            this.#lost = true;
            this.#connected(false, false);
            if (stream.readyState !== EventSource.CLOSED) return;
            setTimeout(() => {
                if (this.#stream === stream) this.#open();
            }, RETRY);
        };
    }
}
