// foxglove.mjs MODULES BIN COUNT: COUNT messages of each channel, by Foxglove's own client and its decoder of ROS messages.
import { strict as assert } from "node:assert";
import { createRequire } from "node:module";
import { join } from "node:path";
import { startSensor, startView, stopAll, until } from "./programs.mjs";

const [modules, bin, countText] = process.argv.slice(2);
const count = Number(countText);
const require = createRequire(join(modules, "here.js"));
const { FoxgloveClient } = require("@foxglove/ws-protocol");
const { WebSocket } = require("ws");
const { parse } = require("@foxglove/rosmsg");
const { MessageReader } = require("@foxglove/rosmsg2-serialization");

const width = 64;
const height = 48;
// Told when it changes, or twice a second: who subscribes anew gets the newest at once.
const told = new Set(["/diagnostics", "/tf_static"]);

const checks = {
  "/stof/depth/image_raw": (image) => {
    assert.deepEqual([image.width, image.height, image.encoding, image.step, image.data.length], [width, height, "16UC1", 2 * width, 2 * width * height]);
    assert.equal(image.header.frame_id, "stof_left_optical_frame");
  },
  "/stof/depth/camera_info": (info) => assert.ok(info.width === width && info.k[0] > 0 && info.p[0] === info.k[0] && info.k[8] === 1),
  "/stof/depth/points": (cloud) => {
    assert.deepEqual(cloud.fields.map((field) => field.name), ["x", "y", "z", "z_width"]);
    assert.ok(cloud.point_step === 16 && cloud.data.length === 16 * cloud.width && cloud.width <= (width / 4) * (height / 4));
    const floats = new Float32Array(cloud.data.slice().buffer);
    for (let i = 2; i < floats.length; i += 4) assert.ok(floats[i] > 0, "a point without depth");
  },
  "/diagnostics": (array) => assert.deepEqual(array.status.map((one) => one.name), ["stof: health", "stof: link"]),
  "/tf_static": (message) => assert.deepEqual(message.transforms.map((one) => [one.header.frame_id, one.child_frame_id]), [["stof_link", "stof_left_optical_frame"]]),
};

async function read(address, subprotocol) {
  const client = new FoxgloveClient({ ws: new WebSocket(address, [subprotocol]) });
  const channels = new Map();
  const seen = Object.fromEntries(Object.keys(checks).map((topic) => [topic, 0]));
  const subscriptions = new Map();
  const timers = [];
  const failed = new Promise((_, fail) => {
    client.on("error", (error) => fail(error));
    client.on("close", () => fail(new Error("closed")));
    client.on("status", ({ message }) => fail(new Error(message)));
    client.on("advertise", (all) => {
      for (const channel of all) {
        channels.set(channel.topic, new MessageReader(parse(channel.schema, { ros2: true })));
        subscriptions.set(client.subscribe(channel.id), channel);
      }
    });
    client.on("message", ({ subscriptionId, data }) => {
      const channel = subscriptions.get(subscriptionId);
      if (!channel) return;  // it has ended meanwhile
      const { topic } = channel;
      try {
        checks[topic](channels.get(topic).readMessage(data));
      } catch (error) {
        fail(new Error(`${topic}: ${error.message}`));
        return;
      }
      if (++seen[topic] >= count || !told.has(topic)) return;
      timers.push(setTimeout(() => {
        if (!subscriptions.delete(subscriptionId)) return;
        client.unsubscribe(subscriptionId);
        subscriptions.set(client.subscribe(channel.id), channel);
      }, 50));
    });
  });
  const before = Date.now();
  const end = before + 600_000;
  const all = async () => {
    while (!Object.values(seen).every((one) => one >= count)) {
      if (Date.now() > end) throw new Error(`too few: ${JSON.stringify(seen)}`);
      await new Promise((done) => setTimeout(done, 50));
    }
  };
  await Promise.race([all(), failed]);
  failed.catch(() => {});
  timers.forEach(clearTimeout);
  client.close();
  console.log(`ok    ${subprotocol}: ${JSON.stringify(seen)} decoded in ${((Date.now() - before) / 1000).toFixed(1)} s`);
}

let code = 0;
try {
  const sensor = await startSensor(bin, 0, ["--size", `${width}x${height}`, "--pmd", "32x24", "--period-ms", "20", "--seed", "1"]);
  const view = await startView(bin, sensor.port);
  await until("frames", async () => (await fetch(view.address)).ok);
  for (const subprotocol of ["foxglove.websocket.v1", "foxglove.sdk.v1"]) {
    try {
      await read(view.address.replace("http:", "ws:"), subprotocol);
    } catch (error) {
      console.log(`FAIL  ${subprotocol}: ${error.stack}`);
      code = 1;
    }
  }
  await view.stop();
  await sensor.stop();
} finally {
  stopAll();
}
process.exit(code);
