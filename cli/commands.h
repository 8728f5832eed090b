/* SPDX-License-Identifier: MIT */
/** The subcommands. Each takes its own arguments, argv[0] being its name, and returns the exit status: 0, 1 (compare: over a limit;
 * bench: a wrong picture), 2, or 130 (bench, cave, render, trace: interrupted). */
#ifndef FNL_CLI_COMMANDS_H
#define FNL_CLI_COMMANDS_H

int command_bench(int argc, char **argv);
int command_cave(int argc, char **argv);
int command_compare(int argc, char **argv);
int command_compress(int argc, char **argv);
int command_devices(int argc, char **argv);
int command_info(int argc, char **argv);
int command_render(int argc, char **argv);
int command_trace(int argc, char **argv);
#ifdef FANAL_VIEW
int command_view(int argc, char **argv);
#endif
#ifdef FANAL_XR
int command_xr(int argc, char **argv);
#endif

#endif
