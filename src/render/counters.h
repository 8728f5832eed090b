/* SPDX-License-Identifier: MIT */
/**
 * The numbers of techniques, one row each. A row stands in the file of the order that makes the number (struct order), or of the step that several
 * orders share (struct frame_step). While a frame is declared, the step says where the GPU counts (COUNTERS_COPY) or what the CPU knows
 * (counters_note); everything else follows from the rows.
 */
#ifndef FNL_RENDER_COUNTERS_H
#define FNL_RENDER_COUNTERS_H

#include "fanal/stats.h"
#include "graph/graph.h"

struct fnl_renderer;
struct renderer_view;
struct view_made;
struct frame_counts; /* what the GPU writes for the CPU for each view of a frame, for all tables: see COUNTS; 0 if the frame does not count it */
struct view_counters;

/** A view of a frame that the device has finished. */
struct counted {
    const struct fnl_renderer *r;
    const struct renderer_view *view;
    const struct view_made *made;
    const struct frame_counts *counts;
    const struct view_counters *numbers; /* the view's */
    const fnl_frame *frame;
};

/**
 * A row. Its number is what the GPU counted (COUNTED), or what `find` makes of that, or else what the CPU noted. A frame has it if that was
 * copied or noted and the frame meets `needs`.
 */
struct counter {
    const char *key, *unit, *help;
    const char *needs; /* as in fnl_counter; NULL: nothing */
    fnl_counter_kind kind;
    /* The number is the sum of these 32-bit words of the table's part of struct frame_counts. Size 0: see above. */
    uint32_t offset, size;
    /* Changes `value`, which is what was noted, or 0; false: the frame does not have the number. */
    bool (*find)(const struct counted *counted, uint64_t *value);
};
#define COUNTED(table, member) COUNTED_SUM(table, member, sizeof(((struct table##_counts *)0)->member) / 4)
/** The words from `member` on. */
#define COUNTED_SUM(table, member, words) .offset = offsetof(struct table##_counts, member), .size = 4 * (words)
/** By counters_note() alone. */
#define NOTED .size = 0

/** The numbers of a technique, `const struct counter_table counters_NAME`. The GPU writes struct NAME_counts for them, 32-bit words. */
struct counter_table {
    const struct counter *rows;
    uint32_t row_count, counts_size;
};
#define COUNTER_TABLE(rows_) {.rows = rows_, .row_count = COUNT_OF(rows_)}
#define COUNTER_TABLE_COUNTED(rows_, table) {.rows = rows_, .row_count = COUNT_OF(rows_), .counts_size = sizeof(struct table##_counts)}

enum { COUNTERS_COPIES = 24, COUNTERS_NOTES = 24 };

/** Where the numbers of one view are, as noted while the view was declared. */
struct view_counters {
    struct counters_copy {
        graph_buffer from;
        uint64_t from_offset, to_offset, size;
    } copies[COUNTERS_COPIES];
    struct counters_noted {
        const struct counter *row;
        uint64_t value;
    } notes[COUNTERS_NOTES];
    uint32_t copy_count, note_count;
};

/** Copies a member of struct NAME_counts from `buffer` when the frame is over. Does nothing without a buffer (id 0). */
#define COUNTERS_COPY(f, buffer, from_offset, table, member)                                                                                  \
    counters_copy(&(f)->r->host, &(f)->made->numbers, buffer, from_offset, counters_place(&counters_##table) + offsetof(struct table##_counts, member), \
                  sizeof(((struct table##_counts *)0)->member))
void counters_copy(const fnl_host *host, struct view_counters *c, graph_buffer from, uint64_t from_offset, uint64_t to_offset, uint64_t size);
/** A number that the CPU knows; or the part of it that it knows, for counter.find. */
#define counters_note(f, key, value) counters_note_in(&(f)->r->host, &(f)->made->numbers, key, value)
void counters_note_in(const fnl_host *host, struct view_counters *c, const char *key, uint64_t value);

/** A table's part of what the GPU wrote for a view. */
#define COUNTS(counts, table) ((const struct table##_counts *)counters_part(counts, counters_place(&counters_##table)))
static inline const void *counters_part(const struct frame_counts *counts, uint64_t place) { return (const char *)counts + place; }
/** For counter.find: whether the frame copied a member. */
#define COUNTED_HAS(counted, table, member) counters_copied(counted, counters_place(&counters_##table) + offsetof(struct table##_counts, member))
bool counters_copied(const struct counted *counted, uint64_t offset);

/**
 * The table at an index: tables of steps, then of shadow methods, then of shading paths. If several paths share a table, the first of them has it;
 * `out_shadings` gets the bits of all of them. NULL: no table.
 */
const struct counter_table *counter_table_at(uint32_t index, uint32_t *out_shadings);
uint32_t counter_table_count(void);
/** Where a table's part of struct frame_counts begins, and the size of all parts; bytes. */
uint64_t counters_place(const struct counter_table *table);
uint64_t counters_size(void);

/** The number of rows of all techniques. */
uint32_t counters_total(void);
/** Writes those that the view has, counters_total() at most; returns how many. */
uint32_t counters_query(const struct counted *counted, fnl_counter *out);

#endif
