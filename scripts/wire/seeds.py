"""What the fuzz targets of tests/fuzz begin with: one folder a target, made when it is needed."""

import hashlib
import json
import struct

from wire import samples

SEAL, COOKIE = 1, 2  # flags of a record, see tests/fuzz/fuzz_input.h
PEERS, SECONDS = 4, 16


def record(data, flags=SEAL):
    return struct.pack("<BH", flags, len(data)) + data


def records(packets, flags=SEAL):
    return b"".join(record(packet, flags) for packet in packets)


def requests():
    one = samples.messages()
    asked = {name: one[name] for name in ("subscribe", "unsubscribe", "settings_request", "signed_request", "pair_request", "discover")}
    seeds = {name: record(packet) + record(packet, SEAL | COOKIE) for name, packet in asked.items()}
    wire = samples.wire
    for operation in wire.SettingsOperation:
        for document in wire.SettingsDocument if operation == 0 else (0,):
            request = wire.SettingsRequest(request_id=9, operation=operation, document=document).pack()
            text = {"SET": b'{"streams":{"depth":"raw"},"serial":{"baud":57600}}', "STAGE": b'{"name":"left"}',
                    "PRESET": b"outdoor"}.get(operation.name, b"")
            packet = samples.seal(wire.PacketType.SETTINGS_REQUEST, request + text)
            seeds[f"settings_{operation.name.lower()}_{document}"] = record(packet) + record(packet, SEAL | COOKIE)
    subscribe = asked["subscribe"]
    seeds["five_subscribers"] = b"".join(
        record(subscribe, SEAL | PEERS * peer) + record(subscribe, SEAL | COOKIE | PEERS * peer) for peer in range(4))
    raw = samples.wire.Subscribe(raw=samples.wire.RawRequest(pictures=15, step=2, every=3, column=1, width=9)).pack()
    raw = samples.seal(samples.wire.PacketType.SUBSCRIBE, raw)
    seeds["raw_pictures"] = b"".join(record(raw, SEAL | PEERS * peer) + record(raw, SEAL | COOKIE | PEERS * peer) for peer in range(2))
    seeds["lease_over"] = records([subscribe] * 2, SEAL | COOKIE) + record(subscribe, SEAL | COOKIE | SECONDS * 15)
    seeds["damaged"] = record(subscribe, 0) + record(subscribe[:-1], 0) + record(b"", 0) + record(bytes(1233), 0)
    return seeds


def with_parity(parts):
    wire = samples.wire
    parsed = [wire.parse(part) for part in parts]
    total = bytearray(wire.ParityFields.size() + max(len(payload) for _, payload in parsed))
    for header, payload in parsed:
        fields = wire.ParityFields(0, header.type, header.flags, header.stream, header.codec, header.image_width,
                                   header.image_height, header.first_row, header.first_column, header.pixel_count,
                                   len(payload)).pack()
        for i, byte in enumerate(fields + payload):
            total[i] ^= byte
    total[0:2] = len(parts).to_bytes(2, "little")
    return samples.seal(wire.PacketType.PARITY, bytes(total), index=0, count=1, image_width=4, image_height=2)


def reassembler():
    raw, coded = samples.frame(False), samples.frame(True)
    parity = with_parity(coded)
    seeds = {"raw": records(raw), "coded": records(coded), "backwards": records(reversed(coded)),
             "messages": records(samples.messages().values()),
             "lost_and_recovered": records([coded[0], coded[2], coded[3], parity]),
             "parity_first": records([parity, coded[3], coded[0], coded[1]]),
             "twice": records(raw + raw), "incomplete": records(raw[:2])}
    values = [0, 5, 0, 0, 200, 201, 1, 0]
    seeds["scaled"] = records([samples.tile(1, 3, samples.rvl(values, 16), 0, 3, flags=5),
                               samples.tile(2, 1, struct.pack("<8H", *values), 1, 3, flags=15),
                               samples.tile(3, 2, bytes(8), 2, 3, flags=1)])
    kinds = {4: (3, 16), 5: (3, 16), 6: (4, 8), 7: (4, 8)}
    parts = [samples.tile(stream, codec, samples.rvl(values, bits), i, 5)
             for i, (stream, (codec, bits)) in enumerate(kinds.items())]
    parts.append(samples.tile(8, 5, struct.pack("<hhHH", -5, 5, 4000, 4) * 8, 4, 5))
    seeds["other_streams"] = records(parts)
    first, second, third = (samples.raw_exposure(number) for number in (1, 2, 4))
    seeds["raw_pictures"] = records(first + second)
    seeds["raw_pictures_mixed"] = records([*first[:4], *reversed(second[1:]), first[4], second[0], third[0], first[5]])
    return seeds


