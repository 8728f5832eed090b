/* SPDX-License-Identifier: MIT */
/** Ctrl-C and SIGTERM while a command works. */
#ifndef FNL_CLI_INTERRUPT_H
#define FNL_CLI_INTERRUPT_H

#include <stdbool.h>

/** While on, Ctrl-C and SIGTERM only set what interrupt_seen() tells; the second one ends the program at once. */
void interrupt_catch(bool on);
bool interrupt_seen(void);

#endif
