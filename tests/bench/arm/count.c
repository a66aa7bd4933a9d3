/* count.so: a plugin of qemu-user (interface version 1) that counts how often each translated block
 * of a 64-bit ARM program runs between two marks, `hint #120` and `hint #121`. Debian ships no
 * header of the interface: what is used of it is declared here (qemu 7.2,
 * include/qemu/qemu-plugin.h).
 *
 * -plugin count.so,out=FILE: for each pair of marks a line `section`, and for each block that ran a
 * line `ADDRESS INSTRUCTIONS TIMES`, the address in hexadecimal. One thread. */
#include <inttypes.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef uint64_t qemu_plugin_id_t;
struct qemu_plugin_tb;
struct qemu_plugin_insn;
enum { QEMU_PLUGIN_CB_NO_REGS = 0, QEMU_PLUGIN_INLINE_ADD_U64 = 0 };

extern void qemu_plugin_register_vcpu_tb_trans_cb(qemu_plugin_id_t id,
                                                  void (*called)(qemu_plugin_id_t,
                                                                 struct qemu_plugin_tb*));
extern void qemu_plugin_register_vcpu_tb_exec_inline(struct qemu_plugin_tb* tb, int op, void* at,
                                                     uint64_t value);
extern void qemu_plugin_register_vcpu_insn_exec_cb(struct qemu_plugin_insn* insn,
                                                   void (*called)(unsigned, void*), int flags,
                                                   void* data);
extern size_t qemu_plugin_tb_n_insns(const struct qemu_plugin_tb* tb);
extern uint64_t qemu_plugin_tb_vaddr(const struct qemu_plugin_tb* tb);
extern struct qemu_plugin_insn* qemu_plugin_tb_get_insn(const struct qemu_plugin_tb* tb,
                                                        size_t index);
extern const void* qemu_plugin_insn_data(const struct qemu_plugin_insn* insn);

#define EXPORTED __attribute__((visibility("default")))
EXPORTED int qemu_plugin_version = 1;

static const uint32_t kBegin = 0xD503201F | 120U << 5;
static const uint32_t kEnd = 0xD503201F | 121U << 5;

/* Translated blocks, newest first; a block that is translated again is another one. */
struct block {
  struct block* next;
  uint64_t address;
  uint64_t instructions;
  uint64_t times;
};
static struct block* blocks;
static FILE* out;

static void begin(unsigned cpu, void* data) {
  (void)cpu;
  (void)data;
  for (struct block* b = blocks; b != NULL; b = b->next) {
    b->times = 0;
  }
}

static void end(unsigned cpu, void* data) {
  (void)cpu;
  (void)data;
  fprintf(out, "section\n");
  for (const struct block* b = blocks; b != NULL; b = b->next) {
    if (b->times != 0) {
      fprintf(out, "%" PRIx64 " %" PRIu64 " %" PRIu64 "\n", b->address, b->instructions, b->times);
    }
  }
  fflush(out);
}

static void translated(qemu_plugin_id_t id, struct qemu_plugin_tb* tb) {
  (void)id;
  struct block* const b = calloc(1, sizeof *b);
  if (b == NULL) {
    abort();
  }
  *b = (struct block){blocks, qemu_plugin_tb_vaddr(tb), qemu_plugin_tb_n_insns(tb), 0};
  blocks = b;
  qemu_plugin_register_vcpu_tb_exec_inline(tb, QEMU_PLUGIN_INLINE_ADD_U64, &b->times, 1);
  for (size_t i = 0; i < b->instructions; ++i) {
    struct qemu_plugin_insn* const insn = qemu_plugin_tb_get_insn(tb, i);
    uint32_t word = 0;
    memcpy(&word, qemu_plugin_insn_data(insn), sizeof word);
    if (word == kBegin || word == kEnd) {
      qemu_plugin_register_vcpu_insn_exec_cb(insn, word == kBegin ? begin : end,
                                             QEMU_PLUGIN_CB_NO_REGS, NULL);
    }
  }
}

EXPORTED int qemu_plugin_install(qemu_plugin_id_t id, const void* info, int argc, char** argv) {
  (void)info;
  for (int i = 0; i < argc; ++i) {
    if (strncmp(argv[i], "out=", 4) == 0) {
      out = fopen(argv[i] + 4, "w");
    }
  }
  if (out == NULL) {
    fprintf(stderr, "count: no file to write to: give out=FILE\n");
    return 1;
  }
  qemu_plugin_register_vcpu_tb_trans_cb(id, translated);
  return 0;
}
