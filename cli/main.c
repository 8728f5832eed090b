/* SPDX-License-Identifier: MIT */
#include "commands.h"
#include "output.h"

#include "fanal/base.h"

#include <stdio.h>
#include <string.h>

static const struct {
    const char *name, *summary;
    int (*run)(int argc, char **argv);
} commands[] = {
    {"render", "render a scene and write the picture and the numbers", command_render},
#ifdef FANAL_VIEW
    {"view", "show a scene in a window", command_view},
#endif
#ifdef FANAL_XR
    {"xr", "show a scene in a headset, by OpenXR", command_xr},
#endif
    {"cave", "render what is seen through the walls of a CAVE, on several devices and machines", command_cave},
    {"trace", "trace a scene with rays on the CPU: the truth to compare pictures with", command_trace},
    {"bench", "measure light lists and shading paths side by side", command_bench},
    {"info", "print what a scene consists of", command_info},
    {"devices", "list the Vulkan devices and what each offers", command_devices},
    {"compare", "measure how far two pictures are apart", command_compare},
    {"compress", "compress pictures of high dynamic range as BC6H, and decode them", command_compress},
};

enum { COMMAND_COUNT = sizeof commands / sizeof *commands };

static void print_help(FILE *out) {
    fputs("Fanal renders scenes with thousands of lights on Vulkan.\n\nUsage: fanal COMMAND [OPTIONS] …\n\n", out);
    for (int i = 0; i < COMMAND_COUNT; i++) fprintf(out, "  %-10s %s\n", commands[i].name, commands[i].summary);
    fputs("\n'fanal COMMAND --help' describes a command and its options; 'fanal --version' prints the version.\n\n"
          "Example:\n  fanal render \"builtin:city?lights=4096\" --size 1280x720 -o city.png\n",
          out);
}

static int run(int argc, char **argv) {
    if (argc < 2) {
        print_help(stderr);
        return 2;
    }
    if (strcmp(argv[1], "--help") == 0 || strcmp(argv[1], "-h") == 0 || strcmp(argv[1], "help") == 0) {
        print_help(stdout);
        return 0;
    }
    if (strcmp(argv[1], "--version") == 0) {
        printf("fanal %s\n", fnl_version());
        return 0;
    }
    for (int i = 0; i < COMMAND_COUNT; i++)
        if (strcmp(argv[1], commands[i].name) == 0) return commands[i].run(argc - 1, argv + 1);
    fprintf(stderr, "fanal: error: there is no command '%s'; see 'fanal --help'\n", argv[1]);
    return 2;
}

int main(int argc, char **argv) {
    output_guard_streams();
    int status = run(argc, argv);
    return output_flush() ? status : 2;
}