def serial():
    stream = b"\0".join([b"", *(samples.cobs(packet)[:-1] for packet in samples.messages().values()), b""])
    one = samples.cobs(samples.frame(True)[1])
    return {"stream": b"\0" + stream, "one": b"\0" + one, "cut": b"\0" + one[10:] + one, "round": b"\1" + bytes(600),
            "long_blocks": b"\1" + bytes(i % 255 + 1 for i in range(700)), "noise": b"\0\xff\xfe\0\1\0\2\0"}


def settings():
    texts = {
        "empty": "{}", "streams": {"streams": {"depth": "raw", "cloud": "on", "cloud_step": 8, "parity": True}},
        "serial": {"serial": {"mode": "mavlink", "baud": 57600, "device": "/dev/ttyS0", "rate_hz": 15}},
        "depth": {"depth": {"preset": "quality", "max_range_mm": 16380, "guided": True, "match": {"block": "16x16"}}},
        "others": {"name": "vorn \u00fc", "period_ms": 33, "udp": {"port": 7561}, "mavlink": {"system_id": 1},
                   "discovery": {"mdns": False}, "sectors": {"above_mm": 300, "pixels": 8}},
        "twice": '{"name":"a","name":"b"}', "escapes": '{"name":"\\u00e9\\n\\ud83d\\ude00"}', "nested": "{" * 40,
        "numbers": '{"period_ms":1e2,"udp":{"port":-0.5}}', "tail": "{} x", "open": '{"name":"'}
    return {name: (text if isinstance(text, str) else json.dumps(text)).encode() for name, text in texts.items()}


def rvl():
    seeds = {}
    for bits, name in ((16, "depth"), (8, "grey")):
        values = [0, 0, 5, 6, 7, 0, (1 << bits) - 1, 1]
        code = samples.rvl(values, bits)
        seeds[f"decode_{name}"] = struct.pack("<BH", bits == 8, len(values)) + code
        seeds[f"encode_{name}"] = struct.pack("<BH", 2 + (bits == 8), 24) + bytes(range(40))
    seeds["zeros"] = struct.pack("<BH", 0, 500) + samples.rvl([0] * 500, 16)
    return seeds


def mavlink():
    heartbeat = struct.pack("<IBBBBB", 0, 2, 3, 0, 4, 3)
    ping = struct.pack("<QIBB", 1_000_000, 7, 0, 0)
    two, one = samples.mavlink2(0, 50, heartbeat), samples.mavlink1(0, 50, heartbeat)
    signed = bytearray(two)
    signed[2] = 1
    body = bytes(signed[1:-2])
    signed[-2:] = struct.pack("<H", samples.x25(body + bytes([50])))
    return {"heartbeat2": two, "heartbeat1": one, "ping": samples.mavlink2(4, 237, ping), "signed": bytes(signed) + bytes(13),
            "cut": two[:7] + one + two, "noise": b"\xfd\xfe\xfd\0\xff" + two}


def name(text):
    return b"".join(bytes([len(label)]) + label.encode() for label in text.split(".")) + b"\0"


def mdns():
    def query(*questions, flags=0):
        return struct.pack(">6H", 0, flags, len(questions), 0, 0, 0) + b"".join(
            name(text) + struct.pack(">HH", kind, cls) for text, kind, cls in questions)

    service, every = "_stof._udp.local", "_services._dns-sd._udp.local"
    answer = struct.pack(">6H", 0, 0x8400, 0, 1, 0, 0) + name("stof-1.local") + struct.pack(">HHIH", 1, 0x8001, 120, 4)
    loop = struct.pack(">6H", 0, 0, 1, 0, 0, 0) + b"\xc0\x0c" + struct.pack(">HH", 12, 1)
    known = query((service, 12, 1))[:6] + struct.pack(">3H", 1, 0, 0) + name(service) + struct.pack(">HH", 12, 1)
    known += b"\xc0\x0c" + struct.pack(">HHIH", 12, 1, 4500, 2) + b"\xc0\x0c"
    seeds = {"service": query((service, 12, 1)), "unicast": query((service, 12, 0x8001)), "every": query((every, 12, 1)),
             "any": query(("stof-1.local", 255, 1)), "two": query((service, 12, 1), ("stof-1.local", 28, 1)),
             "conflict": answer + bytes([10, 0, 0, 9]), "loop": loop, "known": known, "short": b"\0" * 11}
    return {key: record(data, 0) * 2 + record(data, SECONDS * 3) for key, data in seeds.items()}


