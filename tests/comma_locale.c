/* SPDX-License-Identifier: MIT */
/** A library whose locale has a decimal comma, for LD_PRELOAD: as one that a program loads and that calls setlocale. The folder: FANAL_TEST_FOLDER. */
#include "comma_locale.h"

__attribute__((constructor)) static void set_locale(void) {
    const char *folder = getenv("FANAL_TEST_FOLDER");
    if (!folder || !comma_locale_set(folder)) abort();
}
