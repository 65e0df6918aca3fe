"""What MkDocs does for this site beside its own: READMEs as pages, reference from the program, files that pages name, equations.

Pages link to files of the repository by relative paths, which also hold where somebody reads them there. Each such file becomes a page of
the site, or is copied into it; a path that leads nowhere stays as it is, and the strict build refuses it.
"""

import os
import posixpath
import re
import subprocess
import xml.etree.ElementTree as ET
from pathlib import Path

from latex2mathml.converter import convert
from mkdocs.exceptions import PluginError
from mkdocs.structure.files import File
from pygments.formatters import HtmlFormatter

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent
#: Pages of the site that are files of the repository.
# Fractions keep clear of what stands below.
EQUATIONS = "\nmath[display=block] { margin: 0.8em 0; }\n"
READMES = dict(line.split() for line in (HERE / "readmes.txt").read_text(encoding="utf-8").splitlines())
PROGRAM = os.environ.get("POROPUNCH_PROGRAM", str(ROOT / "target" / "release" / "runner"))
#: `[text](target#anchor)`, and images.
LINK = re.compile(r"(?<=\]\()([^)#\s]+)(#[^)\s]*)?(?=\))")
COPIED = {".png", ".svg", ".csv", ".txt", ".ipynb"}
LANGUAGES = {".rs": "rust", ".py": "python", ".toml": "toml", ".json": "json", ".xml": "xml", ".sh": "sh"}


def on_config(config):
    # A test builds other pages.
    if os.environ.get("POROPUNCH_NAVIGATION") == "no":
        config.nav = None
    return config


def on_files(files, config):
    for page, source in READMES.items():
        files.append(File.generated(config, page, content=(ROOT / source).read_text(encoding="utf-8")))
    if config.nav:
        files.append(File.generated(config, "reference/parameters.md", content=parameters()))
        files.append(File.generated(config, "reference/command-line.md", content=commands()))
    files.append(File.generated(config, "css/code.css", content=HtmlFormatter(style="default").get_style_defs(".highlight") + EQUATIONS))
    left = list(files.documentation_pages())
    while left:
        file = left.pop()
        for target in targets(file.content_string, repository_path(file.src_uri)):
            page = shown_as(target)
            if page not in files.src_uris:
                files.append(File.generated(config, page, content=content(target)))
                if target.endswith(".md"):
                    left.append(files.src_uris[page])
    return files


def on_page_markdown(markdown, page, config, files):
    source = repository_path(page.file.src_uri)
    here = posixpath.dirname(page.file.src_uri)

    def placed(match):
        target = in_repository(match[1], source)
        if target is None:
            return match[0]
        return posixpath.relpath(shown_as(target), here or ".") + (match[2] or "")

    return outside_code(markdown, lambda text: equations(LINK.sub(placed, text)))


def on_post_build(config):
    """Every link inside the site leads somewhere: what hooks and theme write is not seen by MkDocs' own check."""
    site = Path(config.site_dir)
    dead = []
    for page in site.rglob("*.html"):
        if page.name == "404.html":
            continue
        for link in re.findall(r'(?:href|src)="([^"#?]+)', page.read_text(encoding="utf-8")):
            if re.match(r"[a-z]+:|//", link):
                continue
            target = (site / link.lstrip("/")) if link.startswith("/") else (page.parent / link)
            if not (target.is_file() or (target / "index.html").is_file()):
                dead.append(f"{page.relative_to(site)}: {link}")
    if dead:
        raise PluginError("dead links:\n  " + "\n  ".join(sorted(set(dead))))


def repository_path(page):
    """Where a page stands in the repository."""
    if page in READMES:
        return READMES[page]
    return page.removeprefix("source/") if page.startswith("source/") else f"runner/docs/pages/{page}"


def in_repository(link, source):
    """Path in the repository that a link leads to, where there is one that is no page beside it."""
    if re.match(r"[a-z]+:", link):
        return None
    path = posixpath.normpath(posixpath.join(posixpath.dirname(source), link))
    if path.startswith("runner/docs/pages/") or path.startswith("..") or not (ROOT / path).exists():
        return None if source.startswith("runner/docs/pages/") or not path.startswith("runner/docs/pages/") else path
    return path