def calibration():
    def file(version, size, values):
        body = bytearray(size)
        struct.pack_into("<8sHHI", body, 0, b"STOFCAL\0", version, 0, size)
        for form, at, value in values:
            struct.pack_into("<" + form, body, at, value)
        struct.pack_into("<I", body, size - 4, samples.wire.crc32c(body[:-4]))
        return bytes(body)

    pmd = [("i", 112, 2), ("i", 116, 2), ("I", 788, 4)]
    options = [("I", 784, 15)]
    return {"three": b"\0" + file(3, 796, []), "pattern": b"\1" + file(3, 796 + 8, pmd),
            "options": b"\1" + file(3, 796 + 256 + 56 + 300 + 24, options), "two": b"\1" + file(2, 584, []),
            "one": b"\1" + file(1, 580, []), "later": b"\1" + file(4, 796, []), "short": b"\1" + bytes(20)}


def discovery():
    header = struct.pack(">6H", 0, 0x8400, 0, 4, 0, 0)
    service, instance, host = name("_stof._udp.local"), name("front (1)._stof._udp.local"), name("stof-1.local")

    def answer(owner, kind, data):
        return owner + struct.pack(">HHIH", kind, 0x8001, 120, len(data)) + data

    text = b"".join(bytes([len(pair)]) + pair for pair in (b"txtvers=1", b"serial=1", b"name=front", b"id=1", b"board=emu"))
    mdns_answer = header + (answer(service, 12, instance) + answer(instance, 33, struct.pack(">3H", 0, 0, 7560) + host)
                            + answer(instance, 16, text) + answer(host, 1, bytes([10, 0, 0, 1])))
    wire = samples.wire
    announce = wire.Announce(port=7560, subscribers=1, most_subscribers=4, serial="1", name="front", version="0.1.0", board="emu")
    packet = samples.seal(wire.PacketType.ANNOUNCE, announce.pack())
    return {"mdns": record(mdns_answer, 0), "beacon": record(packet), "both": record(packet) + record(mdns_answer, 0),
            "loop": record(header + b"\xc0\x0c" * 8, 0)}


def config_answers():
    wire = samples.wire

    def answer(text, **fields):
        fields = {"total": len(text), "revision": 1, **fields}
        return samples.seal(wire.PacketType.SETTINGS_ANSWER, wire.SettingsAnswer(**fields).pack() + text)

    document = b'{"name":"stof","udp":{"port":7560},"a":[1,true,null,"\\u001b[2J"]}'
    parts = [answer(part, total=len(document)) for part in (document[:20], document[20:])]
    return {"whole": records([answer(document)] * 2), "parts": records(parts),
            "cookie": records([answer(b"", result=1, cookie=7), answer(document)]),
            "refused": records([answer(b"name: \x1b[2J \xff", result=2)] * 2),
            "nested": records([answer(b'{"a":' * 40)]), "text": document, "deep": b"[" * 2000}


def subscription():
    wire = samples.wire
    answers = {}
    for kind in wire.SubscribeResult:
        answer = wire.Subscribed(request_id=1, result=kind, lease_ms=3000, cookie=9).pack()
        answers[kind.name.lower()] = samples.seal(wire.PacketType.SUBSCRIBED, answer)
    every = b"".join(record(packet, SEAL | SECONDS * 3) for packet in answers.values())
    return {"every": every, "one": records([answers["ok"]]), "damaged": records(answers.values(), 0)}


def pairing():
    """The keys that there are, then steps: tests/fuzz/pairing_steps.h."""
    digits, code, cable, reveal, confirm, press, hold, wait = range(8)
    keys, renew, ask, accept, point, flipped, mixed, anything = range(8, 16)
    over_cable, second = 0x80, 0x10
    packet = samples.wire.PairRequest(request_id=1, step=1, role=3, value=(7,) * 32).pack()
    opened = over_cable | ask
    return {"digits": bytes([0, press, digits, reveal, confirm, hold, confirm]),
            "accepted_first": bytes([0, press, digits, reveal, hold, confirm]),
            "held_too_early": bytes([0, press, digits, reveal, over_cable | hold, confirm, hold, confirm]),
            "pressed_away": bytes([0, press, digits, reveal, confirm, press, hold, confirm, press, second | digits, second | reveal, hold]),
            "two": bytes([0, press, digits, second | digits, hold, confirm]),
            "over": bytes([0, press, digits, reveal, confirm, 0xE0 | wait, confirm]),
            "code": bytes([0, code, reveal, confirm, confirm, keys]),
            "cable": bytes([0, over_cable | cable, reveal, confirm, renew, reveal, confirm]),
            "renewed_again": bytes([1, renew, reveal, confirm, renew, reveal, confirm, 0x20 | keys, renew, reveal, confirm]),
            "full": bytes([16, code, reveal, confirm]),
            "window": bytes([0, opened, digits, reveal, confirm, opened, over_cable | accept, confirm, opened]),
            "window_first": bytes([0, opened, digits, reveal, over_cable | accept, confirm]),
            "window_other": bytes([0, opened, digits, reveal, confirm, 0x30 | over_cable | accept, confirm, opened]),
            "network": bytes([0, ask, digits, opened, digits, reveal, confirm, accept, confirm]),
            "points": bytes([0, press]) + b"".join(bytes([second | point, which, press]) for which in range(6)),
            "flipped": bytes([0, press, digits, reveal, flipped, 5, 70, flipped, 2, 64]),
            "mixed": bytes([0, press, digits, second | code, mixed, confirm]),
            "anything": bytes([3, press, digits, anything]) + packet + bytes([reveal, confirm, 0xE7])}


