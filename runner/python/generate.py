"""Writes `poropunch/results/*.py`, dataclasses over the JSON of the commands, from `runner/schemas`.

    python runner/python/generate.py            # writes them
    python runner/python/generate.py --check    # fails where one is stale
"""

import json
import keyword
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
SCHEMAS = HERE.parent / "schemas"
RESULTS = HERE / "poropunch" / "results"
# Schema, module, what its root is.
MODULES = [
    ("result", "identification", "what `poropunch identify` finds"),
    ("inspection", "inspection", "what `poropunch inspect` reads"),
    ("diagnosis", "diagnosis", "what `poropunch diagnose` finds"),
]
# Of types that several of them have alike.
SHARED = "shared"
PLAIN = {"string": "str", "number": "float", "integer": "int", "boolean": "bool", "object": "dict[str, Any]"}


def annotation(schema):
    """Type of a value in Python."""
    if "$ref" in schema:
        return schema["$ref"].rsplit("/", 1)[1]
    if "anyOf" in schema:
        parts = [part for part in schema["anyOf"] if part.get("type") != "null"]
        return f"Optional[{annotation(parts[0])}]"
    kind = schema["type"]
    if isinstance(kind, list):
        rest = dict(schema, type=next(k for k in kind if k != "null"))
        return f"Optional[{annotation(rest)}]"
    if kind != "array":
        return PLAIN[kind]
    if "prefixItems" in schema:
        return "tuple[" + ", ".join(map(annotation, schema["prefixItems"])) + "]"
    if schema.get("minItems") and schema.get("minItems") == schema.get("maxItems"):
        return "tuple[" + ", ".join([annotation(schema["items"])] * schema["minItems"]) + "]"
    return f"list[{annotation(schema['items'])}]"


def one_line(text):
    return " ".join(text.split()).replace("\\", "\\\\").replace('"""', "'''")


def is_choice(schema):
    return all("const" in part for part in schema.get("oneOf", [{}]))


def choice(name, schema):
    """An enumeration: a Literal."""
    items = "\n".join(f"    {part['const']!r},  # {one_line(part['description'])}" for part in schema["oneOf"])
    return f"#: {one_line(schema['description'])}\n{name} = Literal[\n{items}\n]\n"


def dataclass(name, schema):
    """An object: a dataclass, required fields first."""
    assert not any(keyword.iskeyword(field) for field in schema["properties"]), name
    lines = ["@dataclass(frozen=True)", f"class {name}:", f'    """{one_line(schema.get("description", name))}"""', ""]
    required = set(schema.get("required", []))
    for field, of in sorted(schema["properties"].items(), key=lambda item: item[0] not in required):
        kind = annotation(of)
        if field not in required:
            empty = "field(default_factory=list)" if kind.startswith("list") else "None"
            kind = kind if kind.startswith(("list", "Optional")) else f"Optional[{kind}]"
            kind = f"{kind} = {empty}"
        lines += [f"    {field}: {kind}", f'    """{one_line(of.get("description", "As the type says."))}"""']
    return "\n".join(lines) + "\n"


def definitions(schema):
    return {**schema["$defs"], schema["title"]: schema}


def shared(schemas):
    """Definitions that several schemas have, the same in all of them: those of one name that differ stay where they are."""
    all_of = {}
    for schema in schemas:
        for name, of in definitions(schema).items():
            all_of.setdefault(name, []).append(of)
    return {name: of[0] for name, of in all_of.items() if len(of) > 1 and all(other == of[0] for other in of)}


def module(definitions, what, imported=()):
    choices = {n: s for n, s in definitions.items() if "oneOf" in s and is_choice(s)}
    tagged = {n: s for n, s in definitions.items() if "oneOf" in s and not is_choice(s)}
    objects = {n: s for n, s in definitions.items() if "oneOf" not in s}
    parts = [
        f'"""Dataclasses of {what}. Written by `generate.py` from `runner/schemas`: do not edit."""\n\n'
        "from __future__ import annotations\n\n"
        "from dataclasses import dataclass, field\n"
        "from typing import Any, Literal, Optional\n"
        + (f"\nfrom .{SHARED} import {', '.join(sorted(imported))}\n" if imported else "")
    ]
    parts += [choice(name, s) for name, s in sorted(choices.items())]
    parts += [f"#: {one_line(s['description'])}\n{name} = dict[str, Any]\n" for name, s in sorted(tagged.items())]
    parts += [dataclass(name, s) for name, s in sorted(objects.items())]
    return "\n\n".join(parts)


def main():
    stale = []
    schemas = {name: json.loads((SCHEMAS / f"{schema}.schema.json").read_text(encoding="utf-8")) for schema, name, _ in MODULES}
    common = shared(schemas.values())
    texts = {SHARED: module(common, "what several results have alike")}
    for _, name, what in MODULES:
        own = definitions(schemas[name])
        rest = {n: of for n, of in own.items() if n not in common}
        texts[name] = module(rest, what, own.keys() & common.keys())
    for name, text in texts.items():
        file = RESULTS / f"{name}.py"
        if "--check" not in sys.argv:
            file.write_text(text, encoding="utf-8")
        elif not file.exists() or file.read_text(encoding="utf-8") != text:
            stale.append(str(file))
    if stale:
        sys.exit(f"stale: {', '.join(stale)}; run python runner/python/generate.py")


if __name__ == "__main__":
    main()
