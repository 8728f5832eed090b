/* SPDX-License-Identifier: MIT */
#include "base/ranges.h"

void ranges_finish(const fnl_host *host, struct ranges *ranges) {
    array_free(host, &ranges->gaps);
    ranges->end = 0;
}

static void remove_gap(struct ranges *ranges, uint32_t at) {
    ranges->gaps.count--;
    memmove(ranges->gaps.data + at, ranges->gaps.data + at + 1, (ranges->gaps.count - at) * sizeof *ranges->gaps.data);
}

uint32_t ranges_take(struct ranges *ranges, uint32_t count) {
    for (uint32_t i = 0; i < ranges->gaps.count; i++) {
        struct range *gap = &ranges->gaps.data[i];
        if (gap->count < count) continue;
        uint32_t first = gap->first;
        gap->first += count;
        gap->count -= count;
        if (gap->count == 0) remove_gap(ranges, i);
        return first;
    }
    if (count >= RANGES_NONE - ranges->end) return RANGES_NONE;
    ranges->end += count;
    return ranges->end - count;
}

void ranges_give(const fnl_host *host, struct ranges *ranges, uint32_t first, uint32_t count) {
    if (count == 0) return;
    uint32_t at = 0; /* the first gap behind the run */
    for (uint32_t low = 0, high = ranges->gaps.count; low < high; at = low) {
        uint32_t middle = low + (high - low) / 2;
        if (ranges->gaps.data[middle].first < first)
            low = middle + 1;
        else
            high = middle;
    }
    struct range *gaps = ranges->gaps.data;
    bool joins_before = at > 0 && gaps[at - 1].first + gaps[at - 1].count == first;
    bool joins_behind = at < ranges->gaps.count && first + count == gaps[at].first;
    if (joins_before) {
        gaps[at - 1].count += count + (joins_behind ? gaps[at].count : 0);
        if (joins_behind) remove_gap(ranges, at);
        at--;
    } else if (joins_behind) {
        gaps[at].first = first;
        gaps[at].count += count;
    } else {
        if (!array_reserve(host, &ranges->gaps, (uint64_t)ranges->gaps.count + 1)) return;
        gaps = ranges->gaps.data;
        memmove(gaps + at + 1, gaps + at, (ranges->gaps.count - at) * sizeof *gaps);
        gaps[at] = (struct range){first, count};
        ranges->gaps.count++;
    }
    if (gaps[at].first + gaps[at].count == ranges->end) { /* the last one; nothing is behind it */
        ranges->end = gaps[at].first;
        remove_gap(ranges, at);
    }
}