def dataset():
    """The first byte is the file, by its place in tests/fuzz/dataset.cpp."""
    small = b"P5\n4 2\n255\n" + bytes(range(8))
    recording = json.dumps({"width": 2, "height": 1, "f_mod_hz": 20e6, "dark_lsb": 0, "sat_lsb": 4000, "fx": 2, "fy": 2, "cx": 0.5,
                            "cy": 0, "lsb_e": 10, "read_e": 20, "k1": 0.1}).encode()
    return {"left": b"\0" + small, "right": b"\1" + small,
            "meta": b"\2scene s\nndisp 16\nf_px 40\nbaseline_m 0.1\ndoff_px 0\n", "truth": b"\3P5\n4 2\n65535\n" + bytes(16),
            "surfaces": b"\4" + small, "recording": b"\5" + recording, "samples": b"\6P5\n2 4\n65535\n" + bytes(16),
            "pfm": b"\7Pf\n2 1\n-1.0\n" + struct.pack("<2f", 1.5, float("inf"))}


def uploads(wire):
    """Requests of one upload, in chunks of 150 bytes."""
    def whole(file, sent=None, steps=None):
        sent = file if sent is None else sent
        fields = {"kind": wire.UploadKind.CALIBRATION, "total": len(file), "hash": tuple(hashlib.blake2b(file, digest_size=32).digest())}
        head = bytes([wire.PacketType.SETTINGS_REQUEST]) + wire.SettingsRequest(request_id=9, operation=wire.SettingsOperation.UPLOAD).pack()
        chunks = [(wire.UploadStep.CHUNK, at) for at in range(0, len(file), 150)]
        order = [(step, 0) for step in steps] if steps else [(wire.UploadStep.BEGIN, 0), *chunks, (wire.UploadStep.COMMIT, 0)]
        return [head + wire.UploadRequest(step=step, offset=at, **fields).pack() + (sent[at:at + 150] if step == wire.UploadStep.CHUNK else b"")
                for step, at in order]
    return whole


def signed_requests():
    wire = samples.wire
    seeds = {}
    for operation in wire.SettingsOperation:
        request = wire.SettingsRequest(request_id=9, operation=operation, document=0).pack()
        text = {"SET": b'{"streams":{"depth":"raw"}}', "STAGE": b'{"name":"left"}', "PRESET": b"outdoor",
                "UNPAIR": b"0000000d", "DOWNLOAD": wire.DownloadRequest(kind=wire.UploadKind.CALIBRATION).pack()}.get(operation.name, b"")
        body = bytes([wire.PacketType.SETTINGS_REQUEST]) + request + text
        seeds[f"settings_{operation.name.lower()}"] = b"".join(record(body, SEAL | PEERS * who) for who in range(3)) + record(body, 0)
    whole, file = uploads(wire), bytes(range(200)) * 2
    seeds["upload"] = b"".join(record(part, SEAL) for part in whole(file))
    seeds["upload_damaged"] = b"".join(record(part, SEAL) for part in whole(file, sent=file[1:] + b"?"))
    seeds["upload_disorder"] = b"".join(record(part, SEAL | PEERS * who) for who in range(2) for part in reversed(whole(file)))
    seeds["upload_revert"] = record(whole(b"", steps=[wire.UploadStep.REVERT])[0], SEAL)
    seeds["commit"] = seeds["settings_stage"] + seeds["settings_commit"]
    body = [bytes([wire.PacketType.SETTINGS_REQUEST]) + wire.SettingsRequest(operation=operation).pack() for operation in (1, 6)]
    seeds["saves"] = b"".join(record(body[0] + b'{"name":"%d"}' % n) + record(body[1]) for n in range(12))  # more than may be
    seeds["replayed"] = record(bytes([wire.PacketType.SETTINGS_REQUEST]) + wire.SettingsRequest(operation=6).pack(), SEAL | COOKIE)
    subscribe = bytes([wire.PacketType.SUBSCRIBE]) + wire.Subscribe(request_id=9).pack()
    seeds["subscribed"] = b"".join(record(subscribe, SEAL | PEERS * who) for who in range(4))
    raw = bytes([wire.PacketType.SUBSCRIBE]) + wire.Subscribe(request_id=9, raw=wire.RawRequest(pictures=7)).pack()
    seeds["raw_pictures"] = b"".join(record(raw, SEAL | PEERS * who) for who in range(3)) + seeds["settings_unpair"]
    seeds["unsubscribed"] = seeds["subscribed"] + record(bytes([wire.PacketType.UNSUBSCRIBE]) + subscribe[1:])
    seeds["ended"] = seeds["settings_unpair"] + record(subscribe, SEAL | PEERS * 2)
    return seeds


