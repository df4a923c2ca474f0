// Saves the archive that the page holds.
"use strict";
(() => {
  const [archive, button] = ["archive", "archive-save"].map((name) => document.getElementById(name));
  button.hidden = false;
  button.addEventListener("click", () => {
    const bytes = Uint8Array.from(atob(archive.textContent), (letter) => letter.charCodeAt(0));
    const link = document.createElement("a");
    link.href = URL.createObjectURL(new Blob([bytes], { type: "application/zip" }));
    link.download = archive.dataset.name;
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 10000);
  });
})();
