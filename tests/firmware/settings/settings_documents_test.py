#!/usr/bin/env python3
"""settings_documents_test.py [--write] COMMAND...: docs/SETTINGS.md and the schema say what the code does
(COMMAND: settings_documents, with an emulator before it in a cross build), and the schema and the parser agree.
--write brings both files up to date instead."""

import json
import pathlib
import random
import re
import subprocess
import sys
import unittest

COMMAND = []
DOCS = pathlib.Path(__file__).resolve().parents[3] / "docs"
PAGE = DOCS / "SETTINGS.md"
SCHEMA = DOCS / "settings.schema.json"
BEGIN, END = "<!-- settings: begin -->\n", "<!-- settings: end -->\n"
UPDATE = "run tests/firmware/settings/settings_documents_test.py --write build/emu/bin/settings_documents"


def ask(what, text=""):
    return subprocess.run([*COMMAND, what], input=text, capture_output=True, text=True, check=True,
                          encoding="utf-8", timeout=120).stdout


def page_with(tables):
    before, rest = PAGE.read_text(encoding="utf-8").split(BEGIN)
    return before + BEGIN + tables + END + rest.split(END)[1]


TYPES = {"object": dict, "string": str, "boolean": bool, "integer": int}
KNOWN = {"$schema", "title", "type", "additionalProperties", "properties", "minimum", "maximum", "enum", "minLength",
         "maxLength", "pattern", "default", "description", "x-unit", "x-applies", "x-changed-by"}


def fits(schema, value):
    """Whether the value is valid: of JSON Schema what this schema uses."""
    assert set(schema) <= KNOWN, set(schema) - KNOWN
    types = schema["type"] if isinstance(schema["type"], list) else [schema["type"]]
    if not any(isinstance(value, TYPES[t]) and (t == "boolean" or not isinstance(value, bool)) for t in types):
        return False
    if isinstance(value, dict):
        return all(name in schema["properties"] and fits(schema["properties"][name], member)
                   for name, member in value.items())
    if isinstance(value, str):
        return (schema.get("minLength", 0) <= len(value) <= schema.get("maxLength", len(value)) and
                re.search(schema.get("pattern", ""), value) is not None and value in schema.get("enum", [value]))
    return schema.get("minimum", value) <= value <= schema.get("maximum", value)


def leaves(schema, path=()):
    for name, member in schema["properties"].items():
        if member["type"] == "object":
            yield from leaves(member, (*path, name))
        else:
            yield (*path, name), member


def nest(path, value):
    for name in reversed(path):
        value = {name: value}
    return value


class Documents(unittest.TestCase):
    maxDiff = None

    def test_page_is_up_to_date(self):
        self.assertEqual(PAGE.read_text(encoding="utf-8"), page_with(ask("tables")), UPDATE)

    def test_schema_file_is_up_to_date(self):
        self.assertEqual(SCHEMA.read_text(encoding="utf-8"), ask("schema"), UPDATE)

    def test_defaults_are_valid_and_those_of_the_schema(self):
        schema = json.loads(ask("schema"))
        defaults = json.loads(ask("defaults"))
        self.assertTrue(fits(schema, defaults))
        for path, member in leaves(schema):
            value = defaults
            for name in path:
                value = value[name]
            self.assertEqual(value, member["default"], path)

    def test_schema_itself_is_valid(self):
        try:
            import jsonschema
        except ImportError:
            self.skipTest("python3-jsonschema is not installed")
        validator = jsonschema.Draft202012Validator
        validator.check_schema(json.loads(ask("schema")))
        self.assertTrue(validator(json.loads(ask("schema"))).is_valid(json.loads(ask("defaults"))))

    def test_parser_and_schema_agree(self):
        """On every field with many values. Of the matcher's options the schema knows only types; it counts letters
        where the parser counts bytes."""
        schema = json.loads(ask("schema"))
        values = [True, False, None, "", "a", "off", "on", "raw", "rvl", "fit", "fast", "preset", "/dev/ttyS0", "/dev/", "/etc/x",
                  "/dev/../x", "x" * 31, "x" * 32, "/dev/" + "x" * 58, "/dev/" + "x" * 59, "back\\slash", "quo\"te",
                  "tab\t", "K\u00fcche", [], {}, {"a": 1}, 1.5, 1e300, 10**30, -1, 0, 1]
        cases = []
        for path, member in leaves(schema):
            limits = [member[key] + step for key in ("minimum", "maximum") if key in member for step in (-1, 0, 1)]
            cases += [(path, value) for value in values + limits]
        cases += [(path, value) for path in [("x",), ("depth", "x"), ("depth", "match", "fill"), ("depth",)]
                  for value in (1, {"x": 1}, [])]
        verdicts = ask("judge", "".join(json.dumps(nest(path, value), ensure_ascii=False) + "\n"
                                        for path, value in cases)).splitlines()
        self.assertEqual(len(verdicts), len(cases))
        taken = 0
        for (path, value), verdict in zip(cases, verdicts):
            valid = fits(schema, nest(path, value))
            if path[:2] == ("depth", "match"):
                self.assertTrue(valid or verdict != "ok", (path, value, verdict))
            else:
                self.assertEqual(verdict == "ok", valid, (path, value, verdict))
            taken += verdict == "ok"
        self.assertGreater(taken, 100)

    def test_any_subset_of_valid_fields_is_taken(self):
        schema = json.loads(ask("schema"))
        numbers = random.Random(7)
        documents = []
        for _ in range(300):
            document = {}
            for path, member in numbers.sample(list(leaves(schema)), 12):
                choices = member.get("enum") or [member.get("minimum", member["default"]),
                                                 member.get("maximum", member["default"])]
                group = document
                for name in path[:-1]:
                    group = group.setdefault(name, {})
                group[path[-1]] = numbers.choice(choices)
            self.assertTrue(fits(schema, document), document)
            documents.append(json.dumps(document))
        self.assertEqual(ask("judge", "\n".join(documents) + "\n"), "ok\n" * len(documents))


def main():
    write = "--write" in sys.argv[1:]
    COMMAND.extend(word for word in sys.argv[1:] if word not in ("--write", "--"))
    if not COMMAND:
        sys.exit(__doc__)
    if write:
        PAGE.write_text(page_with(ask("tables")), encoding="utf-8")
        SCHEMA.write_text(ask("schema"), encoding="utf-8")
        return
    unittest.main(argv=sys.argv[:1])


if __name__ == "__main__":
    main()