def usb():
    """As tests/hal/usb makes them: info, clock and a frame of 2 x 1 pixels, docs/HARDWARE.md."""
    info = struct.pack("<IHHHHIIIII", 0x444D5053, 1, 2, 1, 12, 10_000, 30_000, 100, 10_000, 7)
    clock = struct.pack("<Q", 123_456_789)
    header = bytearray(96)
    struct.pack_into("<IHHIHHHHIQ", header, 0, 0x46444D50, 96, 1, 5, 2, 1, 12, 0, 20_000, 1_000_000)
    for k in range(4):
        struct.pack_into("<II", header, 32 + 8 * k, 1_000_000 * k, 900_000)
    return {"info": info, "frame": info + clock + bytes(header) + bytes(16), "nothing": b""}


EYE = {"matrix": [50, 0, 32, 0, 50, 24, 0, 0, 1], "turn": [1, 0, 0, 0, 1, 0, 0, 0, 1], "distortion": [-0.2, 0.05, 0.001, 0.0, 0.01]}


def flow(rows, cols, data, **more):
    return json.dumps({**more, "rows": rows, "cols": cols, "data": data})


def ros_yaml(shift):
    projection = [50, 0, 32, shift, 0, 50, 24, 0, 0, 0, 1, 0]
    return (f"image_width: 64\nimage_height: 48\ncamera_name: eye\ncamera_matrix:\n  rows: 3\n  cols: 3\n  data: {EYE['matrix']}\n"
            f"distortion_model: plumb_bob\ndistortion_coefficients: {flow(1, 5, EYE['distortion'])}\n"
            f"rectification_matrix: {flow(3, 3, EYE['turn'])}\nprojection_matrix: {flow(3, 4, projection)}\n").encode()


def ros_ini():
    def camera(name, shift):
        projection = [50, 0, 32, shift, 0, 50, 24, 0, 0, 0, 1, 0]
        lists = {"camera matrix": EYE["matrix"], "distortion": EYE["distortion"], "rectification": EYE["turn"], "projection": projection}
        return f"[{name}]\n" + "".join(f"\n{key}\n{' '.join(map(str, numbers))}\n" for key, numbers in lists.items())

    return ("# oST version 5.0 parameters\n\n[image]\n\nwidth\n64\n\nheight\n48\n\n" + camera("left", 0) + camera("right", -5)).encode()


def import_ros():
    return {"ini": b"\0" + ros_ini(), "left": b"\1" + ros_yaml(0), "right": b"\2" + ros_yaml(-5)}


def import_kalibr():
    camera = ("  camera_model: pinhole\n  distortion_coeffs: [-0.2, 0.05, 0.001, 0.0]\n  distortion_model: radtan\n"
              "  intrinsics: [50.0, 50.0, 32.0, 24.0]\n  resolution: [64, 48]\n")
    pose = "  T_cn_cnm1:\n  - [1.0, 0.0, 0.0, -0.1]\n  - [0.0, 1.0, 0.0, 0.0]\n  - [0.0, 0.0, 1.0, 0.0]\n  - [0.0, 0.0, 0.0, 1.0]\n"
    return {"chain": f"cam0:\n{camera}cam1:\n{pose}{camera}".encode()}


