/* Browsers start no worker for a page that was opened from a file. Here a hidden frame does a worker's job, so that the
 * search works there. Where the page comes from a server, nothing changes. */
(() => {
  class FrameWorker extends EventTarget {
    constructor(url) {
      super();
      this.onmessage = null;
      this.frame = document.createElement("iframe");
      this.frame.hidden = true;
      document.body.appendChild(this.frame);
      const inner = this.frame.contentWindow;
      addEventListener("message", (event) => {
        if (event.source !== inner) return;
        event.stopImmediatePropagation();
        this.dispatchEvent(new MessageEvent("message", { data: event.data }));
        if (this.onmessage) this.onmessage(event);
      });
      const own = `postMessage = (data) => parent.postMessage(data, "*");
        importScripts = (...urls) => urls.reduce((before, url) => before.then(() => new Promise((done, failed) => {
          const script = document.createElement("script");
          script.src = url; script.onload = done; script.onerror = failed;
          document.body.appendChild(script);
        })), Promise.resolve());`;
      const close = "</scr" + "ipt>";
      inner.document.open();
      this.ready = new Promise((resolve) => this.frame.addEventListener("load", resolve, { once: true }));
      inner.document.write(`<html><body><script>${own}${close}<script src="${url}">${close}</body></html>`);
      inner.document.close();
    }
    postMessage(data) {
      this.ready.then(() => this.frame.contentWindow.dispatchEvent(new MessageEvent("message", { data })));
    }
    terminate() { this.frame.remove(); }
  }
  if (location.protocol === "file:") {
    window.IFrameWorker = window.Worker = FrameWorker;
  }
})();
