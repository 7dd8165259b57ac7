"""A picture as a page of its own: fitted to the window, to be moved, scaled and searched, by mouse and by keyboard."""

from __future__ import annotations

from cspcheck.drawing.text import escape

VIEW_STYLE = """
.view { position: relative; overflow: hidden; width: 100%; height: 100%; background: #ffffff; outline: none; }
.view > svg { transform-origin: 0 0; cursor: grab; position: absolute; left: 0; top: 0; }
.view .found .node { stroke: #c77700; stroke-width: 3.5; }
.view .here .node { fill: #ffe2a8; stroke: #c77700; stroke-width: 3; }
.view.searching .unfound { opacity: 0.25; }
"""
"""How a picture that can be moved looks."""

VIEW_SCRIPT = """
function view(box) {
  const picture = box.querySelector("svg");
  let scale = 1, x = 0, y = 0;
  const show = () => { picture.style.transform = `translate(${x}px, ${y}px) scale(${scale})`; };
  const width = () => picture.viewBox.baseVal.width, height = () => picture.viewBox.baseVal.height;
  function fit() {
    scale = Math.min(box.clientWidth / width(), box.clientHeight / height(), 1.5) || 1;
    x = Math.max(0, (box.clientWidth - width() * scale) / 2);
    y = Math.max(0, (box.clientHeight - height() * scale) / 2);
    show();
  }
  function zoom(factor, cx = box.clientWidth / 2, cy = box.clientHeight / 2) {
    x = cx - (cx - x) * factor;
    y = cy - (cy - y) * factor;
    scale *= factor;
    show();
  }
  function search(text) {
    const wanted = text.trim().toLowerCase();
    const nodes = [...picture.querySelectorAll("g > g")];
    box.classList.toggle("searching", wanted !== "");
    let first = null, count = 0;
    for (const node of nodes) {
      const hit = wanted !== "" && node.textContent.toLowerCase().includes(wanted);
      node.classList.toggle("found", hit);
      node.classList.toggle("unfound", wanted !== "" && !hit);
      if (hit) { count += 1; first = first || node; }
    }
    if (first) centre(first);
    return count;
  }
  function centre(node) {
    const area = node.getBoundingClientRect(), outer = box.getBoundingClientRect();
    x += outer.left + outer.width / 2 - (area.left + area.width / 2);
    y += outer.top + outer.height / 2 - (area.top + area.height / 2);
    show();
  }
  box.addEventListener("wheel", event => {
    event.preventDefault();
    const outer = box.getBoundingClientRect();
    zoom(Math.exp(-event.deltaY / 500), event.clientX - outer.left, event.clientY - outer.top);
  }, { passive: false });
  box.addEventListener("pointermove", event => {
    if (event.buttons & 1) { x += event.movementX; y += event.movementY; show(); }
  });
  function key(event) {
    const step = 60;
    switch (event.key) {
      case "+": case "=": zoom(1.25); break;
      case "-": zoom(0.8); break;
      case "0": case "f": fit(); break;
      case "ArrowLeft": x += step; show(); break;
      case "ArrowRight": x -= step; show(); break;
      case "ArrowUp": y += step; show(); break;
      case "ArrowDown": y -= step; show(); break;
      default: return false;
    }
    event.preventDefault();
    return true;
  }
  fit();
  return { fit, zoom, search, centre, key };
}
"""
"""What moves it: ``view(box)`` for an element of class ``view`` with an SVG in it."""

PAGE = """<!doctype html>
<html lang="en">
<meta charset="utf-8">
<title>{title}</title>
<style>
html, body {{ margin: 0; height: 100%; overflow: hidden; background: #ffffff; }}
#bar {{ position: fixed; right: 12px; top: 8px; z-index: 1; font: 13px system-ui, sans-serif; color: #52606d; }}
#bar input {{ font: inherit; padding: 3px 6px; border: 1px solid #9aa5b1; border-radius: 4px; width: 12em; }}
{style}
</style>
<div id="bar"><span id="count"></span> <input id="search" type="search" placeholder="search  ( / )"
  title="/ search, + - zoom, 0 fit, arrows move"></div>
<div class="view" tabindex="0">
{svg}
</div>
<script>
{script}
const box = document.querySelector(".view"), search = document.querySelector("#search");
const shown = view(box);
addEventListener("resize", shown.fit);
search.addEventListener("input", () => {{
  const count = shown.search(search.value);
  document.querySelector("#count").textContent = search.value.trim() ? `${{count}} found` : "";
}});
addEventListener("keydown", event => {{
  if (event.target === search) {{
    if (event.key === "Escape") {{ search.value = ""; search.dispatchEvent(new Event("input")); search.blur(); }}
    return;
  }}
  if (event.ctrlKey || event.metaKey || event.altKey) return;
  if (event.key === "/") {{ event.preventDefault(); search.focus(); }} else shown.key(event);
}});
</script>
</html>
"""


def page(title: str, svg: str) -> str:
    """The page around an SVG document."""
    return PAGE.format(title=escape(title), svg=svg, style=VIEW_STYLE, script=VIEW_SCRIPT)
