/* SPDX-License-Identifier: MIT */
/*
 * check_schema SCHEMA FILE…: whether each JSON text of the files (a text, or one a line) is by the schema, and whether together they show every property that
 * the schema knows. Of JSON Schema it knows what docs/stats.schema.json uses: type, const, enum, minimum, properties, required, additionalProperties: false or a schema, $defs,
 * items, minItems, maxItems, $ref to a place in itself, and description; any other keyword is an error, so that none is passed over.
 */
#include <jansson.h>
#include <stdbool.h>
#include <stdio.h>
#include <string.h>

static json_t *root; /* the whole schema */
static json_t *seen; /* places of properties that some text had */
static int failures;

static bool fail(const char *place, const char *problem) {
    fprintf(stderr, "check_schema: %s: %s\n", *place ? place : "/", problem);
    failures++;
    return false;
}

static bool is_of_type(const json_t *value, const char *type) {
    return strcmp(type, "object") == 0    ? json_is_object(value)
           : strcmp(type, "array") == 0   ? json_is_array(value)
           : strcmp(type, "string") == 0  ? json_is_string(value)
           : strcmp(type, "integer") == 0 ? json_is_integer(value)
           : strcmp(type, "number") == 0  ? json_is_number(value)
           : strcmp(type, "boolean") == 0 ? json_is_boolean(value)
                                          : strcmp(type, "null") == 0 && json_is_null(value);
}

static bool type_fits(const json_t *value, const json_t *type) {
    size_t index;
    json_t *one;
    if (json_is_string(type)) return is_of_type(value, json_string_value(type));
    json_array_foreach(type, index, one) if (is_of_type(value, json_string_value(one))) return true;
    return false;
}

static bool is_among(const json_t *value, const json_t *list) {
    size_t index;
    json_t *one;
    json_array_foreach(list, index, one) if (json_equal(value, one)) return true;
    return false;
}

static void check(const json_t *value, json_t *schema, const char *place);

/* What a schema stands for: itself, or the place that its $ref names, "#/properties/x". */
static json_t *resolve(json_t *schema) {
    const char *reference = json_string_value(json_object_get(schema, "$ref"));
    char path[256];
    if (!reference) return schema;
    snprintf(path, sizeof path, "%s", reference);
    json_t *at = root;
    strtok(path, "/");
    for (char *key; at && (key = strtok(NULL, "/"));) at = json_object_get(at, key);
    if (!at) fail(reference, "is a place that the schema does not have");
    return at ? at : schema;
}

/* `others` is the schema of properties that have none, or NULL. */
static void check_object(const json_t *value, const json_t *properties, json_t *others, const char *place) {
    const char *key;
    json_t *member;
    json_object_foreach((json_t *)value, key, member) {
        char inner[512];
        snprintf(inner, sizeof inner, "%s/%s", place, key);
        json_t *schema = json_object_get(properties, key);
        if (!schema && others) {
            check(member, others, inner);
            continue;
        }
        if (!schema)
            fail(inner, "the schema has no such property");
        else
            check(member, schema, inner);
        json_object_set_new(seen, inner, json_true());
    }
}

static void check(const json_t *value, json_t *schema, const char *place) {
    schema = resolve(schema);
    const char *keyword;
    json_t *wanted, *properties = json_object_get(schema, "properties"), *others = json_object_get(schema, "additionalProperties");
    if (!type_fits(value, json_object_get(schema, "type"))) {
        fail(place, "is of another type, or the schema names none");
        return;
    }
    if (json_is_object(value) && !json_is_false(others) && !json_is_object(others))
        fail(place, "the schema lets additional properties pass");
    if (json_is_object(value)) check_object(value, properties, json_is_object(others) ? others : NULL, place);
    json_object_foreach(schema, keyword, wanted) {
        size_t index, size = json_array_size(value);
        json_t *item;
        if (strcmp(keyword, "const") == 0) {
            if (!json_equal(value, wanted)) fail(place, "is not the constant");
        } else if (strcmp(keyword, "enum") == 0) {
            if (!is_among(value, wanted)) fail(place, "is none of the values");
        } else if (strcmp(keyword, "minimum") == 0) {
            if (json_is_number(value) && json_number_value(value) < json_number_value(wanted)) fail(place, "is too small");
        } else if (strcmp(keyword, "minItems") == 0) {
            if (json_is_array(value) && size < (size_t)json_integer_value(wanted)) fail(place, "has too few items");
        } else if (strcmp(keyword, "maxItems") == 0) {
            if (json_is_array(value) && size > (size_t)json_integer_value(wanted)) fail(place, "has too many items");
        } else if (strcmp(keyword, "required") == 0) {
            json_array_foreach(wanted, index, item) if (json_is_object(value) && !json_object_get(value, json_string_value(item)))
                fail(place, json_string_value(item));
        } else if (strcmp(keyword, "items") == 0) {
            char inner[512];
            snprintf(inner, sizeof inner, "%s/*", place);
            if (json_is_array(value)) json_array_foreach((json_t *)value, index, item) check(item, wanted, inner);
        } else if (!strstr(" type properties additionalProperties description title $schema $id $defs ", keyword)) {
            fail(keyword, "is a keyword that check_schema does not know");
        }
    }
}

/* The other way round: what the schema tells of, some text must have had, and each object must demand all it tells of. */
static void check_seen(json_t *schema, const char *place) {
    schema = resolve(schema);
    const char *key;
    json_t *inner, *properties = json_object_get(schema, "properties"), *items = json_object_get(schema, "items");
    char name[512];
    if (properties && json_object_size(properties) != json_array_size(json_object_get(schema, "required")))
        fail(place, "the schema does not demand each property");
    json_object_foreach(properties, key, inner) {
        snprintf(name, sizeof name, "%s/%s", place, key);
        if (!json_object_get(seen, name)) fail(name, "is in the schema, but in no text");
        check_seen(inner, name);
    }
    snprintf(name, sizeof name, "%s/*", place);
    if (items) check_seen(items, name);
}

int main(int argc, char **argv) {
    json_error_t error;
    json_t *schema = argc > 2 ? json_load_file(argv[1], 0, &error) : NULL;
    if (!schema) {
        fprintf(stderr, "check_schema: %s\n", argc > 2 ? error.text : "give a schema and files");
        return 2;
    }
    root = schema;
    seen = json_object();
    int texts = 0;
    for (int i = 2; i < argc; i++) {
        FILE *file = fopen(argv[i], "r");
        json_t *value = file ? json_loadf(file, JSON_DISABLE_EOF_CHECK, &error) : NULL;
        if (!value) fail(argv[i], file ? error.text : "cannot be opened");
        for (; value; value = json_loadf(file, JSON_DISABLE_EOF_CHECK, &error)) {
            check(value, schema, "");
            json_decref(value);
            texts++;
            int next;
            while ((next = getc(file)) == '\n') continue;
            if (next == EOF) break;
            ungetc(next, file);
        }
        if (file) fclose(file);
    }
    check_seen(schema, "");
    printf("%d texts, %d faults\n", texts, failures);
    json_decref(seen);
    json_decref(schema);
    return failures > 0;
}