def import_opencv():
    """The first byte says whether the size of the pictures is told beside."""
    size = {"image_width": 64, "image_height": 48}
    lists = {"M1": (3, 3, EYE["matrix"]), "D1": (1, 5, EYE["distortion"]), "M2": (3, 3, EYE["matrix"]), "D2": (1, 4, EYE["distortion"][:4]),
             "R": (3, 3, EYE["turn"]), "T": (3, 1, [-0.1, 0, 0])}
    yaml = "%YAML:1.0\n---\n" + "".join(
        f"{key}: !!opencv-matrix\n   rows: {rows}\n   cols: {cols}\n   dt: d\n   data: {data}\n" for key, (rows, cols, data) in lists.items())
    whole = {**size, **{key: {"type_id": "opencv-matrix", "rows": rows, "cols": cols, "dt": "d", "data": data}
                        for key, (rows, cols, data) in lists.items()}}
    return {"yaml": b"\1" + yaml.encode(), "json": b"\0" + json.dumps(whole, indent=4).encode()}


def mcap():
    """The first byte says how, see tests/fuzz/mcap.cpp."""
    def text(value):
        return struct.pack("<I", len(value)) + value

    def mcap_record(opcode, *parts):
        content = b"".join(parts)
        return struct.pack("<BQ", opcode, len(content)) + content

    magic = b"\x89MCAP0\r\n"
    schema = mcap_record(3, struct.pack("<H", 1), text(b"std_msgs/msg/String"), text(b"ros2msg"), text(b"string data\n"))
    channel = mcap_record(4, struct.pack("<HH", 1, 1), text(b"/t"), text(b"cdr"), text(text(b"unit") + text(b"mm")))
    header = bytes([0, 1, 0, 0]) + struct.pack("<iI", 1, 2) + text(b"a\0") + b"\0\0"
    image = header + struct.pack("<II", 1, 2) + text(b"16UC1\0") + b"\0\0" + struct.pack("<I", 4) + text(bytes(4))
    packet = header + bytes(4) + struct.pack("<IIIIq", 1, 2, 3, 4, 5) + bytes([0, 0, 65, 0]) + bytes(12) + text(bytes(20))
    messages = b"".join(mcap_record(5, struct.pack("<HIQQ", 1, k, 10 + k, 10 + k), body) for k, body in enumerate((image, packet)))
    # A zstd frame by hand: magic, one segment of a size in one byte, one last block as it is.
    stored = struct.pack("<IBB", 0xFD2FB528, 0x20, 40) + (40 << 3 | 1).to_bytes(3, "little") + messages[:40]
    chunks = {"stored": (b"", messages, len(messages)), "zstd": (b"zstd", stored, 40), "lz4": (b"lz4", messages, 9)}
    chunk = {name: mcap_record(6, struct.pack("<QQQI", 10, 11, size, 0), text(compression), struct.pack("<Q", len(data)), data)
             for name, (compression, data, size) in chunks.items()}
    begin = magic + mcap_record(1, text(b"ros2"), text(b"seed")) + schema + channel
    attachment = mcap_record(9, struct.pack("<QQ", 1, 2), text(b"s"), text(b"t"), struct.pack("<Q", 2), b"{}", bytes(4))
    metadata = mcap_record(12, text(b"stof"), text(text(b"a") + text(b"b")))
    data = begin + chunk["stored"]
    index_at = len(data)
    data += mcap_record(7, struct.pack("<HI", 1, 16), struct.pack("<QQ", 10, 0)) + attachment + metadata
    summary_at = len(data) + 13
    chunk_index = mcap_record(8, struct.pack("<QQQQI", 10, 11, len(begin), len(chunk["stored"]), 10), struct.pack("<HQ", 1, index_at),
                              struct.pack("<Q", 31), text(b""), struct.pack("<QQ", len(messages), len(messages)))
    attachment_at = index_at + 31
    indexes = (mcap_record(10, struct.pack("<QQQQQ", attachment_at, len(attachment), 1, 2, 2), text(b"s"), text(b"t")) +
               mcap_record(13, struct.pack("<QQ", attachment_at + len(attachment), len(metadata)), text(b"stof")) +
               mcap_record(11, struct.pack("<QHIIIIQQI", 2, 1, 1, 1, 1, 1, 10, 11, 10), struct.pack("<HQ", 1, 2)))
    whole = (data + mcap_record(15, bytes(4)) + schema + channel + chunk_index + indexes +
             mcap_record(2, struct.pack("<QQI", summary_at, 0, 0)) + magic)
    seeds = {"whole": b"\0" + whole, "cut": b"\0" + data, "messages": b"\3" + messages, "loose": b"\1" + messages,
             "beside": b"\1" + attachment + metadata + chunk_index + indexes}
    seeds.update({f"chunk_{name}": b"\1" + one for name, one in chunk.items()})
    return seeds


