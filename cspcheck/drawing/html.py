"""A picture as a page of its own: the SVG, to be moved with the mouse and scaled with the wheel."""

from __future__ import annotations

from cspcheck.drawing.text import escape

PAGE = """<!doctype html>
<html lang="en">
<meta charset="utf-8">
<title>{title}</title>
<style>
html, body {{ margin: 0; height: 100%; overflow: hidden; background: #ffffff; }}
svg {{ transform-origin: 0 0; cursor: grab; }}
</style>
{svg}
<script>
const picture = document.querySelector("svg");
let scale = 1, x = 0, y = 0;
const show = () => {{ picture.style.transform = `translate(${{x}}px, ${{y}}px) scale(${{scale}})`; }};
addEventListener("wheel", event => {{
  event.preventDefault();
  const factor = Math.exp(-event.deltaY / 500);
  x = event.clientX - (event.clientX - x) * factor;
  y = event.clientY - (event.clientY - y) * factor;
  scale *= factor;
  show();
}}, {{ passive: false }});
addEventListener("pointermove", event => {{
  if (event.buttons & 1) {{ x += event.movementX; y += event.movementY; show(); }}
}});
</script>
</html>
"""


def page(title: str, svg: str) -> str:
    """The page around an SVG document."""
    return PAGE.format(title=escape(title), svg=svg)
