/** The page's connection to the process that computes. */

import { pack, unpack } from './packet.js';

const SOON_MS = 500;
const LATEST_MS = 5000;

/**
 * Opens the connection, and again whenever it is lost.
 * @param {string} path of the server, such as '/link'
 */
export function openLink(path) {
  const heard = new Map();
  const closed = [];
  const opened = [];
  const state = { socket: null, wait: SOON_MS, done: false };

  function connect() {
    const socket = new WebSocket(`ws://${location.host}${path}`);
    socket.binaryType = 'arraybuffer';
    state.socket = socket;
    socket.onopen = () => {
      state.wait = SOON_MS;
      opened.forEach((callback) => callback());
    };
    socket.onmessage = ({ data }) => {
      link.replay(typeof data === 'string' ? JSON.parse(data) : unpack(data));
    };
    socket.onclose = ({ reason }) => {
      closed.forEach((callback) => callback(reason));
      if (state.done) return;
      setTimeout(connect, state.wait);
      state.wait = Math.min(LATEST_MS, 2 * state.wait);
    };
  }

  const link = {
    /** Sends {type, …}; its numbers are finite. Nothing is sent while there is no connection. */
    send(message) {
      if (state.socket?.readyState === WebSocket.OPEN) state.socket.send(JSON.stringify(message));
    },
    /** Sends a record with typed arrays in it, as bytes. */
    sendBytes(message) {
      if (state.socket?.readyState === WebSocket.OPEN) state.socket.send(pack(message));
    },
    /** Calls back with every message of a type; returns what ends it. */
    on(type, callback) {
      heard.set(type, [...(heard.get(type) ?? []), callback]);
      return () => heard.set(type, heard.get(type).filter((each) => each !== callback));
    },
    /** Hands a message to whoever waits for its type. */
    replay: (message) => (heard.get(message.type) ?? []).forEach((callback) => callback(message)),
    onOpen: (callback) => opened.push(callback),
    /** Calls back with the reason when the connection is lost. */
    onClose: (callback) => closed.push(callback),
    get open() { return state.socket?.readyState === WebSocket.OPEN; },
    close() {
      state.done = true;
      state.socket?.close();
    },
  };
  connect();
  return link;
}
