// mcap_reader.mjs FILE [--stream]: reads a recording with @mcap/core and decodes every message with
// @foxglove/rosmsg2-serialization. Prints a JSON object: messages read by topic, and whether by the
// index. Ends with 77 where one of the modules is not installed, with 1 where anything is wrong.
// NODE_PATH does not apply to modules: STOF_NODE_MODULES names the folder that holds them.
import { createRequire } from "node:module";
import { open, readFile } from "node:fs/promises";
import { pathToFileURL } from "node:url";

const require = createRequire(pathToFileURL((process.env.STOF_NODE_MODULES ?? process.cwd()) + "/here.js"));
let mcap, rosmsg, serialization, fzstd;
try {
  mcap = require("@mcap/core");
  rosmsg = require("@foxglove/rosmsg");
  serialization = require("@foxglove/rosmsg2-serialization");
  fzstd = require("fzstd");
} catch (error) {
  console.log(`skipped: ${error.message.split("\n")[0]}`);
  process.exit(77);
}

const [file, how] = process.argv.slice(2);
const decompressHandlers = { zstd: (bytes, size) => fzstd.decompress(bytes, new Uint8Array(Number(size))) };

async function* byIndex() {
  const handle = await open(file);
  const size = BigInt((await handle.stat()).size);
  const readable = {
    size: async () => size,
    read: async (offset, length) => {
      const bytes = new Uint8Array(Number(length));
      const { bytesRead } = await handle.read(bytes, 0, bytes.length, Number(offset));
      if (bytesRead !== bytes.length) {
        throw new Error(`${bytesRead} of ${length} bytes at ${offset}`);
      }
      return bytes;
    },
  };
  const reader = await mcap.McapIndexedReader.Initialize({ readable, decompressHandlers });
  for (const [id, schema] of reader.schemasById) {
    schemas.set(id, schema);
  }
  for (const [id, channel] of reader.channelsById) {
    channels.set(id, channel);
  }
  statistics = reader.statistics;
  for await (const attachment of reader.readAttachments()) {
    attachments.push(attachment.name);
  }
  for await (const record of reader.readMetadata()) {
    metadata.push(record.name);
  }
  yield* reader.readMessages({ validateCrcs: true });
  await handle.close();
}

async function* inOrder() {
  const reader = new mcap.McapStreamReader({ decompressHandlers, validateCrcs: true });
  reader.append(await readFile(file));
  for (let record; (record = reader.nextRecord()); ) {
    if (record.type === "Schema") {
      schemas.set(record.id, record);
    } else if (record.type === "Channel") {
      channels.set(record.id, record);
    } else if (record.type === "Attachment") {
      attachments.push(record.name);
    } else if (record.type === "Metadata") {
      metadata.push(record.name);
    } else if (record.type === "Message") {
      yield record;
    }
  }
}

const schemas = new Map();
const channels = new Map();
const attachments = [];
const metadata = [];
let statistics;
const decoders = new Map();
const counts = {};
let checks = 0;
for await (const message of how === "--stream" ? inOrder() : byIndex()) {
  const { topic, schemaId } = channels.get(message.channelId);
  const schema = schemas.get(schemaId);
  if (!decoders.has(schemaId)) {
    if (schema.encoding !== "ros2msg") {
      throw new Error(`${topic}: schema encoding ${schema.encoding}`);
    }
    const text = new TextDecoder().decode(schema.data);
    decoders.set(schemaId, new serialization.MessageReader(rosmsg.parse(text, { ros2: true })));
  }
  const decoded = decoders.get(schemaId).readMessage(message.data);
  if (schema.name === "sensor_msgs/msg/Image") {
    const pixel = decoded.encoding === "16UC1" ? 2 : 1;
    if (decoded.step !== decoded.width * pixel || decoded.data.length !== decoded.step * decoded.height) {
      throw new Error(`${topic}: ${decoded.width}x${decoded.height} ${decoded.encoding} in ${decoded.data.length} bytes`);
    }
    checks += 1;
  } else if (schema.name === "sensor_msgs/msg/CameraInfo") {
    if (decoded.k.length !== 9 || decoded.k[0] <= 0 || decoded.p[0] !== decoded.k[0] || decoded.k[8] !== 1) {
      throw new Error(`${topic}: K is ${decoded.k}`);
    }
    checks += 1;
  }
  counts[topic] = (counts[topic] ?? 0) + 1;
}
if (statistics && Number(statistics.messageCount) !== Object.values(counts).reduce((a, b) => a + b, 0)) {
  throw new Error(`statistics say ${statistics.messageCount} messages`);
}
console.log(JSON.stringify({ counts, attachments, metadata, checks }));
