#!/usr/bin/env python3
"""What scripts/wire_table.py makes is up to date, and a table that has changed is noticed in all of it."""

import dataclasses
import pathlib
import re
import sys
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "scripts"))
import wire_table  # noqa: E402
from wire import cpp, docs, table  # noqa: E402

WIRE = table.load(wire_table.ROOT)
ENUMS, PYTHON = "firmware/wire/messages/enums.h", "host/python/stof_wire.py"
LUA, DOCUMENT = "host/wireshark/stof.lua", "docs/WIRE.md"


def with_message(name, **changes):
    return dataclasses.replace(WIRE, messages={**WIRE.messages, name: dataclasses.replace(WIRE.messages[name], **changes)})


def with_enum(name, values):
    return dataclasses.replace(WIRE, enums=tuple({**e, "values": values} if e["name"] == name else e
                                                 for e in WIRE.enums))


# Where in a datagram something begins that is no payload: alignment counts from there.
BEGINS_AT = {"stream_signature": 52}


class WireTableTest(unittest.TestCase):
    def noticed(self, wire):
        made = cpp.files(WIRE)
        return {*wire_table.stale(wire_table.outputs(wire, wire_table.ROOT), wire_table.ROOT),
                *(path for path, text in cpp.files(wire).items() if text != made.get(path))}

    def test_everything_is_up_to_date(self):
        self.assertEqual(self.noticed(WIRE), set())

    def test_notices_fields_in_another_order(self):
        fields = WIRE.messages["event"].fields
        swapped = (dataclasses.replace(fields[6], offset=8), dataclasses.replace(fields[5], offset=12))
        self.assertEqual((fields[5].name, fields[6].name), ("count", "value"))
        changed = with_message("event", fields=(*fields[:5], *swapped, *fields[7:]))
        event = {f"firmware/wire/messages/event.{suffix}" for suffix in ("h", "cpp")}
        self.assertEqual(self.noticed(changed), {*event, PYTHON, LUA, DOCUMENT})

    def test_notices_another_value_of_a_name(self):
        values = [{**v, "value": v["value"] + 1} for e in WIRE.enums if e["name"] == "Reaction" for v in e["values"]]
        self.assertEqual(self.noticed(with_enum("Reaction", values)), {ENUMS, PYTHON, LUA, DOCUMENT})

    def test_notices_another_reaction_to_a_condition(self):
        worse = tuple({**c, "reaction": "stop"} for c in WIRE.conditions)
        self.assertEqual(self.noticed(dataclasses.replace(WIRE, conditions=worse)),
                         {"firmware/wire/messages/conditions.cpp", PYTHON, DOCUMENT})

    def test_the_document_has_every_table_once(self):
        text = (wire_table.ROOT / DOCUMENT).read_text(encoding="utf-8")
        named = [match[2] for match in docs.BLOCK.finditer(text)]
        self.assertEqual(sorted(named), sorted(docs.tables(WIRE)))
        self.assertEqual(len(re.findall("<!-- table: ", text)), len(named))
        self.assertEqual(len(re.findall("<!-- end -->", text)), len(named))

    def test_the_document_gets_a_section_for_a_new_message(self):
        new = dataclasses.replace(WIRE.messages["event"], name="of_a_test", doc="Type 199.")
        wire = dataclasses.replace(WIRE, messages={**WIRE.messages, "of_a_test": new})
        text = docs.files(wire, wire_table.ROOT)[DOCUMENT]
        section = "## Of a test\n\nType 199.\n\n<!-- table: of_a_test -->\nPayload of "
        self.assertEqual(text.count(section), 1)
        self.assertEqual(docs.with_sections(text, wire), text)

    def test_every_message_fits_a_datagram_without_gaps(self):
        for layout in (*WIRE.messages.values(), *WIRE.structs.values()):
            at = 0
            for field in layout.fields:
                self.assertEqual(field.offset, at, f"{layout.name}.{field.name}")
                if field.type in table.SIZES and field.type != "text":
                    self.assertEqual((BEGINS_AT.get(layout.name, 0) + at) % field.size, 0, f"{layout.name}.{field.name} is not aligned")
                at += field.bytes
            self.assertLessEqual(at, 1176, layout.name)

    def test_numbers_and_names_are_used_once(self):
        for values in ([e["values"] for e in WIRE.enums] + [WIRE.conditions]):
            for key in ("name", "value"):
                found = [value[key] for value in values]
                self.assertEqual(len(found), len(set(found)), found)
        self.assertEqual([c["value"] for c in WIRE.conditions], list(range(len(WIRE.conditions))))
        self.assertLessEqual(len(WIRE.conditions), 32)

    def test_every_name_that_is_pointed_at_exists(self):
        enums = {e["name"] for e in WIRE.enums} | {"Condition"}
        kinds = {v["name"] for e in WIRE.enums if e["name"] == "PacketType" for v in e["values"]}
        for layout in (*WIRE.messages.values(), *WIRE.structs.values()):
            self.assertLessEqual(set(layout.types), kinds, layout.name)
            for field in layout.fields:
                self.assertLessEqual({field.enum, field.labels, field.bits} - {""}, enums, field.name)
        self.assertEqual({name for m in WIRE.messages.values() for name in m.types}, kinds - {"tile", "raw_tile"})


if __name__ == "__main__":
    unittest.main()