def cdr_packet(kind, payload, number=1, freshness=1, session=1):
    """stof_msgs/msg/Packet, as host/recording/ros_messages.cpp has it."""
    head = bytes([0, 1, 0, 0]) + struct.pack("<iI", 1, 2) + struct.pack("<I", 2) + b"a\0" + b"\0\0"
    body = struct.pack("<IIIIq", 1, session, number, freshness, 5) + bytes([0, 0, kind, 0]) + bytes(12)
    return head + body + struct.pack("<I", len(payload)) + payload


def cdr_image(encoding, width, height, data):
    text = encoding.encode() + b"\0"
    head = bytes([0, 1, 0, 0]) + struct.pack("<iI", 1, 2) + struct.pack("<I", 2) + b"a\0" + b"\0\0" + struct.pack("<II", height, width)
    body = struct.pack("<I", len(text)) + text + b"\0"  # which is the order of bytes
    body += bytes(-len(body) % 4) + struct.pack("<I", width * (2 if "16" in encoding else 1))
    return head + body + struct.pack("<I", len(data)) + data


def raw_recording():
    """Messages of the topics of host/recording/topics.h; the first byte says how, see tests/fuzz/raw_recording.cpp."""
    wire = samples.wire
    info_topic, calibration, settings, edge, left, right, pmd, depth = 11, 12, 15, 16, 17, 18, 19, 3
    document = b'{"name": "a"}\0'
    said = bytes([0, 1, 0, 0]) + struct.pack("<I", len(document)) + document

    def exposure(number):
        window = wire.Window(begin_ns=100, end_ns=200)
        info = wire.RawInfo(edge_ns=50, pair_exposures=(window,) * 2, pmd_exposures=(window,) * 4, number=number, width=4, height=2,
                            camera_width=4, camera_height=2, pmd_width=2, pmd_height=1, pictures=7, step=1, pmd_every=1)
        packet = cdr_packet(wire.PacketType.RAW_INFO, info.pack(), number, number)
        tiles = wire.FrameInfo(tiles=(1, 0, 0, 0, 0, 0, 0, 0)).pack()
        return [(edge, packet), (left, cdr_image("mono8", 4, 2, bytes(8))), (right, cdr_image("mono8", 4, 2, bytes(8))),
                (pmd, cdr_image("16UC1", 2, 4, bytes(16))), (depth, cdr_image("16UC1", 4, 2, bytes(16))),
                (info_topic, cdr_packet(wire.PacketType.FRAME_INFO, tiles, number, number))]

    def file(parts, number=1):
        return b"".join(record(bytes([number]) + data, topic) for topic, data in parts)

    begin = file([(settings, said)])
    one = file(exposure(1))
    other = record(b"\1" + cdr_packet(wire.PacketType.RAW_INFO, wire.RawInfo().pack(), session=2), edge)
    return {"two": b"\1" + begin + one + file(exposure(2), 2), "pair_alone": b"\1" + begin + file(exposure(1)[:3]),
            "other_session": b"\1" + begin + one + other, "no_settings": b"\1" + one,
            "calibration": b"\1" + begin + record(b"\0" + cdr_packet(wire.PacketType.CALIBRATION, bytes(200)), calibration) + one,
            "file": b"\0" + mcap()["whole"][1:]}


def download():
    wire = samples.wire
    file = bytes(range(40)) * 8
    file += struct.pack("<I", wire.crc32c(file))
    fingerprint = struct.unpack("<I", file[-4:])[0]

    def answer(part, offset, total=len(file), mark=fingerprint, **fields):
        text = wire.DownloadAnswer(total=total, offset=offset, fingerprint=mark).pack() + part
        return samples.seal(wire.PacketType.SETTINGS_ANSWER, wire.SettingsAnswer(total=len(text), revision=1, **fields).pack() + text)

    halves = [answer(file[:200], 0), answer(file[200:], 200)]
    return {"whole": records([answer(file, 0)]), "halves": records(halves), "changed": records([halves[0], answer(file[200:], 200, mark=7), *halves]),
            "damaged": records([answer(file[:-1] + b"?", 0)]), "longer": records([answer(file + b"?", 0)]), "empty": records([answer(b"", 0)]),
            "refused": records([answer(b"", 0, result=2)]), "cookie": records([answer(b"", 0, result=1, cookie=7), *halves])}


