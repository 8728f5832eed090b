/* SPDX-License-Identifier: MIT */
#include "json_text.h"
#include "print.h"

#include <inttypes.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

static char text[512];

__attribute__((format(printf, 1, 2))) static const char *printed(const char *format, ...) {
    va_list arguments;
    memset(text, 0, sizeof text);
    FILE *file = fmemopen(text, sizeof text, "w");
    assert_non_null(file);
    va_start(arguments, format);
    const int length = vfprintf(file, format, arguments);
    assert_int_equal(length, ftell(file));
    va_end(arguments);
    fclose(file);
    return text;
}

/* With text that needs no replacement it prints what the C library prints. */
#define assert_as_libc(...)                                                                                                 \
    do {                                                                                                                    \
        char expected[512];                                                                                                 \
        snprintf(expected, sizeof expected, __VA_ARGS__);                                                                   \
        assert_string_equal(printed(__VA_ARGS__), expected);                                                                \
    } while (0)

static void test_prints_as_printf_does(void **state) {
    (void)state;
    assert_as_libc("plain\n");
    assert_as_libc("%d %i %u %x %X %o, %5d|%-5d|%05d|%+d", -3, 4, 4000000000u, 255u, 255u, 8u, 12, 12, 12, 12);
    assert_as_libc("%ld %lu %lld %llu %zu %jd %" PRIu64, -5L, 6UL, -1099511627776LL, ~0ULL, (size_t)9, (intmax_t)-7, UINT64_MAX);
    assert_as_libc("%hhx %hu", (unsigned char)200, (unsigned short)60000);
    assert_as_libc("%f %.3g %e %10.2f %-9.1f| %a %G %5.1f%%", 1.5, 2.25, 1e30, 3.14159, 2.0, 0.5, 1e-9, 12.5);
    assert_as_libc("%s|%10s|%-10s|%.2s|%*s|%-*s|%.*s|%.*s", "a", "b", "c", "defg", 6, "h", 6, "i", 3, "jklmn", -1, "whole");
    assert_as_libc("%c%c%c", 'a', ' ', '%');
    assert_as_libc("äö %s", "ü€😀");
}

static void test_arguments_cannot_control_a_terminal(void **state) {
    (void)state;
    assert_string_equal(printed("\033[K%s\n", "a\033]52;c;AAAA\a\r\n\tb\177"), "\033[Ka?]52;c;AAAA????b?\n"); /* the format may */
    assert_string_equal(printed("%s", "c1 \xc2\x9b\x9b bidi \xe2\x80\xae\xe2\x81\xa6 line \xe2\x80\xa8"), "c1 ?? bidi ?? line ?");
    assert_string_equal(printed("%c|%c", '\033', '\n'), "?|?");
    assert_string_equal(printed("%.4s|%.5s", "ab€", "ab€"), "ab|ab€"); /* no half of a character */
    const char piece[3] = {'a', '\n', 'c'};
    assert_string_equal(printed("%.*s", 3, piece), "a?c"); /* no zero ends it */
}

/* bash reads each word as the text that it was made of, and no byte of it acts before. */
static void test_words_of_a_shell(void **state) {
    (void)state;
    static const char *const texts[] = {"plain", "", "two words", "v'$(touch x)'", "'", "''", "\\'", "a`b`\"$HOME\"", "~", "#no", "!!", "-x", "=ls", "ä€",
                                        "line\nbreak\033[201~\r", "\xff'\\ $(x)\1" "23", "\xe2\x80\xae" "evil", "\xc2\x9b" "31m", "*?[a]{b,c}", "tab\t"};
    for (size_t i = 0; i < sizeof texts / sizeof *texts; i++) {
        char *word = print_shell_word(texts[i]), got[128] = "";
        assert_non_null(word);
        for (const char *c = word; *c; c++) assert_false((unsigned char)*c < 0x20 || *c == 0x7f);
        assert_string_equal(printed("%s", word), word);
        FILE *file = fopen("print_test.sh", "w");
        assert_non_null(file);
        fprintf(file, "set -- %s\n", word);
        fputs("[ $# = 1 ] && printf %s. \"$1\"\n", file);
        fclose(file);
        FILE *shell = popen("bash ./print_test.sh", "r");
        assert_non_null(shell);
        got[fread(got, 1, sizeof got - 1, shell)] = 0;
        assert_int_equal(pclose(shell), 0);
        remove("print_test.sh");
        assert_int_equal(strlen(got), strlen(texts[i]) + 1);
        assert_memory_equal(got, texts[i], strlen(texts[i]));
        free(word);
    }
    char *word = print_shell_word("builtin:hall?lights=3");
    assert_string_equal(word, "'builtin:hall?lights=3'");
    free(word);
    word = print_shell_word("a/b-1.gltf");
    assert_string_equal(word, "a/b-1.gltf");
    free(word);
}

static void test_json_holds_the_same_and_is_safe(void **state) {
    (void)state;
    json_t *json = json_array(), *null = json_text(NULL);
    assert_true(json_is_null(null));
    json_decref(null);
    assert_int_equal(json_array_append_new(json, json_text("\033\n\177\xc2\x9b\xe2\x80\xae€")), 0);
    char *line = json_text_write(json, JSON_COMPACT);
    assert_non_null(line);
    for (const char *c = line; *c; c++) assert_in_range(*c, 0x20, 0x7e);
    json_t *again = json_loads(line, 0, NULL);
    assert_true(json_equal(json, again));
    json_decref(again);
    free(line);
    assert_int_equal(json_array_set_new(json, 0, json_text("a\xff€")), 0); /* not UTF-8 */
    line = json_text_write(json, JSON_COMPACT);
    assert_string_equal(line, "[\"a?€\"]");
    free(line);
    json_decref(json);
}

int main(void) {
    char folder[] = "/tmp/fanal-print-XXXXXX"; /* what a word that is not quoted would do, it does there */
    if (!mkdtemp(folder) || chdir(folder) != 0) return 1;
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_prints_as_printf_does),
        cmocka_unit_test(test_arguments_cannot_control_a_terminal),
        cmocka_unit_test(test_words_of_a_shell),
        cmocka_unit_test(test_json_holds_the_same_and_is_safe),
    };
    const int failed = cmocka_run_group_tests(tests, NULL, NULL);
    return rmdir(folder) == 0 ? failed : 1;
}
