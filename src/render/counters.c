/* SPDX-License-Identifier: MIT */
#include "render/counters.h"

#include "base/check.h"
#include "fanal/options.h"

/* ---- the tables ---- */

uint32_t counters_total(void) {
    uint32_t count = 0, shadings;
    for (uint32_t t = 0; t < counter_table_count(); t++) {
        const struct counter_table *table = counter_table_at(t, &shadings);
        count += table ? table->row_count : 0;
    }
    return count;
}

static const struct counter *find(const char *key) {
    uint32_t shadings;
    for (uint32_t t = 0; t < counter_table_count(); t++) {
        const struct counter_table *table = counter_table_at(t, &shadings);
        for (uint32_t i = 0; table && i < table->row_count; i++)
            if (strcmp(table->rows[i].key, key) == 0) return &table->rows[i];
    }
    return NULL;
}

static fnl_counter describe(const struct counter *row, uint32_t shadings) {
    return (fnl_counter){.key = row->key,
                         .help = row->help,
                         .kind = row->kind,
                         .unit = row->unit,
                         .shadings = shadings,
                         .needs = row->needs ? row->needs : ""};
}

bool fnl_counter_query(uint32_t index, fnl_counter *out) {
    uint32_t shadings;
    if (check_handle(__func__, "out", out) != FNL_OK) return false;
    for (uint32_t t = 0; t < counter_table_count(); t++) {
        const struct counter_table *table = counter_table_at(t, &shadings);
        if (!table) continue;
        if (index < table->row_count) {
            *out = describe(&table->rows[index], shadings);
            return true;
        }
        index -= table->row_count;
    }
    return false;
}

/* ---- while a frame is declared ---- */

void counters_copy(const fnl_host *host, struct view_counters *c, graph_buffer from, uint64_t from_offset, uint64_t to_offset, uint64_t size) {
    if (!from.id) return;
    if (c->copy_count == COUNTERS_COPIES) {
        log_error(host, "a frame has more counters to copy than the %d that there is room for", COUNTERS_COPIES);
        return;
    }
    c->copies[c->copy_count++] = (struct counters_copy){from, from_offset, to_offset, size};
}

void counters_note_in(const fnl_host *host, struct view_counters *c, const char *key, uint64_t value) {
    const struct counter *row = find(key);
    if (!row || c->note_count == COUNTERS_NOTES) {
        log_error(host, row ? "there is no room for the counter %s" : "there is no counter %s", key);
        return;
    }
    c->notes[c->note_count++] = (struct counters_noted){row, value};
}

/* ---- when it is over ---- */

bool counters_copied(const struct counted *counted, uint64_t offset) {
    const struct view_counters *c = counted->numbers;
    for (uint32_t i = 0; i < c->copy_count; i++)
        if (offset >= c->copies[i].to_offset && offset - c->copies[i].to_offset < c->copies[i].size) return true;
    return false;
}

static bool noted(const struct counted *counted, const struct counter *row, uint64_t *out) {
    const struct view_counters *c = counted->numbers;
    *out = 0;
    for (uint32_t i = 0; i < c->note_count; i++) {
        if (c->notes[i].row != row) continue;
        *out = c->notes[i].value;
        return true;
    }
    return false;
}

/* Whether one of some words between commas is `value`. */
static bool is_among(const char *words, const char *value) {
    const size_t length = strlen(value);
    for (; words; words = strchr(words, ',')) {
        words += *words == ',';
        if (strncmp(words, value, length) == 0 && (words[length] == 0 || words[length] == ',')) return true;
    }
    return false;
}

/* "count-lights", "dais.mode=list" or "shadows=maps,hybrid". */
static bool has_needs(const fnl_frame *frame, const char *needs) {
    char key[64], value[64];
    if (!needs) return true;
    size_t length = strcspn(needs, "=");
    snprintf(key, sizeof key, "%.*s", (int)length, needs);
    if (fnl_frame_get(frame, key, value, sizeof value) == 0) return false;
    if (needs[length]) return is_among(needs + length + 1, value);
    return strcmp(value, "off") != 0 && strcmp(value, "0") != 0;
}

/* `place`: of the table in the counts. */
static bool query(const struct counted *counted, uint64_t place, const struct counter *row, uint64_t *out) {
    bool has_note = noted(counted, row, out);
    if (!has_needs(counted->frame, row->needs)) return false;
    if (row->find) return row->find(counted, out);
    if (row->size == 0) return has_note;
    if (!counters_copied(counted, place + row->offset)) return false;
    for (uint32_t i = 0; i < row->size; i += 4) {
        uint32_t word;
        memcpy(&word, (const char *)counted->counts + place + row->offset + i, sizeof word);
        *out += word;
    }
    return true;
}

uint32_t counters_query(const struct counted *counted, fnl_counter *out) {
    uint32_t count = 0, shadings;
    uint64_t value;
    for (uint32_t t = 0; t < counter_table_count(); t++) {
        const struct counter_table *table = counter_table_at(t, &shadings);
        const uint64_t place = counters_place(table);
        for (uint32_t i = 0; table && i < table->row_count && shadings >> counted->frame->shading & 1; i++) {
            if (!query(counted, place, &table->rows[i], &value)) continue;
            out[count] = describe(&table->rows[i], shadings);
            out[count++].value = value;
        }
    }
    return count;
}
