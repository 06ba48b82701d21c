"use strict";
// Says why the page cannot work, in browsers or places where its modules or WebAssembly do not run. This script is no
// module, because browsers do not load modules from files.
(() => {
  const reason = () => {
    if (location.protocol === "file:") {
      return "You opened this page as a file, and browsers do not run it from there. Start a file server in this folder, "
        + "for example with “python3 -m http.server”, and open http://localhost:8000/.";
    }
    if (typeof WebAssembly !== "object") {
      return "This browser cannot run WebAssembly, or it is switched off. The finished robot walks, but no new robot can be "
        + "designed. A current version of Firefox, Chrome, Safari or Edge can run it.";
    }
    return "";
  };
  const says = reason();
  if (!says) return;
  const place = document.getElementById("honest");
  place.textContent = says;
  place.hidden = false;
  document.getElementById("status").textContent = "";
})();
