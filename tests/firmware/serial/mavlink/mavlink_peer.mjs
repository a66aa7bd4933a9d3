// node mavlink_peer.mjs FRAMES EXPECTED: reads FRAMES with node-mavlink and compares each message with its line of
// EXPECTED. Prints how many of which kind were equal; ends with 1 at the first difference.
import { createReadStream, readFileSync } from 'node:fs'
import { createRequire } from 'node:module'
import { join } from 'node:path'

// Packages lie in the working folder, this file does not.
const require = createRequire(join(process.cwd(), 'package.json'))
const { MavLinkPacketSplitter, MavLinkPacketParser } = require('node-mavlink')
const { minimal, common } = require('mavlink-mappings')

const registry = { ...minimal.REGISTRY, ...common.REGISTRY }
const [frames, lines] = process.argv.slice(2)
const expected = readFileSync(lines, 'utf8').trim().split('\n').map(line => JSON.parse(line))
const counts = {}
let next = 0

function fail(message) {
  console.error(`message ${next}: ${message}`)
  process.exit(1)
}

function equal(ours, theirs) {
  if (Array.isArray(ours)) {
    return ours.length === theirs.length && ours.every((value, i) => equal(value, theirs[i]))
  }
  if (typeof theirs === 'bigint') {
    return BigInt(ours) === theirs
  }
  return Math.fround(ours) === Math.fround(theirs)
}

const reader = createReadStream(frames).pipe(new MavLinkPacketSplitter()).pipe(new MavLinkPacketParser())
reader.on('data', packet => {
  const { msgid, ...fields } = expected[next] ?? fail('there is one too many')
  if (packet.header.msgid !== msgid) {
    fail(`is of kind ${packet.header.msgid}, not ${msgid}`)
  }
  if (packet.header.magic !== 0xfd || packet.header.sysid !== 42 || packet.header.compid !== 196 ||
      packet.header.seq !== next % 256) {
    fail(`has the header ${JSON.stringify(packet.header)}`)
  }
  const data = packet.protocol.data(packet.payload, registry[msgid])
  for (const [name, value] of Object.entries(fields)) {
    if (!equal(value, data[name])) {
      fail(`${name} is ${data[name]}, not ${value}`)
    }
  }
  counts[registry[msgid].MSG_NAME] = (counts[registry[msgid].MSG_NAME] ?? 0) + 1
  next += 1
})
reader.on('end', () => {
  if (next !== expected.length) {
    fail(`missing, of ${expected.length}`)
  }
  console.log(JSON.stringify(counts))
})