def client_frames():
    """The first byte says in parts of which size."""
    def frame(opcode, payload, mask=0x80):
        size = len(payload)
        head = bytes([0x80 | opcode, mask | size]) if size < 126 else bytes([0x80 | opcode, mask | 126]) + struct.pack(">H", size)
        return head + (bytes(4) if mask else b"") + payload
    long = bytes([0x82, 0xFF]) + struct.pack(">Q", 20) + bytes(24)
    return {"text": b"\x1f" + frame(1, b"{}") * 3, "long": b"\x07" + frame(2, bytes(300)) + frame(9, b""), "longest": b"\x02" + long,
            "endless": b"\x1f" + bytes([0x82, 0xFF]) + b"\xff" * 12 + bytes(9), "bare": b"\0" + frame(1, b"ab") + frame(1, b"ab", mask=0)}


def page_message():
    says = [{"show": ["depth", "left"], "frames": 2, "quiet": False}]
    ask = {"id": 7, "ticket": "t"}
    for what, more in (("settings", {}), ("set", {"settings": {"depth.max_range_mm": 4000, "name": "a=b\n", "parity": True}}), ("save", {}),
                       ("faults", {}), ("fault", {"device": "pmd", "kind": "vanish", "edges": 30}), ("record", {"on": True}), ("play", {"on": False}),
                       ("seek", {"to_ms": 5}), ("pair", {"code": "0011-aa", "role": "tune"}), ("digits", {"digits": "123 456"}),
                       ("end_pairing", {}), ("release", {}), ("update", {"file": "rpi4.update"})):
        says.append({"do": what, **ask, **more})
    seeds = {f"{k}": json.dumps(one).encode() for k, one in enumerate(says)}
    return {**seeds, "twice": b'{"do":"save","id":1,"id":2,"ticket":"t"}', "deep": b'{"do":' + b"[" * 900, "path": json.dumps(
        {"do": "update", **ask, "file": "../x"}).encode()}


def foxglove():
    """Messages of four clients."""
    def say(**message):
        return json.dumps(message).encode()
    subscribe = say(op="subscribe", subscriptions=[{"id": k, "channelId": k + 1} for k in range(6)])
    end = say(op="unsubscribe", subscriptionIds=[0, 5, 9])
    talk = b"".join(record(subscribe, PEERS * who | SECONDS * (who + 1)) for who in range(4)) + record(end, PEERS) + record(subscribe, PEERS)
    return {"talk": talk, "twice": record(subscribe, 0) * 2, "other": record(say(op="advertise"), 0) + record(b"{}", 0),
            "wrong": record(say(op="subscribe", subscriptions=[{"id": -1, "channelId": 99}]), 0), "none": record(b'{"op":7}', PEERS)}


def update():
    """Update files; the first byte says what the target sets right (tests/fuzz/update.cpp)."""
    def file(content, board=b"virt", counter=1, letter=0xFFFFFFFF, chunk=1 << 16):
        hashes = [hashlib.blake2b(content[at:at + chunk], digest_size=32).digest() for at in range(0, len(content), chunk)]
        head = struct.pack("<8sHHI16s16s32sIIII32s", b"STOFUPD\0", 1, 0, chunk, board, b"usb", b"1.0", counter, len(content), letter, 0,
                           hashlib.blake2b(b"".join(hashes), digest_size=32).digest())
        return head + bytes(64) + b"".join(hashes) + content
    small, large = file(b"system" * 20, letter=3), file(bytes(range(256)) * 300)
    return {"unsigned": b"\x1c" + small, "good": b"\x1f" + small, "slow": b"\x3f" + large, "large": b"\x1f" + large,
            "damaged": b"\x5d" + small[:-1] + b"?", "cut": b"\x5d" + large[:70000], "rpi4": b"\x5d" + file(b"s", board=b"rpi4")}


TARGETS = {"client_frames": client_frames, "download": download, "foxglove": foxglove, "page_message": page_message, "raw_recording": raw_recording,
           "update": update, "mcap": mcap, "import_ros": import_ros, "import_kalibr": import_kalibr, "import_opencv": import_opencv, "dataset": dataset, "signed_requests": signed_requests, "usb": usb, "pairing": pairing, "calibration": calibration, "config_answers": config_answers, "subscription": subscription,
           "discovery": discovery, "reassembler": reassembler, "requests": requests, "serial": serial, "settings": settings, "rvl": rvl,
           "mavlink": mavlink, "mdns": mdns, "view": reassembler}


def write(folder):
    """Writes folder/TARGET/NAME; how many."""
    count = 0
    for target, make in TARGETS.items():
        (folder / target).mkdir(parents=True, exist_ok=True)
        for key, data in make().items():
            (folder / target / key).write_bytes(data)
            count += 1
    return count
