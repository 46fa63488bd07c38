"use strict";

// Takes over what changes while the run goes on. When it is over, the page that stays is loaded.
(() => {
  const stage = document.getElementById("stage");
  const changes = new EventSource("changes");
  changes.onmessage = ({ data }) => {
    const { over, parts, figures } = JSON.parse(data);
    if (over) {
      changes.close();
      location.reload();
      return;
    }
    for (const [id, html] of Object.entries(parts)) {
      const part = document.getElementById(id);
      if (part) part.innerHTML = html;
    }
    window.renew(figures);
    stage.textContent = "The run goes on; this page follows it.";
  };
  changes.onerror = () => {
    stage.textContent = "The program cannot be reached any more: this is the last that it said.";
  };
})();
