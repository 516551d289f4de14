"use strict";

const find = (id) => document.getElementById(id);

/** The connection to the server: messages with answers, and events. It is restored when it is lost. */
class Connection {
  constructor(onEvent, onOpen, onLost) {
    Object.assign(this, { onEvent, onOpen, onLost, waiting: new Map(), number: 0 });
    this.open();
  }

  open() {
    const { host, pathname } = location;
    this.socket = new WebSocket(`ws://${host}${pathname}socket`);
    this.socket.addEventListener("open", () => this.onOpen());
    this.socket.addEventListener("message", (event) => this.receive(JSON.parse(event.data)));
    this.socket.addEventListener("close", () => {
      for (const [, reject] of this.waiting.values()) reject(new Error("the server was lost"));
      this.waiting.clear();
      this.onLost();
      setTimeout(() => this.open(), 1000);
    });
  }

  receive(message) {
    if (message.event) {
      this.onEvent(message);
      return;
    }
    const [resolve, reject] = this.waiting.get(message.id) ?? [];
    this.waiting.delete(message.id);
    if (message.error !== undefined) reject?.(Object.assign(new Error(message.error), { stale: message.stale }));
    else resolve?.(message.result);
  }

  /** Return the answer to a message as a promise. */
  call(name, content = {}) {
    this.number += 1;
    const id = this.number;
    return new Promise((resolve, reject) => {
      if (this.socket.readyState !== WebSocket.OPEN) {
        reject(new Error("the server is not connected"));
        return;
      }
      this.waiting.set(id, [resolve, reject]);
      this.socket.send(JSON.stringify({ ...content, do: name, id }));
    });
  }
}

/** Return the numbers of a base64 text. */
function decoded(text, Kind) {
  return new Kind(Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0)).buffer);
}

function fillChoice(select, choices, value) {
  const options = choices.map(([key, text]) => element("option", { value: key }, text));
  select.replaceChildren(...options);
  select.value = value;
}
