// SPDX-License-Identifier: Apache-2.0
// Browsers start no worker from a file. There, a hidden frame runs the theme's search instead.
if (location.protocol === "file:")
  window.Worker = class extends EventTarget {
    constructor(url) {
      super();
      const frame = document.createElement("iframe");
      frame.hidden = true;
      // There what the worker posts goes to the page: const hides the method, and leaves it to us.
      frame.srcdoc =
        `<script>const postMessage = data => parent.postMessage(data, "*")</script>` +
        `<script src="${url}"></script>`;
      this.frame = new Promise(resolve => (frame.onload = () => resolve(frame.contentWindow)));
      addEventListener("message", event => {
        if (event.source === frame.contentWindow)
          this.dispatchEvent(new MessageEvent("message", { data: event.data }));
      });
      document.body.append(frame);
    }

    postMessage(data) {
      this.frame.then(window => window.postMessage(data, "*"));
    }
  };
