/* SPDX-License-Identifier: MIT */
#include "loading.h"

#include "arguments.h"

#include <errno.h>
#include <stdlib.h>

bool loading_has(int option) { return option >= LOADING_LENIENT && option < LOADING_END; }

static bool parse_bytes(const char *text, uint64_t *out) {
    static const char wanted[] = "a number of bytes such as 65536, 512K, 300M or 4G";
    char *end;
    if (*text < '0' || *text > '9') return argument_bad("max-memory", text, wanted);
    errno = 0;
    unsigned long long number = strtoull(text, &end, 10);
    unsigned shift = *end == 'K' ? 10 : *end == 'M' ? 20 : *end == 'G' ? 30 : 0;
    if (shift) end++;
    if (*end || errno || number > UINT64_MAX >> shift) return argument_bad("max-memory", text, wanted);
    *out = (uint64_t)number << shift;
    return true;
}

bool loading_parse(int option, const char *value, fnl_load_params *out) {
    if (option == LOADING_LENIENT) out->lenient = true;
    if (option == LOADING_CONFINE) out->confine = true;
    return option != LOADING_MAX_MEMORY || parse_bytes(value, &out->max_memory);
}
