// dds_payloads.mjs FILE: decodes what fast_dds_reader wrote as --payloads with @foxglove/rosmsg2-serialization
// and definitions of ROS 2 Jazzy from @foxglove/rosmsg-msgs-common; their reader of CDR is @foxglove/cdr. Prints a JSON object:
// messages by type. Fails where a message does not end where its bytes do.
import { readFileSync } from "node:fs";
import { createRequire } from "node:module";
import { pathToFileURL } from "node:url";

const require = createRequire(pathToFileURL(process.cwd() + "/here.js"));
const { MessageReader } = require("@foxglove/rosmsg2-serialization");
const { MessageWriter } = require("@foxglove/rosmsg2-serialization");
const { ros2jazzy } = require("@foxglove/rosmsg-msgs-common");

// A type with all that it is made of.
function definitions(name, found = new Map()) {
  for (const field of ros2jazzy[name].definitions) {
    if (field.isComplex && !found.has(field.type)) {
      found.set(field.type, ros2jazzy[field.type]);
      definitions(field.type, found);
    }
  }
  return found;
}

const coders = new Map();
function coder(ddsName) {
  if (!coders.has(ddsName)) {
    const name = ddsName.replace("::msg::dds_::", "/").replace(/_$/, "");
    const all = [{ definitions: ros2jazzy[name].definitions }, ...definitions(name).values()];
    coders.set(ddsName, { name, reader: new MessageReader(all), writer: new MessageWriter(all) });
  }
  return coders.get(ddsName);
}

const file = readFileSync(process.argv[2]);
const counts = {};
for (let at = 0; at < file.length; ) {
  const end = file.indexOf("\n", at);
  const [type, length] = file.toString("utf8", at, end).split(" ");
  const bytes = file.subarray(end + 1, end + 1 + Number(length));
  at = end + 1 + Number(length);
  const { name, reader, writer } = coder(type);
  const message = reader.readMessage(bytes);
  // Written again it has the same bytes: nothing was left out and nothing was misread.
  const again = Buffer.from(writer.writeMessage(message));
  if (!again.equals(bytes.subarray(0, again.length)) || bytes.length - again.length >= 4) {
    throw new Error(`${name}: ${bytes.length} bytes, ${again.length} when it is written again`);
  }
  counts[name] = (counts[name] ?? 0) + 1;
}
console.log(JSON.stringify(counts));
