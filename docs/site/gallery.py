"""A Sphinx extension: the gallery, a page of what the scripts in docs/gallery make, each with its
code. A script's docstring is what stands above its picture."""

from __future__ import annotations

import ast
import os
import subprocess
import sys
from pathlib import Path

from sphinx.application import Sphinx


def write_page(app: Sphinx) -> None:
    """Run the scripts in docs/gallery/made, and list on docs/gallery/index what they leave."""
    folder = Path(app.srcdir, "docs", "gallery")
    made, pages = folder / "made", folder / "made" / "pages"
    lines = ["# Gallery", "", "Each picture with the whole program that makes it.", ""]
    for script in sorted(folder.glob("*.py")):
        lines += _section(script, made, pages)
    (folder / "index.md").write_text("\n".join(lines), encoding="utf-8")


def _section(script: Path, made: Path, pages: Path) -> list[str]:
    subprocess.run([sys.executable, str(script)], cwd=made, check=True, env=os.environ)
    text = script.read_text(encoding="utf-8")
    about = " ".join((ast.get_docstring(ast.parse(text)) or "").split())
    code = text.split('"""', 2)[2].strip()
    shown = []
    for file in sorted(made.glob(f"{script.stem}.*")):
        if file.suffix == ".svg":
            shown += [f"![{about}](made/{file.name})", ""]
        else:
            file.replace(pages / file.name)
            shown += [f'<iframe src="../../{file.name}" title="{about}"></iframe>', ""]
            shown += [f'<a href="../../{file.name}">The page alone</a>', ""]
    title = script.stem.replace("_", " ").capitalize()
    return [f"## {title}", "", about, "", *shown, "```python", code, "```", ""]


def setup(app: Sphinx) -> dict[str, bool]:
    """Register with Sphinx, which calls this."""
    Path(app.confdir, "gallery", "made", "pages").mkdir(parents=True, exist_ok=True)
    app.connect("builder-inited", write_page)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
