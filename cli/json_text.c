/* SPDX-License-Identifier: MIT */
#include "json_text.h"

#include "fanal/base.h"

#include <stdlib.h>
#include <string.h>

json_t *json_text(const char *text) {
    if (!text) return json_null();
    json_t *json = json_string(text);
    if (json) return json;
    char *copy = strdup(text);
    if (!copy) return NULL;
    fnl_text_clean(copy);
    json = json_string(copy);
    free(copy);
    return json;
}

/* DEL is ASCII, and JSON's writers leave it as it is. */
static char *escape_delete(char *text) {
    static const char escape[] = "\\u007f";
    size_t count = 0;
    for (const char *at = text; (at = strchr(at, 0x7f)); at++) count++;
    char *escaped = malloc(strlen(text) + count * (sizeof escape - 2) + 1), *out = escaped;
    for (const char *at = text; escaped && *at; at++) {
        if (*at == 0x7f) out = stpcpy(out, escape);
        else *out++ = *at;
    }
    if (escaped) *out = 0;
    free(text);
    return escaped;
}

char *json_text_write(const json_t *json, size_t flags) {
    char *text = json_dumps(json, flags);
    if (!text) return NULL;
    for (char *at = text; *at; at++)
        if (*at == '\n') *at = ' '; /* JSON's own line breaks; those of strings are escaped */
    const bool controls = fnl_text_clean(text);
    free(text);
    text = json_dumps(json, controls ? flags | JSON_ENSURE_ASCII : flags);
    return text && controls ? escape_delete(text) : text;
}

bool json_text_print(const json_t *json, size_t flags) {
    char *text = json ? json_text_write(json, flags) : NULL;
    const bool good = text && fputs(text, stdout) >= 0 && fputc('\n', stdout) != EOF;
    free(text);
    return good;
}
