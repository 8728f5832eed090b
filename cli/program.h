/* SPDX-License-Identifier: MIT */
#ifndef FNL_CLI_PROGRAM_H
#define FNL_CLI_PROGRAM_H

/** The commit that the program was built from, "-dirty" behind it where files were changed; "unknown" outside of its repository. */
extern const char program_commit[];

#endif