def shown_as(path):
    """Page or file of the site that shows a file of the repository."""
    if path.startswith("runner/docs/pages/"):
        return path.removeprefix("runner/docs/pages/")
    readme = path if (ROOT / path).is_file() else posixpath.join(path, "README.md")
    for page, source in READMES.items():
        if source == readme:
            return page
    return f"source/{path}" if Path(path).suffix in COPIED | {".md"} else f"source/{path}.md"


def content(path):
    file = ROOT / path
    if file.is_dir():
        return f"# {path}\n\n" + "\n".join(f"- `{entry.name}`" for entry in sorted(file.iterdir()))
    if file.suffix in COPIED:
        return file.read_bytes()
    if file.suffix == ".md":
        return file.read_text(encoding="utf-8")
    language = LANGUAGES.get(file.suffix, "text")
    return f"# {path}\n\n~~~~~~{language}\n{file.read_text(encoding='utf-8')}\n~~~~~~\n"


def targets(markdown, source):
    found = []

    def look(text):
        found.extend(in_repository(match[1], source) for match in LINK.finditer(text))
        return text

    outside_code(markdown, look)
    return [target for target in found if target is not None]


def outside_code(markdown, change):
    """Changes what is no block of code."""
    parts = re.split(r"(^(?:```|~~~~~~)[\s\S]*?^(?:```|~~~~~~)$)", markdown, flags=re.MULTILINE)
    return "".join(part if index % 2 else change(part) for index, part in enumerate(parts))


def equations(text):
    """`$$...$$` and `$...$` as MathML, which every browser shows without scripts."""
    text = re.sub(r"\$\$(.+?)\$\$", lambda m: convert(m[1], display="block"), text)
    # In a span: Markdown takes a line that begins with a tag that it does not know for the end of the paragraph.
    return re.sub(r"(?<![\w`$])\$([^$`\n]+)\$(?![\w$])", lambda m: f"<span>{convert(m[1])}</span>", text)


def parameters():
    """All variables of the FMU, from the model description."""
    root = ET.parse(ROOT / "modelDescription.xml").getroot()
    lines = ["# Parameters and variables", "", "Made from `modelDescription.xml`, which is made from the program's own table. SI units.", ""]
    kinds = {"parameter": "Parameters", "input": "Inputs", "output": "Outputs"}
    units = {unit.get("name"): unit.find("DisplayUnit").get("name") for unit in root.iter("Unit")}
    for causality, title in kinds.items():
        lines += [f"## {title}", "", "| name | unit | shown in | start | from | to | what it is |", "|---|---|---|---|---|---|---|"]
        for variable in root.find("ModelVariables"):
            if variable.get("causality") != causality:
                continue
            kind = variable[0]
            unit = kind.get("unit", "")
            cells = [f"`{variable.get('name')}`", unit, units.get(unit, ""), kind.get("start", ""), kind.get("min", ""), kind.get("max", "")]
            meaning = variable.get("description", "").replace("|", "\\|").replace("*", "\\*")
            lines.append("| " + " | ".join([*cells, meaning]) + " |")
        lines.append("")
    return "\n".join(lines)


def commands():
    """Help of every command."""
    lines = ["# Commands", "", "What `poropunch COMMAND --help` prints; `poropunch` is called `runner` where it was not installed by pip.", ""]
    left = [[]]
    while left:
        words = left.pop(0)
        help_ = subprocess.run([PROGRAM, *words, "--help"], check=True, capture_output=True, text=True, env={**os.environ, "COLUMNS": "80"}).stdout
        # The list of parameters is a page of its own.
        help_ = help_.split("Parameters of poropunch's FMU")[0].rstrip()
        lines += [f"## poropunch {' '.join(words)}".rstrip(), "", "```text", help_, "```", ""]
        listed = re.search(r"^Commands:\n((?:  .*\n)+)", help_ + "\n", flags=re.MULTILINE)
        names = re.findall(r"^  (\S+)", listed[1], flags=re.MULTILINE) if listed else []
        left = [[*words, name] for name in names if name != "help"] + left
    return "\n".join(lines)
